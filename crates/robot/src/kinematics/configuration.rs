//! A posture of the arm with its forward kinematics done.
#![allow(non_snake_case)]

use nalgebra::{IsometryMatrix3, Matrix3, Matrix3xX, Matrix6xX, Rotation3, UnitQuaternion, Vector3};

use crate::{JointKind, RobotModel};

/// Tool Jacobian, 6 × n: linear rows (m/s), then angular rows (rad/s), base axes, at the tool point.
pub type Jacobian = Matrix6xX<f64>;

/// Why a posture is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConfigurationError {
    /// One position per joint is needed.
    #[error("{given} joint positions for a robot of {expected} joints")]
    Size {
        /// Joints of the robot.
        expected: usize,
        /// Positions given.
        given: usize,
    },
    /// NaN or infinite.
    #[error("the position of joint `{joint}` is not a finite number")]
    NotFinite {
        /// The joint.
        joint: String,
    },
}

/// Joint positions of a robot together with the tool pose and Jacobian there.
///
/// Exists only after forward kinematics, so whoever holds one can rely on both.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    joint_position: Vec<f64>,
    joints: Vec<JointLine>,
    tool_pose: IsometryMatrix3<f64>,
    jacobian: Jacobian,
}

/// Where a joint is: what it turns about or slides along.
#[derive(Debug, Clone, Copy, PartialEq)]
struct JointLine {
    kind: JointKind,
    /// m, base frame.
    origin: Vector3<f64>,
    /// Unit vector, base axes.
    axis: Vector3<f64>,
}

impl Configuration {
    /// Computes tool pose and Jacobian at `joint_position` (n; rad or m).
    pub fn new(robot: &RobotModel, joint_position: &[f64]) -> Result<Self, ConfigurationError> {
        let n = robot.joint_count();
        let mut configuration = Self {
            joint_position: vec![0.0; n],
            joints: robot.joints().iter().map(|joint| JointLine::along_base_z(joint.kind)).collect(),
            tool_pose: IsometryMatrix3::identity(),
            jacobian: Jacobian::zeros(n),
        };
        configuration.update(robot, joint_position)?;
        Ok(configuration)
    }

    /// Becomes the configuration of the same robot at another posture; on an error it stays as it was.
    pub fn update(&mut self, robot: &RobotModel, joint_position: &[f64]) -> Result<(), ConfigurationError> {
        check(robot, joint_position)?;
        self.joint_position.copy_from_slice(joint_position);
        let mut frame = IsometryMatrix3::identity();
        for ((joint, &q), line) in robot.joints().iter().zip(joint_position).zip(&mut self.joints) {
            frame *= joint.placement;
            line.origin = frame.translation.vector;
            line.axis = frame.rotation.matrix().column(2).into();
            move_along(&mut frame, joint.kind, q);
        }
        self.tool_pose = frame * robot.tool();
        let tool_point = self.tool_pose.translation.vector;
        let columns = self.jacobian.as_mut_slice().chunks_exact_mut(6);
        for (entries, line) in columns.zip(&self.joints) {
            let (linear, angular) = line.velocity_of(&tool_point);
            entries[..3].copy_from_slice(linear.as_slice());
            entries[3..].copy_from_slice(angular.as_slice());
        }
        Ok(())
    }

    /// q, the joint positions, n.
    pub fn joint_position(&self) -> &[f64] {
        &self.joint_position
    }

    /// Pose of the tool frame in the base frame, m.
    pub fn tool_pose(&self) -> &IsometryMatrix3<f64> {
        &self.tool_pose
    }

    /// J, the tool Jacobian, 6 × n.
    pub fn jacobian(&self) -> &Jacobian {
        &self.jacobian
    }

    /// Origin of a joint's frame (index from 0), base frame, m, and its Jacobian, 3 × n, m/s.
    ///
    /// # Panics
    ///
    /// If the robot has no such joint.
    pub fn joint_origin(&self, joint: usize) -> (Vector3<f64>, Matrix3xX<f64>) {
        let origin = self.joints[joint].origin;
        let mut jacobian = Matrix3xX::zeros(self.joints.len());
        for (i, line) in self.joints[..joint].iter().enumerate() {
            jacobian.set_column(i, &line.velocity_of(&origin).0);
        }
        (origin, jacobian)
    }

