//! The forward kinematics of an arm at a posture.
#![allow(non_snake_case)]

use nalgebra::{IsometryMatrix3, Matrix6xX, Rotation3, UnitQuaternion, Vector3};

use super::chain::JointAxis;
use super::moving_frame::vector;
use crate::RobotModel;

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
    /// n.
    axes: Vec<JointAxis>,
    tool_pose: IsometryMatrix3<f64>,
    jacobian: Jacobian,
}

impl Configuration {
    /// Computes tool pose and Jacobian at `joint_position` (n; rad or m).
    pub fn new(robot: &RobotModel, joint_position: &[f64]) -> Result<Self, ConfigurationError> {
        check(robot, joint_position)?;
        let n = joint_position.len();
        let mut configuration = Self {
            joint_position: joint_position.to_vec(),
            axes: vec![JointAxis::BASE_Z; n],
            tool_pose: IsometryMatrix3::identity(),
            // Every entry is overwritten. Memory of zeros would cost hundreds of instructions more in glibc.
            jacobian: Jacobian::repeat(n, f64::NAN),
        };
        configuration.compute(robot);
        Ok(configuration)
    }

    /// Updates to another posture of the same robot. On an error the configuration stays unchanged.
    pub fn update(&mut self, robot: &RobotModel, joint_position: &[f64]) -> Result<(), ConfigurationError> {
        check(robot, joint_position)?;
        self.joint_position.copy_from_slice(joint_position);
        self.compute(robot);
        Ok(())
    }

