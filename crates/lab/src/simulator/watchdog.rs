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

/// Difference of a velocity from the ramp that counts as none, rad/s or m/s, because sums are not exact.
const ARRIVED: f64 = 1e-9;

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
    /// Whether the joint velocities return to those of the answers, after a ramp.
    resumes: bool,
}

impl HeldCommand {
    /// Returns an answer that arrived in the period at a time, after the command of the period before. It is valid from the
    /// measurement of its state; times in s.
    pub fn new(answer: wire::StepAnswer, before: Option<&Self>, time_s: f64, period: f64) -> Self {
        let (measured_s, velocity) = (answer.sequence as f64 * period, answer.joint_velocity.clone());
        let resumes = before.is_some_and(|before| before.resumes || before.late_s(time_s) > ROUNDING_S);
        let mut held = Self { answer, velocity, is_new: true, measured_s, resumes };
        held.command(before.map_or(&[], |before| &before.answer.joint_velocity), time_s, period);
        held
    }

    /// Continues with the period at a time (s) without a new answer.
    pub fn hold(mut self, time_s: f64, period: f64) -> Self {
        let last = self.answer.joint_velocity.clone();
        self.command(&last, time_s, period);
        Self { is_new: false, ..self }
    }

    /// Sets the velocities of a period: those of the answer while it is valid, then those of the ramp at the end of the
    /// period, because the arm keeps them until then. After a ramp the acceleration from the velocities `last` is limited
    /// to that of the ramp.
    fn command(&mut self, last: &[f64], time_s: f64, period: f64) {
        let late_s = self.late_s(time_s + period);
        let mut is_reached = true;
        for (joint, (commanded, full)) in self.answer.joint_velocity.iter_mut().zip(&self.velocity).enumerate() {
            let deceleration = self.answer.braking_deceleration.get(joint).copied().flatten().unwrap_or(f64::INFINITY);
            let decrease = match self.answer.stop_time_s {
                _ if late_s <= ROUNDING_S => 0.0,
                Some(time) => full.abs() * (late_s / time),
                None => deceleration * late_s,
            };
            let ramp = (full.abs() - decrease).max(0.0).copysign(*full);
            let reach = deceleration * period;
            *commanded = match last.get(joint) {
                Some(last) if self.resumes => ramp.max(last - reach).min(last + reach),
                _ => ramp,
            };
            is_reached &= (*commanded - ramp).abs() <= ARRIVED;
        }
        self.resumes &= !is_reached;
    }

    /// Returns how long the answer has been invalid at a time, s.
    fn late_s(&self, time_s: f64) -> f64 {
        time_s - self.measured_s - self.answer.valid_for_ms as f64 / 1e3
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

    fn answer(sequence: u64, velocity: [f64; 2]) -> wire::StepAnswer {
        let example = include_str!("../../../../api/examples/answers/step.json");
        let answer: wire::StepAnswer = serde_json::from_str(example).unwrap();
        let (joint_velocity, braking_deceleration) = (velocity.to_vec(), vec![Some(2.0), None]);
        wire::StepAnswer {
            sequence,
            joint_velocity,
            braking_deceleration,
            valid_for_ms: 100,
            stop_time_s: None,
            ..answer
        }
    }

    fn assert_near(held: &HeldCommand, expected: [f64; 2]) {
        let given = &held.answer.joint_velocity;
        assert!(given.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{given:?} {expected:?}");
    }

    #[test]
    fn a_command_is_held_then_the_joints_brake_and_later_return_to_the_answers() {
        let mut held = HeldCommand::new(answer(0, [0.4, 0.3]), None, 0.0, 0.1);
        assert_near(&held, [0.4, 0.3]);
        held = held.hold(0.1, 0.1);
        assert_near(&held, [0.2, 0.0]);
        held = HeldCommand::new(answer(2, [1.0, 0.3]), Some(&held), 0.2, 0.1);
        assert_near(&held, [0.4, 0.3]);
        held = HeldCommand::new(answer(3, [-1.0, 0.3]), Some(&held), 0.3, 0.1);
        assert_near(&held, [0.2, 0.3]);
        held = HeldCommand::new(answer(4, [0.0, 0.3]), Some(&held), 0.4, 0.1);
        assert_near(&held, [0.0, 0.3]);
        // The joints have the velocities of the answer, so the next one counts at once.
        assert_near(&HeldCommand::new(answer(5, [1.0, 0.3]), Some(&held), 0.5, 0.1), [1.0, 0.3]);
        // Rounding does not prolong the return.
        let braked = HeldCommand::new(answer(0, [0.4, 0.3]), None, 0.0, 0.1).hold(0.1, 0.1);
        let near = HeldCommand::new(answer(2, [0.4 + 1e-12, 0.0]), Some(&braked), 0.2, 0.1);
        assert_near(&HeldCommand::new(answer(3, [1.0, 1.0]), Some(&near), 0.3, 0.1), [1.0, 1.0]);
    }

    #[test]
    fn all_joints_come_to_rest_together_if_the_answer_says_when() {
        let answer = wire::StepAnswer { stop_time_s: Some(0.2), ..answer(0, [0.4, -0.3]) };
        let mut held = HeldCommand::new(answer, None, 0.0, 0.1);
        for (time_s, expected) in [(0.1, [0.2, -0.15]), (0.2, [0.0, 0.0]), (0.3, [0.0, 0.0])] {
            held = held.hold(time_s, 0.1);
            assert_near(&held, expected);
        }
    }

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