    /// J q̇: the tool's twist for joint velocities q̇ (n), in base axes.
    pub fn twist(&self, joint_velocity: &[f64]) -> [f64; 6] {
        let mut twist = [0.0; 6];
        for (column, &speed) in self.jacobian.column_iter().zip(joint_velocity) {
            for (entry, slope) in twist.iter_mut().zip(column.iter()) {
                *entry += slope * speed;
            }
        }
        twist
    }
}

pub(super) fn check(robot: &RobotModel, joint_position: &[f64]) -> Result<(), ConfigurationError> {
    if joint_position.len() != robot.joint_count() {
        return Err(ConfigurationError::Size { expected: robot.joint_count(), given: joint_position.len() });
    }
    match robot.joints().iter().zip(joint_position).find(|(_, q)| !q.is_finite()) {
        Some((joint, _)) => Err(ConfigurationError::NotFinite { joint: joint.name.clone() }),
        None => Ok(()),
    }
}

/// Moves a joint's frame by its position: about or along its z axis, which keeps the third column of its rotation.
pub(super) fn move_along(frame: &mut IsometryMatrix3<f64>, kind: JointKind, q: f64) {
    let R = frame.rotation.matrix();
    match kind {
        JointKind::Revolute => {
            let (sine, cosine) = q.sin_cos();
            let (x, y) = (R.column(0).into_owned(), R.column(1).into_owned());
            let turned = Matrix3::from_columns(&[x * cosine + y * sine, y * cosine - x * sine, R.column(2).into()]);
            frame.rotation = Rotation3::from_matrix_unchecked(turned);
        }
        JointKind::Prismatic => {
            let z = R.column(2).into_owned();
            frame.translation.vector += z * q;
        }
    }
}

impl JointLine {
    fn along_base_z(kind: JointKind) -> Self {
        Self { kind, origin: Vector3::zeros(), axis: Vector3::z() }
    }

    /// One column of the geometric Jacobian: linear and angular velocity that unit speed of the joint gives a point (m, base
    /// frame) of the tool.
    fn velocity_of(&self, point: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        match self.kind {
            JointKind::Revolute => (self.axis.cross(&(point - self.origin)), self.axis),
            JointKind::Prismatic => (self.axis, Vector3::zeros()),
        }
    }
}

/// log(R R_dᵀ): the rotation vector (rad, base axes) that leads from the desired orientation to the actual one.
///
/// It is X − X_d of the control laws for the angular rows.
pub fn orientation_error(actual: &Rotation3<f64>, desired: &Rotation3<f64>) -> Vector3<f64> {
    // By way of the quaternion: the angle of a rotation matrix, an arc cosine, is blind below 1e-8 rad.
    UnitQuaternion::from_rotation_matrix(&(actual * desired.inverse())).scaled_axis()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::built_in;

    #[test]
    fn wrong_postures_are_refused_by_name() {
        let sawyer = &built_in()[0];
        assert_eq!(Configuration::new(sawyer, &[0.0; 6]), Err(ConfigurationError::Size { expected: 7, given: 6 }));
        let refusal = Configuration::new(sawyer, &[0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0]).unwrap_err();
        assert!(refusal.to_string().contains("`j3`"));
    }

    #[test]
    fn orientation_error_is_the_rotation_vector_from_desired_to_actual() {
        let desired = Rotation3::from_euler_angles(0.3, -0.2, 1.0);
        let turn = Vector3::new(0.1, -0.4, 0.2);
        let error = orientation_error(&(Rotation3::new(turn) * desired), &desired);
        assert!((error - turn).norm() < 1e-14);
        let tiny = Vector3::new(1e-12, 0.0, -2e-12);
        assert!((orientation_error(&Rotation3::new(tiny), &Rotation3::identity()) - tiny).norm() < 1e-20);
    }
}
