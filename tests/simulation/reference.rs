//! The reference: a controller of the library that gets states in order, without a service.

use revprio::service::{Robots, controller, stepper};
use revprio_api::wire::{self, JointVector};
use revprio_core::controller::{Command, Measurement, Memory, Stepper};
use revprio_core::limits::braking_deceleration;

use crate::controllers::Design;
use crate::violation::Violation;

/// The first command starts from a measured speed up to this multiple of the limit, and else from rest.
const BELIEVED: f64 = 1.5;

/// A controller without a service.
pub struct Reference {
    stepper: Stepper,
    design: Design,
    /// The memory of a client without a session.
    memory: Option<Memory>,
}

impl Reference {
    pub fn new(design: &Design) -> Self {
        let built = controller(&design.wire, &Robots::built_in()).unwrap();
        Self { stepper: stepper(built).unwrap(), design: design.clone(), memory: None }
    }

    /// Steps, and compares the command with an answer if there is one.
    pub fn step(
        &mut self,
        memory: &mut Option<Memory>,
        state: &wire::State,
        answer: Option<&wire::StepAnswer>,
    ) -> Result<(), Violation> {
        let mut measurement = measurement(state);
        let moves_too_fast = |speeds: &Vec<f64>| {
            let mut joints = self.design.robot.joints().iter().zip(speeds);
            joints.any(|(joint, speed)| speed.abs() > BELIEVED * joint.limits.velocity)
        };
        if memory.is_none() && measurement.joint_velocity.as_ref().is_some_and(moves_too_fast) {
            measurement.joint_velocity = None;
        }
        let command = self.stepper.step(memory, &measurement).map_err(|error| error.to_string())?;
        answer.map_or(Ok(()), |answer| compare(command, answer, &self.design))
    }

    /// Steps with the memory of the last call of this function.
    pub fn compare(&mut self, state: &wire::State, answer: &wire::StepAnswer) -> Result<(), Violation> {
        let mut memory = self.memory.take();
        let compared = self.step(&mut memory, state, Some(answer));
        self.memory = memory;
        compared
    }
}

fn measurement(state: &wire::State) -> Measurement {
    let values = |vector: &JointVector| match vector {
        JointVector::Ordered(values) => values.clone(),
        JointVector::Named(_) => Vec::new(),
    };
    let [force, torque] = state.wrench.map_or([[0.0; 3]; 2], |wrench| [wrench.force, wrench.torque]);
    Measurement {
        channels: Vec::new(),
        chunks: Vec::new(),
        wrenches: Vec::new(),
        obstacles: Vec::new(),
        time_s: state.time_s,
        joint_position: values(&state.joint_position),
        joint_velocity: state.joint_velocity.as_ref().map(values),
        wrench: [force[0], force[1], force[2], torque[0], torque[1], torque[2]],
        targets: Vec::new(),
    }
}

/// Compares the numbers of an answer with those of the reference.
fn compare(command: &Command, answer: &wire::StepAnswer, design: &Design) -> Result<(), Violation> {
    let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let (expected, given) = (command.resolution.joint_velocity.as_slice(), &answer.joint_velocity);
    if bits(expected) != bits(given) {
        return Err(format!("joint velocity {given:?}, reference {expected:?}"));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative and at most the maximum")]
    let valid = (command.hold.time_s * 1e3).min(design.wire.valid_for_ms as f64) as u64;
    if answer.valid_for_ms != valid {
        return Err(format!("valid for {} ms, reference {valid} ms", answer.valid_for_ms));
    }
    if answer.joint_limit_index.to_bits() != command.joint_limit_index.to_bits() {
        return Err("another joint-limit index".to_owned());
    }
    if answer.stop_time_s != command.hold.stop_time_s {
        return Err(format!("a stop in {:?} s, reference {:?} s", answer.stop_time_s, command.hold.stop_time_s));
    }
    let deceleration = |joint: &revprio_robot::Joint| {
        Some(braking_deceleration(&joint.limits)).filter(|deceleration| deceleration.is_finite())
    };
    let decelerations: Vec<Option<f64>> = design.robot.joints().iter().map(deceleration).collect();
    if answer.braking_deceleration != decelerations {
        return Err(format!("braking deceleration {:?}", answer.braking_deceleration));
    }
    let same = |(outcome, task): (&wire::TaskOutcome, &revprio_core::resolution::TaskOutcome)| {
        bits(&outcome.achieved) == bits(task.achieved.as_slice())
    };
    if answer.tasks.iter().zip(&command.resolution.tasks).all(same) { Ok(()) } else { Err("another task".to_owned()) }
}
