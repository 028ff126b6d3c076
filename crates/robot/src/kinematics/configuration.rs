//! The forward kinematics of a robot at a posture.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};

use super::jacobian::{Jacobian, Mover, write_jacobian};
use super::link_point::LinkPoint;
use super::posture_check::{ConfigurationError, check};
use crate::forward::{JointFrame, vector};
use crate::tree::Tree;
use crate::{LinkId, RobotModel, Tip};

/// Length that rounding leaves of a row of zero of a Jacobian, over its scale.
const ROUNDING: f64 = 1e-12;

/// Joint positions of a robot with the tool pose and Jacobian there. Poses and Jacobians of other links are computed from
/// the frames of the joints when they are asked for.
///
/// A value exists only after forward kinematics, so all poses and Jacobians belong to the joint positions. The base frame
/// is the frame of the base link. Links and tips must be those of the same robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    tree: Arc<Tree>,
    /// n.
    joint_position: Vec<f64>,
    /// The frames of the moving joints.
    frames: Vec<JointFrame>,
    tool_pose: IsometryMatrix3<f64>,
    jacobian: Jacobian,
    /// Positions of the moving joints and two more numbers for each; empty for a serial arm.
    scratch: Vec<f64>,
}

impl Configuration {
    /// Computes tool pose and Jacobian at `joint_position` (n; rad or m).
    pub fn new(robot: &RobotModel, joint_position: &[f64]) -> Result<Self, ConfigurationError> {
        check(robot, joint_position)?;
        let tree = Arc::clone(robot.tree());
        let moving = tree.moving().len();
        let mut configuration = Self {
            joint_position: joint_position.to_vec(),
            frames: vec![JointFrame::BASE; moving],
            tool_pose: IsometryMatrix3::identity(),
            // Every entry is overwritten. Memory of zeros would cost hundreds of instructions more in glibc.
            jacobian: Jacobian::repeat(joint_position.len(), f64::NAN),
            scratch: if tree.forward().is_serial() { Vec::new() } else { vec![0.0; 3 * moving] },
            tree,
        };
        configuration.compute();
        Ok(configuration)
    }

    /// Updates to another posture. On an error the configuration stays unchanged.
    ///
    /// It allocates only if `robot` is another one than before.
    pub fn update(&mut self, robot: &RobotModel, joint_position: &[f64]) -> Result<(), ConfigurationError> {
        check(robot, joint_position)?;
        if !Arc::ptr_eq(&self.tree, robot.tree()) {
            *self = Self::new(robot, joint_position)?;
            return Ok(());
        }
        self.joint_position.copy_from_slice(joint_position);
        self.compute();
        Ok(())
    }

    /// Computes all other fields from the joint positions.
    fn compute(&mut self) {
        if self.tree.forward().is_serial() { self.compute_serial() } else { self.compute_tree() }
    }

    fn compute_serial(&mut self) {
        let forward = self.tree.forward();
        // The memory of the Jacobian serves as scratch until its entries are known.
        let tool = forward.place_serial(&self.joint_position, &mut self.frames, self.jacobian.as_mut_slice());
        self.tool_pose = tool.pose();
        let [px, py, pz, _] = tool.origin();
        let (columns, _) = self.jacobian.as_mut_slice().as_chunks_mut::<6>();
        for (column, frame) in columns.iter_mut().zip(&self.frames) {
            let ([x, y, z, _], [ox, oy, oz, _]) = (frame.direction, frame.origin);
            let [dx, dy, dz] = [px - ox, py - oy, pz - oz];
            *column = [y * dz - z * dy, z * dx - x * dz, x * dy - y * dx, x, y, z];
        }
        for &joint in forward.prismatic() {
            let [x, y, z, _] = self.frames[joint].direction;
            columns[joint] = [x, y, z, 0.0, 0.0, 0.0];
        }
    }

    fn compute_tree(&mut self) {
        let Self { tree, joint_position, frames, tool_pose, jacobian, scratch } = self;
        let (position, scratch) = scratch.split_at_mut(frames.len());
        for (position, joint) in position.iter_mut().zip(tree.moving()) {
            *position = joint.position(joint_position);
        }
        *tool_pose = tree.forward().place_tree(position, frames, scratch).pose();
        let ends = [Some(tree.tool_joint()), None];
        write_jacobian(tree, frames, ends, &tool_pose.translation.vector, jacobian);
    }

