//! Constant rows over the joints.

use revprio_robot::RobotModel;

use super::rows_error::RowsError;
use crate::law::{Law, TaskState, TaskVector};
use crate::linalg::Matrix;

/// Constant rows J_k over the joints, for example the sum of two joint velocities.
#[derive(Debug, Clone, PartialEq)]
pub struct RawRows {
    /// J_k, m × n, in any unit per unit of joint speed.
    pub jacobian: Matrix,
}

impl RawRows {
    /// Checks that there are rows of finite numbers, one per joint, and that the law reads neither position nor wrench.
    pub(super) fn check(&self, robot: &RobotModel, law: &Law) -> Result<(), RowsError> {
        let expected = robot.joint_count();
        let valid = self.jacobian.nrows() > 0
            && self.jacobian.ncols() == expected
            && self.jacobian.iter().all(|entry| entry.is_finite());
        if !valid {
            return Err(RowsError::Jacobian { expected });
        }
        if law.follows_velocity() || law.bounds().is_some() { Ok(()) } else { Err(RowsError::RawLaw) }
    }

    /// Returns J_k q̇, m; `joint_velocity`: q̇, n.
    pub(super) fn velocity(&self, joint_velocity: &[f64]) -> TaskVector {
        let entry = |row: usize| self.jacobian.row(row).iter().zip(joint_velocity).map(|(a, speed)| a * speed).sum();
        TaskVector::from_fn(self.jacobian.nrows(), entry)
    }

    /// Returns the state for the law at time t, s; `velocity`: J_k q̇, m. Constant rows have no position and no force.
    pub(super) fn state(velocity: TaskVector, time_s: f64) -> TaskState {
        let zero = TaskVector::zeros(velocity.len());
        TaskState {
            time_s,
            velocity,
            displacement: zero.clone(),
            target_velocity: zero.clone(),
            target_acceleration: zero.clone(),
            force: zero,
            streamed: None,
        }
    }
}
