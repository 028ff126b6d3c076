//! How long the answer may be held before a watchdog brakes, as far as joints and contacts say.

use super::super::aim::Requests;
use crate::arm_state::ArmState;
use crate::controller::config::ControllerConfig;
use crate::law::ContactPhase;
use crate::limits::{Hold, spare_time};
use crate::task::TaskStack;

/// What bounds the hold of a command in this period.
#[derive(Clone, Copy)]
pub(super) struct Holding<'a> {
    pub config: &'a ControllerConfig,
    pub arm: &'a ArmState,
    pub requests: Requests<'a>,
}

impl Holding<'_> {
    /// Updates the hold of a command (n): joints that brake afterwards stop inside their ranges, and no tool presses much harder.
    /// `tasks`: with the Jacobians of the period.
    pub fn update(self, hold: &mut Hold, command: &[f64], tasks: &TaskStack) {
        let Self { config, arm, .. } = self;
        match config.kept_limits() {
            Some(kind) => hold.update(&config.robot, kind, arm.motion(), &arm.joint_velocity, command, config.period_s),
            None => *hold = Hold::default(),
        }
        hold.shorten(self.pressing_time(command, tasks), config.period_s);
    }

    /// Returns the time after which a command has added its target to a force, or max(2 T, 10 ms) if that is more, s; infinite without a tool
    /// that presses or approaches, that least time while a tool may be pushed by the retreat of a lower task. A loop whose answers take up to
    /// a period does not brake between two of them.
    fn pressing_time(self, command: &[f64], tasks: &TaskStack) -> f64 {
        let Self { config, requests: Requests { contacts, targets, .. }, .. } = self;
        let shortest = spare_time(2.0 * config.period_s);
        let times = contacts.axes().iter().filter_map(|axis| {
            let law = config.tasks[axis.task].law.contact()?;
            if targets[axis.task].released_by.is_some() {
                // A released task has no rows in this problem.
                return Some(shortest);
            }
            let upper = axis.memory.estimate.upper;
            let is_known = axis.memory.phase != ContactPhase::Approach && upper > 0.0;
            let stiffness = if is_known { upper } else { law.axes()[axis.row].stiffest };
            // A tool that follows a surface presses no harder.
            let speed = axis.along(command, config, tasks) - axis.memory.motion.velocity.max(0.0);
            (speed > 0.0).then(|| (axis.target / (stiffness * speed)).max(shortest))
        });
        times.fold(f64::INFINITY, f64::min)
    }
}
