//! The forward kinematics of an arm at a posture.
#![allow(non_snake_case)]

use nalgebra::{IsometryMatrix3, Matrix3xX, Matrix6xX, Rotation3, UnitQuaternion, Vector3};

use crate::{JointKind, RobotModel};

/// Tool Jacobian, 6 × n: linear rows (m/s), then angular rows (rad/s), along the base axes, at the tool point.
pub type Jacobian = Matrix6xX<f64>;

/// Why a posture is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConfigurationError {
    /// The number of positions is not the number of joints.
    #[error("{given} joint positions for a robot of {expected} joints")]
    Size {
        /// Joints of the robot.
        expected: usize,
        /// Positions given.
        given: usize,
    },
    /// A position is NaN or infinite.
    #[error("the position of joint `{joint}` is not a finite number")]
    NotFinite {
        /// The joint.
        joint: String,
    },
}

/// Joint positions of a robot with the tool pose and Jacobian there.
///
/// A value exists only after forward kinematics, so pose and Jacobian always belong to the joint positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    joint_position: Vec<f64>,
    joints: Vec<JointAxis>,
    tool_pose: IsometryMatrix3<f64>,
    jacobian: Jacobian,
}

/// The axis of a joint in the base frame: the joint turns about it or slides along it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct JointAxis {
    kind: JointKind,
    /// m, base frame.
    origin: Vector3<f64>,
    /// Unit vector, base axes.
    direction: Vector3<f64>,
}

impl Configuration {
    /// Computes tool pose and Jacobian at `joint_position` (n; rad or m).
    pub fn new(robot: &RobotModel, joint_position: &[f64]) -> Result<Self, ConfigurationError> {
        let n = robot.joint_count();
        let mut configuration = Self {
            joint_position: vec![0.0; n],
            joints: robot.joints().iter().map(|joint| JointAxis::along_base_z(joint.kind)).collect(),
            tool_pose: IsometryMatrix3::identity(),
            jacobian: Jacobian::zeros(n),
        };
        configuration.update(robot, joint_position)?;
        Ok(configuration)
    }

    /// Updates to another posture of the same robot. On an error the configuration stays unchanged.
    pub fn update(&mut self, robot: &RobotModel, joint_position: &[f64]) -> Result<(), ConfigurationError> {
        check(robot, joint_position)?;
        self.joint_position.copy_from_slice(joint_position);
        let mut frame = IsometryMatrix3::identity();
        for ((joint, &q), axis) in robot.joints().iter().zip(joint_position).zip(&mut self.joints) {
            frame *= joint.placement;
            axis.origin = frame.translation.vector;
            axis.direction = frame.rotation.matrix().column(2).into();
            joint.kind.move_along(&mut frame, q);
        }
        self.tool_pose = frame * robot.tool();
        let tool_point = self.tool_pose.translation.vector;
        let columns = self.jacobian.as_mut_slice().chunks_exact_mut(6);
        for (entries, axis) in columns.zip(&self.joints) {
            let (linear, angular) = axis.velocity_of(&tool_point);
            entries[..3].copy_from_slice(linear.as_slice());
            entries[3..].copy_from_slice(angular.as_slice());
        }
        Ok(())
    }

    /// Returns q, the joint positions, n.
    pub fn joint_position(&self) -> &[f64] {
        &self.joint_position
    }

    /// Returns the pose of the tool frame in the base frame, m.
    pub fn tool_pose(&self) -> &IsometryMatrix3<f64> {
        &self.tool_pose
    }

    /// Returns J, the tool Jacobian, 6 × n.
    pub fn jacobian(&self) -> &Jacobian {
        &self.jacobian
    }

    /// Returns the origin of a joint's frame (index from 0) in the base frame, m, and its Jacobian, 3 × n, m/s.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such joint.
    pub fn joint_origin(&self, joint: usize) -> (Vector3<f64>, Matrix3xX<f64>) {
        let origin = self.joints[joint].origin;
        let mut jacobian = Matrix3xX::zeros(self.joints.len());
        for (i, axis) in self.joints[..joint].iter().enumerate() {
            jacobian.set_column(i, &axis.velocity_of(&origin).0);
        }
        (origin, jacobian)
    }

    /// Returns the tool's twist J q̇ for joint velocities q̇ (n), along the base axes, at the tool point.
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

fn check(robot: &RobotModel, joint_position: &[f64]) -> Result<(), ConfigurationError> {
    if joint_position.len() != robot.joint_count() {
        return Err(ConfigurationError::Size { expected: robot.joint_count(), given: joint_position.len() });
    }
    match robot.joints().iter().zip(joint_position).find(|(_, q)| !q.is_finite()) {
        Some((joint, _)) => Err(ConfigurationError::NotFinite { joint: joint.name.clone() }),
        None => Ok(()),
    }
}

impl JointAxis {
    fn along_base_z(kind: JointKind) -> Self {
        Self { kind, origin: Vector3::zeros(), direction: Vector3::z() }
    }

    /// Returns one column of the geometric Jacobian: the linear and angular velocity of a point of the tool (m, base
    /// frame) if the joint moves at unit speed.
    fn velocity_of(&self, point: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        self.kind.unit_velocity(self.direction, &(point - self.origin))
    }
}

/// Returns the frames of the joints after their motion, base first (n), in the base frame, m.
///
/// `joint_position`: q, n; rad or m.
///
/// Each frame has its origin on the axis of its joint and its z along it. The tool frame is the last one times
/// [`RobotModel::tool`].
pub fn link_frames(
    robot: &RobotModel,
    joint_position: &[f64],
) -> Result<Vec<IsometryMatrix3<f64>>, ConfigurationError> {
    check(robot, joint_position)?;
    let mut frame = IsometryMatrix3::identity();
    let joints = robot.joints().iter().zip(joint_position);
    Ok(joints
        .map(|(joint, &q)| {
            frame *= joint.placement;
            joint.kind.move_along(&mut frame, q);
            frame
        })
        .collect())
}

/// Returns log(R R_dᵀ), the rotation vector (rad, base axes) from the desired orientation to the actual one.
///
/// It is X − X_d of the control laws for the angular rows.
pub fn orientation_error(actual: &Rotation3<f64>, desired: &Rotation3<f64>) -> Vector3<f64> {
    // Computed from the quaternion: the arc cosine of a rotation matrix cannot resolve angles below 1e-8 rad.
    UnitQuaternion::from_rotation_matrix(&(actual * desired.inverse())).scaled_axis()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::built_in;

    #[test]
    fn the_last_link_frame_carries_the_tool_and_the_first_is_at_the_first_joint() {
        let sawyer = &built_in()[0];
        let posture = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];
        let frames = link_frames(sawyer, &posture).unwrap();
        let tool = frames[6] * sawyer.tool();
        let expected = Configuration::new(sawyer, &posture).unwrap();
        assert!((tool.to_homogeneous() - expected.tool_pose().to_homogeneous()).norm() < 1e-15);
        assert_eq!(frames[0].translation, sawyer.joints()[0].placement.translation);
        assert!(link_frames(sawyer, &posture[1..]).is_err());
    }

    #[test]
    fn invalid_postures_are_refused_with_the_name_of_the_joint() {
        let sawyer = &built_in()[0];
        assert_eq!(Configuration::new(sawyer, &[0.0; 6]), Err(ConfigurationError::Size { expected: 7, given: 6 }));
        let error = Configuration::new(sawyer, &[0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0]).unwrap_err();
        assert!(error.to_string().contains("`j3`"));
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
