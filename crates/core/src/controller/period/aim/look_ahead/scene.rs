//! What a period knows when it looks ahead.

use crate::arm_state::{ArmAt, ArmState};
use crate::controller::config::ControllerConfig;
use crate::controller::state::Memory;
use crate::law::TaskVector;
use crate::streaming::{ActiveStream, TaskStreams};

/// What a period knows when it looks ahead.
#[derive(Debug, Clone, Copy)]
pub(in crate::controller) struct Scene<'a> {
    pub config: &'a ControllerConfig,
    pub arm: &'a ArmState,
    pub previous: &'a Memory,
    pub streams: &'a [ActiveStream],
}

impl Scene<'_> {
    /// Returns the displacement of a task from its target (m) at a posture and the time of the target.
    pub fn displacement(&self, task: usize, at: ArmAt) -> TaskVector {
        let moved = TaskStreams::of(self.streams, task).position.map(|active| active.at(self.arm.time_s, at.time_s));
        self.config.tasks[task].rows.state(at, moved.as_ref()).displacement
    }

    /// Returns whether the motion of all targets ahead is known, and not only predicted.
    pub fn knows_targets(&self) -> bool {
        let until = self.arm.time_s + self.arm.time_to_rest;
        self.streams.iter().all(|active| active.stream.is_known_after(until))
    }

    /// Returns the positions of rest of the joints, p, n.
    pub fn position(&self) -> &[f64] {
        self.arm.at_rest().configuration.joint_position()
    }
}
