//! The answer to one measurement.

use super::stall::StalledJoint;
use super::stuck_task::StuckTask;
use super::task_target::TaskTarget;
use crate::collision::CollisionReport;
use crate::limits::{BoundCause, Hold};
use crate::resolution::Resolution;

/// The answer to one measurement.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Command {
    /// Joint velocities and their explanation.
    pub resolution: Resolution,
    /// The limit that sets each of the active limits of `resolution`, in their order.
    pub limit_causes: Vec<BoundCause>,
    /// F_e of each wrench sensor of the controller, in their order: corrected, on the environment, at the tip, base axes, N and N·m.
    pub wrenches: Vec<[f64; 6]>,
    /// Targets of each task, highest priority first.
    pub targets: Vec<TaskTarget>,
    /// Joints (index from 0) whose acceleration or jerk limit contradicts position or velocity limits and is not kept.
    pub limit_conflicts: Vec<usize>,
    /// Tasks that make no progress.
    pub stuck: Vec<StuckTask>,
    /// s, the share of all requests that remains, see [`RestState`](super::RestState); 1 if the joints do not turn in vain. At 0, the arm
    /// rests short of its targets until one of them changes.
    pub request_share: f64,
    /// Time since which the share is below 1, s.
    pub fading_since_s: Option<f64>,
    /// Joints that do not follow their commands.
    pub stalled: Vec<StalledJoint>,
    /// How long the joint velocities may be held before a watchdog must brake.
    pub hold: Hold,
    /// Distances and how they restrict the command; `None`: the controller watches none.
    pub collisions: Option<CollisionReport>,
    /// The commands of the channels, in their order; `None`: no target came yet.
    pub channels: Vec<Option<f64>>,
    /// H, joint-limit index: 0 with all joints in the middle of their ranges, ½ with all at a limit. Paper: Eq. (8).
    pub joint_limit_index: f64,
}

impl Command {
    /// Returns whether both have the same tasks with the same numbers of rows.
    pub(in crate::controller) fn has_size_of(&self, other: &Self) -> bool {
        let rows = |target: &TaskTarget| target.velocity.len();
        self.targets.iter().map(rows).eq(other.targets.iter().map(rows))
    }
}
