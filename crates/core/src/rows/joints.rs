//! Rows of joints, and their target.

use revprio_robot::RobotModel;
use revprio_robot::kinematics::{half_range, joint_limit_slopes};

use super::rows_error::RowsError;
use crate::arm_state::ArmAt;
use crate::law::{Law, Profile, SetPoint, TaskState, TaskVector};
use crate::linalg::Matrix;
use crate::streaming::{ActiveStream, Reference, TargetValue};

/// The joints of a task and their target.
#[derive(Debug, Clone, PartialEq)]
pub struct JointRows {
    /// The joints, each once, index from 0.
    pub joints: Vec<usize>,
    /// Target q_d.
    pub target: JointTarget,
}

/// The target of joints.
#[derive(Debug, Clone, PartialEq)]
pub enum JointTarget {
    /// Positions over time, rad or m, one row per joint.
    Position(Profile),
    /// The middle of their ranges, along −∇H: the displacement that the law sees is ∂H/∂q_i. Paper: Eq. (8).
    MidRange,
}

impl JointRows {
    /// Checks that the joints exist, are distinct, and have a range if the target needs one, and that a law can move them.
    pub(super) fn check(&self, robot: &RobotModel, law: &Law) -> Result<(), RowsError> {
        let has_range = |joint: usize| half_range(&robot.joints()[joint].limits).is_some();
        let is_valid = |(i, &joint): (usize, &usize)| {
            joint < robot.joint_count()
                && !self.joints[..i].contains(&joint)
                && (self.target != JointTarget::MidRange || has_range(joint))
        };
        let valid = !self.joints.is_empty() && self.joints.iter().enumerate().all(is_valid);
        if !valid {
            return Err(RowsError::Joints);
        }
        if let JointTarget::Position(profile) = &self.target {
            RowsError::unless_equal(self.joints.len(), profile.rows())?;
        }
        if law.reads_wrench() { Err(RowsError::JointLaw) } else { Ok(()) }
    }

    /// Overwrites `jacobian` with J_k, m × n.
    pub(super) fn write_jacobian(&self, jacobian: &mut Matrix) {
        jacobian.fill(0.0);
        self.joints.iter().enumerate().for_each(|(row, &joint)| jacobian[(row, joint)] = 1.0);
    }

    /// Returns whether targets can be streamed to the rows.
    pub(super) fn has_position_target(&self) -> bool {
        matches!(self.target, JointTarget::Position(_))
    }

    /// Selects the entries of the joints of this task, m.
    pub(super) fn select(&self, joints: &[f64]) -> TaskVector {
        TaskVector::from_fn(self.joints.len(), |row| joints[self.joints[row]])
    }

    /// Overwrites `target` with the positions (m) from which the joints are displaced. The middle of their ranges never moves.
    pub(super) fn write_target(&self, at: ArmAt, displacement: &[f64], target: &mut TargetValue) {
        let position = at.configuration.joint_position();
        let value = |row: usize| match &self.target {
            JointTarget::Position(_) => position[self.joints[row]] - displacement[row],
            JointTarget::MidRange => 0.0,
        };
        match target {
            TargetValue::Rows(rows) if rows.len() == self.joints.len() => {
                rows.iter_mut().enumerate().for_each(|(row, entry)| *entry = value(row));
            }
            _ => *target = TargetValue::Rows(TaskVector::from_fn(self.joints.len(), value)),
        }
    }

    /// Returns the measured positions with a velocity of the task, m.
    pub(super) fn actual(&self, velocity: &[f64], at: ArmAt) -> Reference {
        let value = TargetValue::Rows(self.select(at.configuration.joint_position()));
        Reference { value, velocity: TaskVector::from_slice(velocity) }
    }

    /// Returns the rate per unit of gain at which the law moves a joint to its target.
    pub(super) fn rate(&self, robot: &RobotModel, joint: usize) -> f64 {
        match self.target {
            JointTarget::MidRange => mid_range_rate(robot, joint),
            JointTarget::Position(_) => 1.0,
        }
    }

    /// Returns the state for the law; `velocity`: q̇ of the joints of this task, m.
    pub(super) fn state(&self, velocity: TaskVector, at: ArmAt, streamed: Option<&ActiveStream>) -> TaskState {
        let ArmAt { arm, configuration, time_s } = at;
        let position = configuration.joint_position();
        let zero = TaskVector::zeros(velocity.len());
        let streamed = streamed.and_then(|active| match &active.stream.reference.value {
            TargetValue::Rows(value) => Some((value, active)),
            TargetValue::Pose(_) => None,
        });
        let [displacement, target_velocity, target_acceleration] = match (&self.target, streamed) {
            (JointTarget::Position(_), Some((value, active))) => {
                [&self.select(position) - value, active.velocity.clone(), active.acceleration.clone()]
            }
            (JointTarget::Position(profile), None) => {
                let SetPoint { value, rate, acceleration } =
                    profile.at(arm.profile_time(arm.known_time(profile, time_s)));
                let [value, rate, acceleration] =
                    [value, rate, acceleration].map(|entries| TaskVector::from_slice(&entries));
                [&self.select(position) - &value, rate, acceleration]
            }
            (JointTarget::MidRange, _) => {
                let mut gradient = TaskVector::zeros(position.len());
                let slopes = joint_limit_slopes(&arm.robot, position);
                gradient.iter_mut().zip(slopes).for_each(|(entry, slope)| *entry = slope);
                [self.select(&gradient), zero.clone(), zero.clone()]
            }
        };
        let time_s = arm.profile_time(time_s);
        TaskState { time_s, velocity, displacement, target_velocity, target_acceleration, force: zero, streamed: None }
    }
}

/// Returns ∂²H/∂q_i², 1/rad² or 1/m²: the rate, per unit of gain, at which −k ∇H moves a joint to the middle of its range.
pub(crate) fn mid_range_rate(robot: &RobotModel, joint: usize) -> f64 {
    let half = half_range(&robot.joints()[joint].limits);
    half.map_or(0.0, |half| 1.0 / (robot.joint_count() as f64 * half * half))
}