    /// Returns q, the joint positions, n.
    pub fn joint_position(&self) -> &[f64] {
        &self.joint_position
    }

    /// Returns the pose of the tool frame in the base frame, m. The tool is the first tip.
    pub fn tool_pose(&self) -> &IsometryMatrix3<f64> {
        &self.tool_pose
    }

    /// Returns J, the tool Jacobian, 6 × n.
    pub fn jacobian(&self) -> &Jacobian {
        &self.jacobian
    }

    /// Returns the pose of a link's frame in the base frame, m.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such link.
    pub fn link_pose(&self, link: LinkId) -> IsometryMatrix3<f64> {
        let link = &self.tree.links()[link.index()];
        let Some(joint) = link.joint else { return link.placement };
        let position = self.tree.moving()[joint].position(&self.joint_position);
        self.tree.forward().moved_frame(joint, &self.frames[joint], position) * link.placement
    }

    /// Returns the pose of a tip in the base frame, m.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such link.
    pub fn tip_pose(&self, tip: &Tip) -> IsometryMatrix3<f64> {
        self.link_pose(tip.link) * tip.offset
    }

    /// Returns the pose of a point, parallel to its link, in the frame of the link from which it is seen, m.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such link.
    pub fn point_pose(&self, point: &LinkPoint) -> IsometryMatrix3<f64> {
        let mut pose = self.link_pose(point.link);
        pose.translation.vector += pose.rotation * point.point;
        if point.relative_to == LinkId::BASE { pose } else { self.link_pose(point.relative_to).inv_mul(&pose) }
    }

    /// Overwrites `jacobian` (6 × n) with that of a point of a link, along the base axes, without allocating.
    ///
    /// J q̇ is the twist of [`Self::point_twist`]. Joints that move both links, and joints that move neither, have columns
    /// of zeros.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such link, or if `jacobian` does not have n columns.
    pub fn write_point_jacobian(&self, point: &LinkPoint, jacobian: &mut Jacobian) {
        assert_eq!(jacobian.ncols(), self.joint_position.len(), "one column per joint");
        write_jacobian(&self.tree, &self.frames, self.ends(point), &self.position(point), jacobian);
    }

    /// Returns the twist of a point of a link, along the base axes, for joint velocities q̇ (n): m/s, then rad/s.
    ///
    /// Seen from a moving link, it is the velocity of the point less the velocity that the point would have if it were
    /// fixed to that link, and the difference of both angular velocities.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such link, or if there are fewer than n velocities.
    pub fn point_twist(&self, point: &LinkPoint, joint_velocity: &[f64]) -> [f64; 6] {
        let mut twist = [0.0; 6];
        for (coordinate, column) in self.point_columns(point) {
            twist.iter_mut().zip(column).for_each(|(entry, slope)| *entry += slope * joint_velocity[coordinate]);
        }
        twist
    }

