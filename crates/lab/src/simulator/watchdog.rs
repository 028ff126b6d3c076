//! What a client does that hears nothing from the service: it goes on for a while, then comes to rest.

use std::ops::ControlFlow;
use std::thread::sleep;
use std::time::{Duration, Instant};

use revprio_api::ClientError;
use revprio_api::wire;
use revprio_robot::RobotModel;

/// Longest time without a look whether the run shall end.
const BLINK: Duration = Duration::from_millis(50);

/// Sums of periods are not exact: an answer is not too old by less than this, s.
const ROUNDING_S: f64 = 1e-9;

/// The answer that the arm obeys.
pub struct HeldCommand {
    /// As it came, but the joint velocities slow down once it is too old.
    pub answer: wire::StepAnswer,
    /// Whether it came in this period.
    pub is_new: bool,
    given_s: f64,
}

impl HeldCommand {
    /// An answer that came in this period, valid from the measurement of its state on; T in s.
    pub fn new(answer: wire::StepAnswer, period: f64) -> Self {
        let given_s = answer.sequence as f64 * period;
        Self { answer, is_new: true, given_s }
    }

    /// For want of a new one, the same for one more period T (s): held while valid, then towards rest with the largest
    /// accelerations.
    pub fn still(mut self, time_s: f64, robot: &RobotModel, period: f64) -> Self {
        let valid_s = self.answer.valid_for_ms as f64 / 1e3;
        if time_s - self.given_s > valid_s + ROUNDING_S {
            for (speed, joint) in self.answer.joint_velocity.iter_mut().zip(robot.joints()) {
                let slower = (speed.abs() - joint.limits.acceleration * period).max(0.0);
                *speed = slower.copysign(*speed);
            }
        }
        Self { is_new: false, ..self }
    }
}

/// Whether a client just waits for the next period: the service cannot be reached, has no time, or lost the session.
pub fn is_silence(error: &ClientError) -> bool {
    match error {
        ClientError::Transport { .. } => true,
        ClientError::UnexpectedAnswer { status, .. } => *status >= 500,
        ClientError::Refused { problem, .. } => {
            problem.status >= 500 || problem.status == 408 || problem.kind == "/problems/unknown-controller"
        }
    }
}

/// Lets a period (s) pass as it really does, unless the run shall end.
pub fn pause(period: f64, mut goes_on: impl FnMut() -> ControlFlow<()>) -> ControlFlow<()> {
    let (start, period) = (Instant::now(), Duration::try_from_secs_f64(period).unwrap_or(Duration::MAX));
    while let Some(left) = period.checked_sub(start.elapsed()) {
        goes_on()?;
        sleep(left.min(BLINK));
    }
    ControlFlow::Continue(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_lasts_a_period_or_until_the_run_shall_end() {
        let start = Instant::now();
        assert!(pause(0.06, || ControlFlow::Continue(())).is_continue());
        assert!(start.elapsed() >= Duration::from_millis(60));
        let mut looks = 0;
        let stop = || {
            looks += 1;
            if looks == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        assert!(pause(f64::MAX, stop).is_break());
    }
}
