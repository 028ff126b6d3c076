//! The reaction of an arm to missing answers: it holds the last command while valid, then brakes to rest.

use std::ops::ControlFlow;
use std::thread::sleep;
use std::time::{Duration, Instant};

use revprio_api::ClientError;
use revprio_api::wire;

/// Longest time between checks whether the run must end.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Tolerance of the age of an answer, s, because sums of periods are not exact.
const ROUNDING_S: f64 = 1e-9;

/// The answer that the arm executes.
pub struct HeldCommand {
    /// The answer; its joint velocities decrease once it is too old.
    pub answer: wire::StepAnswer,
    /// The joint velocities of the answer as it arrived, n.
    velocity: Vec<f64>,
    /// Whether it arrived in this period.
    pub is_new: bool,
    /// Time of the measurement that it answers, s.
    measured_s: f64,
}

impl HeldCommand {
    /// Returns an answer that arrived in the period at a time. It is valid from the measurement of its state; times in s.
    pub fn new(answer: wire::StepAnswer, time_s: f64, period: f64) -> Self {
        let (measured_s, velocity) = (answer.sequence as f64 * period, answer.joint_velocity.clone());
        let mut held = Self { answer, velocity, is_new: true, measured_s };
        held.brake(time_s + period);
        held
    }

    /// Continues with the period at a time (s) without a new answer.
    pub fn hold(mut self, time_s: f64, period: f64) -> Self {
        self.brake(time_s + period);
        Self { is_new: false, ..self }
    }

    /// Sets the velocities to those of the ramp at the end of the period, because the arm keeps them until then. The
    /// command is held while valid, then each joint brakes at the deceleration in the answer.
    fn brake(&mut self, end_s: f64) {
        let late_s = end_s - self.measured_s - self.answer.valid_for_ms as f64 / 1e3;
        if late_s <= ROUNDING_S {
            return;
        }
        let decelerations = self.answer.braking_deceleration.iter().copied().chain(std::iter::repeat(None));
        for ((speed, full), deceleration) in
            self.answer.joint_velocity.iter_mut().zip(&self.velocity).zip(decelerations)
        {
            let slower = (full.abs() - deceleration.unwrap_or(f64::INFINITY) * late_s).max(0.0);
            *speed = slower.copysign(*full);
        }
    }
}

/// Returns whether an error counts as a missing answer, after which the run continues: the service cannot be reached, is
/// overloaded, or lost the session.
pub fn is_missing_answer(error: &ClientError) -> bool {
    match error {
        ClientError::Transport { .. } => true,
        ClientError::UnexpectedAnswer { status, .. } => *status >= 500,
        ClientError::Refused { problem, .. } => {
            problem.status >= 500 || problem.status == 408 || problem.kind == "/problems/unknown-controller"
        }
    }
}

/// Waits for one period (s) of real time, unless the run must end.
pub fn pause(period: f64, mut goes_on: impl FnMut() -> ControlFlow<()>) -> ControlFlow<()> {
    let (start, period) = (Instant::now(), Duration::try_from_secs_f64(period).unwrap_or(Duration::MAX));
    while let Some(left) = period.checked_sub(start.elapsed()) {
        goes_on()?;
        sleep(left.min(POLL_INTERVAL));
    }
    ControlFlow::Continue(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pause_lasts_one_period_or_until_the_run_ends() {
        let start = Instant::now();
        assert!(pause(0.06, || ControlFlow::Continue(())).is_continue());
        assert!(start.elapsed() >= Duration::from_millis(60));
        let mut polls = 0;
        let stop = || {
            polls += 1;
            if polls == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        assert!(pause(f64::MAX, stop).is_break());
    }
}