    /// Computes all other fields from the joint positions.
    fn compute(&mut self, robot: &RobotModel) {
        // The memory of the Jacobian serves as scratch until its entries are known.
        let tool = robot.chain().place(&self.joint_position, &mut self.axes, self.jacobian.as_mut_slice());
        self.tool_pose = tool.pose();
        let [px, py, pz, _] = tool.origin();
        let (columns, _) = self.jacobian.as_mut_slice().as_chunks_mut::<6>();
        for (column, axis) in columns.iter_mut().zip(&self.axes) {
            let ([x, y, z, _], [ox, oy, oz, _]) = (axis.direction, axis.origin);
            let [dx, dy, dz] = [px - ox, py - oy, pz - oz];
            *column = [y * dz - z * dy, z * dx - x * dz, x * dy - y * dx, x, y, z];
        }
        for &joint in robot.chain().prismatic() {
            let [x, y, z, _] = self.axes[joint].direction;
            columns[joint] = [x, y, z, 0.0, 0.0, 0.0];
        }
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

    /// Returns the origin of a joint's frame (index from 0) in the base frame, m.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such joint.
    pub fn joint_origin(&self, joint: usize) -> Vector3<f64> {
        vector(&self.axes[joint].origin)
    }

    /// Returns the columns of the Jacobian of a point (base frame, m) that only the first `moving_joints` joints move, n, m/s.
    ///
    /// The origin of joint j (index from 0) is moved by the first j joints, the tool point by all.
    pub fn point_jacobian(&self, point: Vector3<f64>, moving_joints: usize) -> impl Iterator<Item = Vector3<f64>> {
        let lever = point - self.tool_pose.translation.vector;
        self.jacobian.column_iter().enumerate().map(move |(joint, column)| {
            if joint < moving_joints {
                column.fixed_rows::<3>(0) + column.fixed_rows::<3>(3).cross(&lever)
            } else {
                Vector3::zeros()
            }
        })
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
    if joint_position.iter().all(|q| q.is_finite()) { Ok(()) } else { Err(not_finite(robot, joint_position)) }
}

/// Returns the error that names the first joint without a finite position.
#[cold]
fn not_finite(robot: &RobotModel, joint_position: &[f64]) -> ConfigurationError {
    let joint = robot.joints().iter().zip(joint_position).find(|(_, q)| !q.is_finite());
    ConfigurationError::NotFinite { joint: joint.map(|(joint, _)| joint.name.clone()).unwrap_or_default() }
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
    use nalgebra::{Matrix3xX, Translation3};
    use proptest::prelude::*;

    use super::*;
    use crate::{Joint, JointKind, JointLimits, built_in};

    /// 1 to 128 joints of both kinds with a position each, placed anyhow, and a tool.
    fn any_robot() -> impl Strategy<Value = (RobotModel, Vec<f64>)> {
        let vector = || prop::array::uniform3(-1.0..1.0_f64).prop_map(Vector3::from);
        let transform = move || (vector(), vector()).prop_map(|(shift, turn)| IsometryMatrix3::new(shift, turn * 4.0));
        let joint = (transform(), prop::bool::ANY, -4.0..4.0_f64);
        (prop::collection::vec(joint, 1..=128), transform()).prop_map(|(joints, tool)| {
            let positions = joints.iter().map(|(_, _, position)| *position).collect();
            let joint = |(i, (placement, revolute, _)): (usize, &(_, bool, f64))| Joint {
                name: i.to_string(),
                kind: if *revolute { JointKind::Revolute } else { JointKind::Prismatic },
                placement: *placement,
                limits: JointLimits::NONE,
                published_range: None,
                denavit_hartenberg: None,
            };
            (RobotModel::new("any", "", joints.iter().enumerate().map(joint).collect(), tool).unwrap(), positions)
        })
    }

    proptest! {
        #[test]
        fn chains_of_every_length_equal_the_product_of_their_transforms((robot, q) in any_robot()) {
            let configuration = Configuration::new(&robot, &q).unwrap();
            let frames = link_frames(&robot, &q).unwrap();
            let tolerance = 1e-14 * q.len() as f64;
            let tool = frames[q.len() - 1] * robot.tool();
            prop_assert!((configuration.tool_pose().to_homogeneous() - tool.to_homogeneous()).amax() < tolerance);
            for (j, (joint, frame)) in robot.joints().iter().zip(&frames).enumerate() {
                let z = frame.rotation * Vector3::z();
                let origin = configuration.joint_origin(j);
                let (expected_origin, linear, angular) = match joint.kind {
                    JointKind::Revolute => {
                        let origin = frame.translation.vector;
                        (origin, z.cross(&(tool.translation.vector - origin)), z)
                    }
                    JointKind::Prismatic => (frame.translation.vector - z * q[j], z, Vector3::zeros()),
                };
                prop_assert!((origin - expected_origin).amax() < tolerance, "origin of joint {j}");
                let column = configuration.jacobian().column(j);
                prop_assert!((column.fixed_rows::<3>(0) - linear).amax() < tolerance, "linear rows of joint {j}");
                prop_assert!((column.fixed_rows::<3>(3) - angular).amax() < tolerance, "angular rows of joint {j}");
            }
        }

        #[test]
        fn the_jacobian_of_a_joint_origin_is_that_of_a_robot_which_ends_there((robot, q) in any_robot()) {
            let last = q.len() - 1;
            let whole = Configuration::new(&robot, &q).unwrap();
            let origin = whole.joint_origin(last);
            let jacobian = Matrix3xX::from_columns(&whole.point_jacobian(origin, last).collect::<Vec<_>>());
            prop_assert_eq!(jacobian.column(last).amax(), 0.0);
            if last > 0 {
                let (joints, placement) = (robot.joints()[..last].to_vec(), robot.joints()[last].placement);
                let shorter = RobotModel::new("shorter", "", joints, placement).unwrap();
                let end = Configuration::new(&shorter, &q[..last]).unwrap();
                let tolerance = 1e-14 * q.len() as f64;
                prop_assert!((origin - end.tool_pose().translation.vector).amax() < tolerance);
                prop_assert!((jacobian.columns(0, last) - end.jacobian().fixed_rows::<3>(0)).amax() < tolerance);
            }
        }
    }

    #[test]
    fn an_update_gives_the_bits_of_a_new_configuration_and_an_error_changes_nothing() {
        let sawyer = &built_in()[0];
        let (first, second) = ([0.1; 7], [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]);
        let mut configuration = Configuration::new(sawyer, &first).unwrap();
        configuration.update(sawyer, &second).unwrap();
        assert_eq!(configuration, Configuration::new(sawyer, &second).unwrap());
        assert!(configuration.update(sawyer, &[f64::INFINITY; 7]).is_err());
        assert!(configuration.update(sawyer, &first[1..]).is_err());
        assert_eq!(configuration, Configuration::new(sawyer, &second).unwrap());
    }

    #[test]
    fn a_joint_after_many_turns_has_the_pose_of_the_same_angle() {
        let planar = built_in().iter().find(|robot| robot.name() == "planar_3r").unwrap();
        for q in [1e5, 1e15] {
            let tool = Configuration::new(planar, &[q, 0.0, 0.0]).unwrap().tool_pose().translation;
            let expected = Translation3::new(1.2 * q.cos(), 1.2 * q.sin(), 0.0);
            assert!((tool.vector - expected.vector).amax() < 1e-15, "{q:e}");
        }
    }

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
