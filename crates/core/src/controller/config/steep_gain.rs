//! Gains of position laws that demand more deceleration than the joints have.

use super::controller_config::ControllerConfig;
use crate::law::{Braking, Law};

/// A gain that demands more deceleration than a joint has, at the joint's full speed.
#[derive(Debug, Clone, PartialEq)]
pub struct SteepGain<'a> {
    /// Name of the task.
    pub task: &'a str,
    /// K, the largest one of the task, 1/s.
    pub gain: f64,
    /// Name of the joint with the smallest A/V of those that the task moves.
    pub joint: &'a str,
    /// A/V of this joint, 1/s.
    pub ratio: f64,
    /// Whether the law brakes all the same; `false` for [`Braking::None`].
    pub brakes: bool,
}

impl ControllerConfig {
    /// Returns the position laws with a gain above A/V of a joint that they move; one entry per task.
    ///
    /// From its full speed V the joint decelerates by at most A, but the gain K demands K V. A law that brakes then uses
    /// its braking profile instead of the gain; a law that does not may pass its target. Joints without acceleration limit
    /// do not count.
    pub fn steep_gains(&self) -> impl Iterator<Item = SteepGain<'_>> {
        self.tasks.iter().filter_map(|task| {
            let Law::Position(law) = &task.law else { return None };
            let of_row = |row: usize| {
                let (joint, rate) = task.rows.joint(&self.robot, row)?;
                Some((joint, law.gain()[row] * rate))
            };
            // Rows of the tool may move every joint.
            let every = || (0..self.robot.joint_count()).map(|joint| (joint, law.gain().max())).collect();
            let joints: Vec<_> = (0..law.rows()).map(of_row).collect::<Option<_>>().unwrap_or_else(every);
            let steep = joints.into_iter().filter_map(|(joint, gain)| {
                let limits = &self.robot.joints()[joint].limits;
                let ratio = limits.acceleration / limits.velocity;
                // False for joints without one of the limits.
                (ratio < f64::INFINITY && ratio > 0.0 && gain > ratio).then_some((joint, gain, ratio))
            });
            let (joint, gain, ratio) = steep.min_by(|a, b| (a.2 / a.1).total_cmp(&(b.2 / b.1)))?;
            let (joint, brakes) = (self.robot.joints()[joint].name.as_str(), *law.braking() != Braking::None);
            Some(SteepGain { task: &task.name, gain, joint, ratio, brakes })
        })
    }
}