    /// Returns the joints (index from 0) that move a point of a link, and what each moving joint adds to its column of the Jacobian, along
    /// the base axes.
    pub(super) fn point_columns<'a>(&'a self, point: &LinkPoint) -> impl Iterator<Item = (usize, [f64; 6])> + use<'a> {
        let position = self.position(point);
        let [carrier, observer] = self.ends(point);
        Mover::between(&self.tree, carrier, observer)
            .map(move |mover| mover.column(&self.tree, &self.frames, &position))
    }

    /// Returns the frames that the moving joints move, in the base frame.
    pub(crate) fn moved_frames(&self) -> impl Iterator<Item = IsometryMatrix3<f64>> {
        self.frames.iter().zip(self.tree.moving()).enumerate().map(|(index, (frame, joint))| {
            self.tree.forward().moved_frame(index, frame, joint.position(&self.joint_position))
        })
    }

    /// Returns the joints (index from 0) that move one of two points relative to the other one, and how fast each of them moves the first
    /// point away from the second one, base axes; `carriers`: the moving joints that carry them, `points`: base frame, m.
    pub(crate) fn apart_columns<'a>(
        &'a self,
        [first, second]: [Option<usize>; 2],
        [x, y]: [&'a Vector3<f64>; 2],
    ) -> impl Iterator<Item = (usize, [f64; 3])> + use<'a> {
        Mover::between(&self.tree, first, second).map(move |mover| {
            let point = if mover.moves_carrier() { x } else { y };
            let (coordinate, [dx, dy, dz, ..]) = mover.column(&self.tree, &self.frames, point);
            (coordinate, [dx, dy, dz])
        })
    }

    /// Returns the moving joints that carry the link of a point and the link from which it is seen.
    fn ends(&self, point: &LinkPoint) -> [Option<usize>; 2] {
        [point.link, point.relative_to].map(|link| self.tree.links()[link.index()].joint)
    }

    /// Returns a point in the base frame, m.
    fn position(&self, point: &LinkPoint) -> Vector3<f64> {
        let pose = self.link_pose(point.link);
        pose.translation.vector + pose.rotation * point.point
    }

    /// Returns the origin of the frame of a joint with a coordinate (index from 0) in the base frame, m.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such joint.
    pub fn joint_origin(&self, joint: usize) -> Vector3<f64> {
        vector(&self.frames[self.tree.moving_joint_of(joint)].origin)
    }

    /// Returns the length that rounding leaves at most of a row of zero of a Jacobian, angular or linear (m): some thousand times 2⁻⁵² of 1, or of
    /// the largest distance of a joint or the tool from the base.
    pub fn rounding(&self, is_angular: bool) -> f64 {
        let distances = (0..self.joint_position.len()).map(|joint| self.joint_origin(joint).norm());
        let reach = || distances.fold(self.tool_pose.translation.vector.norm(), f64::max);
        if is_angular { ROUNDING } else { ROUNDING * reach() }
    }

    /// Returns the columns of the Jacobian of the tool point, n, m/s.
    pub fn tool_point_jacobian(&self) -> impl Iterator<Item = Vector3<f64>> {
        self.jacobian.column_iter().map(|column| column.fixed_rows::<3>(0).into_owned())
    }

    /// Returns the columns of the Jacobian of a point of a link, along the base axes, n, m/s.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such link.
    pub fn link_point_jacobian(&self, point: LinkPoint) -> impl Iterator<Item = Vector3<f64>> {
        (0..self.joint_position.len()).map(move |joint| {
            let own = self.point_columns(&point).filter(|(coordinate, _)| *coordinate == joint);
            own.map(|(_, [x, y, z, ..])| Vector3::new(x, y, z)).sum()
        })
    }

    /// Returns the columns of the Jacobian of [`Self::joint_origin`], n, m/s. The joints above that joint move it.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such joint.
    pub fn joint_origin_jacobian(&self, joint: usize) -> impl Iterator<Item = Vector3<f64>> {
        let (origin, is_serial) = (self.joint_origin(joint), self.tree.forward().is_serial());
        let above = self.tree.moving()[self.tree.moving_joint_of(joint)].parent;
        let lever = origin - self.tool_pose.translation.vector;
        self.jacobian.column_iter().enumerate().map(move |(j, column)| {
            if is_serial && j < joint {
                return column.fixed_rows::<3>(0) + column.fixed_rows::<3>(3).cross(&lever);
            }
            let mut sum = Vector3::zeros();
            if !is_serial {
                for mover in Mover::between(&self.tree, above, None) {
                    let (coordinate, [x, y, z, ..]) = mover.column(&self.tree, &self.frames, &origin);
                    sum += if coordinate == j { Vector3::new(x, y, z) } else { Vector3::zeros() };
                }
            }
            sum
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

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3xX, Translation3};
    use proptest::prelude::*;

    use super::*;
    use crate::kinematics::link_frames;
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
            let jacobian = Matrix3xX::from_columns(&whole.joint_origin_jacobian(last).collect::<Vec<_>>());
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
    fn invalid_postures_are_refused_with_the_name_of_the_joint() {
        let sawyer = &built_in()[0];
        assert_eq!(Configuration::new(sawyer, &[0.0; 6]), Err(ConfigurationError::Size { expected: 7, given: 6 }));
        let error = Configuration::new(sawyer, &[0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0]).unwrap_err();
        assert!(error.to_string().contains("`j3`"));
    }
}
