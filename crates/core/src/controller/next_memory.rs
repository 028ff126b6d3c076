//! The memory after a period: what the controller keeps of the state and of its command.

use super::jerk::{Approach, JerkState};
use super::target_streams::ActiveStream;
use super::task::ArmState;
use super::{AnsweredState, AntiWindup, Command, Controller, Measurement, Memory};
use crate::limits::{DriveState, Hold};
use crate::linalg::Vector;
use crate::resolution::{Resolution, Status};
use crate::streaming::TargetStream;

/// Maximum relative difference of achieved and requested velocity at which an axis counts as following.
const FOLLOWING_TOLERANCE: f64 = 1e-9;

impl Controller {
    /// Returns the memory for the first step: integrators and last command equal the measured motion.
    pub(super) fn initial_memory(&self, arm: &ArmState) -> Memory {
        let velocity = Vector::from_row_slice(arm.joint_velocity);
        Memory {
            task_velocities: self.config().tasks.iter().map(|task| task.rows.velocity(arm).to_vector()).collect(),
            initial_pose: arm.initial_pose,
            drive: DriveState::moving(self.config().drive, &velocity),
            answered: None,
            jerk: self.config().keeps_jerk().then(|| JerkState::moving(&velocity)),
            last_command: velocity,
            active_set: Vec::new(),
            target_streams: Vec::new(),
            initial_position: None,
            progress: Vec::new(),
            stalls: Vec::new(),
            in_transition: false,
        }
    }

    /// Updates the memory after a command, with anti-windup.
    ///
    /// The integrator of every axis that does not follow its request continues from the achieved velocity, whatever holds
    /// the axis back: a limit, an inequality, another task or damping. So the request of the next period differs from the
    /// achieved velocity by T M_d⁻¹ f alone, where f is the force of the law; it cannot jump when the axis is released.
    /// For a law without integrator the memory holds the achieved velocity.
    ///
    /// Departs: the paper's laws do not know what was achieved. With [`AntiWindup::ExceptDamping`] damping alone does not
    /// reset the integrator, and the classical control keeps its published behaviour: on `force_tracking_singular`, its
    /// F_x RMSE is 1.4 N, and 2.4 N with a reset, which acts like a second damping.
    pub(super) fn update_memory(
        &self,
        memory: &mut Memory,
        Command { resolution, targets, .. }: &Command,
        approach: Option<&Approach>,
    ) {
        let resets = self.config().anti_windup == AntiWindup::Always || is_held_back(resolution);
        for (k, velocity) in memory.task_velocities.iter_mut().enumerate() {
            let (requested, achieved) = (&targets[k].velocity, &resolution.tasks[k].achieved);
            for (row, velocity) in velocity.iter_mut().enumerate() {
                let followed =
                    (achieved[row] - requested[row]).abs() <= FOLLOWING_TOLERANCE * requested[row].abs().max(1.0);
                let continues = self.config().tasks[k].law.integrates() && (followed || !resets);
                *velocity = if continues { requested[row] } else { achieved[row] };
            }
        }
        memory.in_transition =
            memory.in_transition && self.config().is_in_transition(memory.last_command.as_slice(), resolution);
        match approach {
            Some(approach) => approach.update_memory(memory, self.config(), &resolution.joint_velocity),
            None => memory.jerk = None,
        }
        memory.last_command.copy_from(&resolution.joint_velocity);
        memory.drive.advance(self.config().drive, &resolution.joint_velocity, self.config().period_s);
        memory.active_set.clone_from(&resolution.active_set);
    }

    /// Keeps the state that the command answers, and the posture of the first one.
    pub(super) fn remember_state(&self, memory: &mut Memory, measurement: &Measurement, hold: &Hold) {
        let Measurement { time_s, joint_position, .. } = measurement;
        let empty =
            || AnsweredState { time_s: 0.0, joint_position: Vector::zeros(joint_position.len()), valid_for_ms: 0 };
        memory.initial_position.get_or_insert_with(|| Vector::from_row_slice(joint_position));
        let answered = memory.answered.get_or_insert_with(empty);
        answered.time_s = *time_s;
        answered.joint_position.copy_from_slice(joint_position);
        answered.valid_for_ms = hold.valid_for_ms(self.config().valid_for_ms);
    }
}

/// Keeps the streams of this period.
pub(super) fn update_streams(memory: &mut Vec<TargetStream>, streams: &[ActiveStream]) {
    memory.truncate(streams.len());
    for (index, active) in streams.iter().enumerate() {
        match memory.get_mut(index) {
            Some(stream) => stream.clone_from(&active.stream),
            None => memory.push(active.stream.clone()),
        }
    }
}

/// Returns whether anything but damping may hold tasks back.
fn is_held_back(resolution: &Resolution) -> bool {
    !resolution.active_bounds.is_empty()
        || resolution.singularity.algorithmic
        || resolution.solver.status != Status::Optimal
}
