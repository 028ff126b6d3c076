//! Tasks about joints.

use revprio_robot::RobotModel;
use revprio_robot::kinematics::{half_range, joint_limit_slopes};

use super::TaskConfigError;
use super::task::Sensed;
use crate::law::{Profile, SetPoint, TaskState};
use crate::linalg::TaskVector;

/// Joints, and where they are to go.
#[derive(Debug, Clone, PartialEq)]
pub struct JointRows {
    /// The joints, index from 0.
    pub joints: Vec<usize>,
    /// q_d.
    pub target: JointTarget,
}

/// Where joints are to go.
#[derive(Debug, Clone, PartialEq)]
pub enum JointTarget {
    /// To positions, rad or m, one row per joint.
    Position(Profile),
    /// To the middle of their ranges, along −∇H: the law's displacement is ∂H/∂q_i. Paper: Eq. (8).
    MidRange,
}

impl JointRows {
    /// Checks that the joints exist, stand once, and have what the target needs.
    pub(super) fn check(&self, robot: &RobotModel) -> Result<(), TaskConfigError> {
        let ranged = |joint: usize| half_range(&robot.joints()[joint].limits).is_some();
        let sound = |(i, &joint): (usize, &usize)| {
            joint < robot.joint_count()
                && !self.joints[..i].contains(&joint)
                && (self.target != JointTarget::MidRange || ranged(joint))
        };
        let all = !self.joints.is_empty() && self.joints.iter().enumerate().all(sound);
        if all { Ok(()) } else { Err(TaskConfigError::Joints) }
    }

    /// The entries of the chosen joints, m.
    pub(super) fn entries_of(&self, joints: &[f64]) -> TaskVector {
        TaskVector::from_fn(self.joints.len(), |row| joints[self.joints[row]])
    }

    /// What the law sees; `velocity`: q̇ of the chosen joints, m.
    pub(super) fn state(&self, velocity: TaskVector, sensed: &Sensed) -> TaskState {
        let position = sensed.configuration.joint_position();
        let rest = TaskVector::zeros(velocity.len());
        let [displacement, target_velocity, target_acceleration] = match &self.target {
            JointTarget::Position(profile) => {
                let SetPoint { value, rate, acceleration } = profile.at(sensed.time_s);
                let [value, rate, acceleration] =
                    [value, rate, acceleration].map(|entries| TaskVector::from_slice(&entries));
                [&self.entries_of(position) - &value, rate, acceleration]
            }
            JointTarget::MidRange => {
                let mut gradient = TaskVector::zeros(position.len());
                let slopes = joint_limit_slopes(sensed.robot, position);
                gradient.iter_mut().zip(slopes).for_each(|(entry, slope)| *entry = slope);
                [self.entries_of(&gradient), rest.clone(), rest.clone()]
            }
        };
        TaskState { time_s: sensed.time_s, velocity, displacement, target_velocity, target_acceleration, force: rest }
    }
}
