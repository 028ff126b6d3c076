//! Rows of axes of the tool, and their target pose.

use nalgebra::{Isometry3, IsometryMatrix3, Rotation3, UnitQuaternion, Vector3};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{
    AxisSelection, Configuration, Frame, PlacedFrame, RotationMotion, TaskFrame, orientation_error,
};

use super::kind::RowKind;
use super::rows_error::RowsError;
use crate::arm_state::{ArmAt, ArmState};
use crate::law::{Law, Profile, SetPoint, TaskState, TaskVector};
use crate::linalg::Matrix;
use crate::streaming::{ActiveStream, Reference, TargetValue};

/// Axes of the tool in a frame, and their target pose.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolRows {
    /// The axes, one per row.
    pub axes: AxisSelection,
    /// The reference point and the frame of the axes.
    pub frame: TaskFrame,
    /// Target pose X_d.
    pub target_pose: TargetPose,
    /// Displacement added to X_d over time, m entries, m and rad (rotation vector), along the axes of the frame. In the
    /// tool frame: along the tool's axes in the target pose.
    pub target_displacement: Option<Profile>,
}

/// The target pose X_d, from which displacements ΔX are measured.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum TargetPose {
    /// The pose of the tool at the first step.
    #[default]
    Initial,
    /// A pose (m) of the frame at the reference point, parallel to the tool frame. It is given in the task's fixed
    /// frame, if the task has one, otherwise in the base frame.
    Fixed(IsometryMatrix3<f64>),
}

impl ToolRows {
    /// Builds rows along the base axes at the tool point, with the pose at the first step as target.
    pub fn new(axes: AxisSelection) -> Self {
        Self { axes, frame: TaskFrame::default(), target_pose: TargetPose::Initial, target_displacement: None }
    }

    /// Overwrites `jacobian` with J_k, m × n.
    pub(super) fn write_jacobian(&self, at: ArmAt, jacobian: &mut Matrix) {
        self.placed(at).write_rows(&self.axes, jacobian);
    }

    /// Overwrites `jacobian` with the rows at one posture along the axes of another one, m × n.
    pub(super) fn write_jacobian_along(&self, at: ArmAt, axes_at: ArmAt, jacobian: &mut Matrix) {
        self.placed(at).along_axes_of(&self.placed(axes_at)).write_rows(&self.axes, jacobian);
    }

    /// Returns J_k q̇, m.
    pub(super) fn velocity(&self, at: ArmAt) -> TaskVector {
        let placed = self.placed(at);
        self.select(&placed.body_twist(&at.arm.joint_velocity).unwrap_or_else(|| placed.twist(&at.arm.twist)))
    }

    /// Places the frame, whose axes follow the normal of a surface if a task in it does.
    fn placed<'a>(&'a self, at: ArmAt<'a>) -> PlacedFrame<'a> {
        self.frame.at(at.configuration).turned(at.arm.turn_of(&self.frame))
    }

    /// Selects the entries of a twist or a wrench, m.
    fn select(&self, six: &[f64; 6]) -> TaskVector {
        let axes = self.axes.axes();
        TaskVector::from_fn(axes.len(), |row| six[axes[row].index()])
    }

    /// Returns the state for the law; `velocity`: Ẋ, m.
    pub(super) fn state(&self, velocity: TaskVector, at: ArmAt, streamed: Option<&ActiveStream>) -> TaskState {
        let ArmAt { arm, configuration, time_s } = at;
        let placed = self.placed(at);
        let rows = |[linear, angular]: [Vector3<f64>; 2]| self.select(&placed.components(linear, angular));
        let target = streamed.and_then(MovingPose::streamed).unwrap_or_else(|| self.target(arm, time_s));
        let actual = self.pose(configuration);
        let displacement = [
            actual.translation.vector - target.pose.translation.vector,
            orientation_error(&actual.rotation, &target.pose.rotation),
        ];
        TaskState {
            time_s: arm.profile_time(time_s),
            velocity,
            displacement: rows(displacement),
            target_velocity: rows(target.velocity),
            target_acceleration: rows(target.acceleration),
            force: self.force(arm, &placed),
            streamed: None,
        }
    }

    /// Returns F_e, m. Wrenches are measured at tips: no law of another body reads one.
    fn force(&self, arm: &ArmState, placed: &PlacedFrame) -> TaskVector {
        match self.frame.tip(&arm.robot) {
            Some(tip) => self.select(&placed.wrench(&arm.wrenches[tip])),
            None => TaskVector::zeros(self.axes.len()),
        }
    }

    /// Returns the direction of a row in the axes of the base, a unit vector.
    pub(super) fn direction(&self, row: usize, at: ArmAt) -> Vector3<f64> {
        let placed = self.placed(at);
        let along = |unit: Vector3<f64>| self.select(&placed.components(unit, unit))[row];
        Vector3::new(along(Vector3::x()), along(Vector3::y()), along(Vector3::z()))
    }

    /// Returns F_e, m.
    pub(super) fn force_at(&self, at: ArmAt) -> TaskVector {
        self.force(at.arm, &self.placed(at))
    }

    /// Checks that the robot has the links of the body, and that the law reads no wrench of a body that is no tip.
    pub(super) fn check_body(&self, robot: &RobotModel, law: &Law) -> Result<(), RowsError> {
        let Some(body) = &self.frame.body else { return Ok(()) };
        if body.last_link().index() >= robot.links().len() {
            return Err(RowsError::Link);
        }
        if law.reads_wrench() && self.frame.tip(robot).is_none() { Err(RowsError::LinkLaw) } else { Ok(()) }
    }

    /// Returns whether the axis of a row is linear or angular.
    pub(super) fn kind<'a>(&self, row: usize) -> RowKind<'a> {
        if self.axes.axes()[row].index() < 3 { RowKind::Linear } else { RowKind::Angular }
    }

    /// Returns the own target.
    pub(super) fn own_reference(&self, arm: &ArmState) -> Reference {
        let MovingPose { pose, velocity: [linear, angular], .. } = self.target(arm, arm.time_s);
        let velocity = TaskVector::from_slice(&[linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]);
        Reference { value: TargetValue::Pose(quaternion_pose(&pose)), velocity }
    }

    /// Returns the measured pose with a velocity of the task, m.
    pub(super) fn actual(&self, velocity: &[f64], at: ArmAt) -> Reference {
        let pose = self.pose(at.configuration);
        let axes = self.rotation(&pose.rotation);
        let velocity = self.displacement(velocity, &at.arm.turn_of(&self.frame).map_or(axes, |turn| turn * axes));
        Reference { value: TargetValue::Pose(quaternion_pose(&pose)), velocity }
    }

    /// Returns the pose of a streamed target, base frame; a part that is not given is that of the arm.
    pub(super) fn streamed_pose(
        &self,
        position: Option<Vector3<f64>>,
        orientation: Option<UnitQuaternion<f64>>,
        at: ArmAt,
    ) -> TargetValue {
        let actual = self.pose(at.configuration);
        let frame = match self.frame.frame {
            Frame::Base | Frame::Tool => Isometry3::identity(),
            Frame::Fixed(frame) => quaternion_pose(&frame),
        };
        let mut pose = quaternion_pose(&actual);
        if let Some(position) = position {
            pose.translation.vector = (frame * nalgebra::Point3::from(position)).coords;
        }
        if let Some(orientation) = orientation {
            pose.rotation = frame.rotation * orientation;
        }
        TargetValue::Pose(pose)
    }

    /// Returns the velocity of a streamed target along the rows as a displacement per second, base axes.
    pub(super) fn target_velocity(&self, velocity: &[f64], target: &TargetValue) -> TaskVector {
        match target {
            TargetValue::Pose(pose) => self.displacement(velocity, &self.rotation(&pose.rotation.to_rotation_matrix())),
            TargetValue::Rows(_) => TaskVector::from_slice(velocity),
        }
    }

    /// Returns entries of the rows as a linear and an angular vector, base axes; `axes`: the rotation from the rows to these.
    fn displacement(&self, entries: &[f64], axes: &Rotation3<f64>) -> TaskVector {
        let [linear, angular] = self.vectors(entries, axes);
        TaskVector::from_slice(&[linear.x, linear.y, linear.z, angular.x, angular.y, angular.z])
    }

    /// Returns the pose at the reference point, m.
    fn pose(&self, configuration: &Configuration) -> IsometryMatrix3<f64> {
        self.frame.pose(&self.frame.body_pose(configuration))
    }

    /// Returns the pose at the reference point at the first step, m.
    fn initial_pose(&self, arm: &ArmState) -> IsometryMatrix3<f64> {
        match &self.frame.body {
            Some(body) => self.frame.pose(&body.pose(arm.initial())),
            None => self.frame.pose(&arm.initial_pose),
        }
    }

    /// Returns the rotation from the stated axes of the rows to the base axes; `target`: the orientation whose axes the tool frame
    /// stands for.
    fn rotation(&self, target: &Rotation3<f64>) -> Rotation3<f64> {
        match self.frame.frame {
            Frame::Base => Rotation3::identity(),
            Frame::Tool => *target,
            Frame::Fixed(frame) => frame.rotation,
        }
    }

    fn vectors(&self, entries: &[f64], axes: &Rotation3<f64>) -> [Vector3<f64>; 2] {
        let [x, y, z, rx, ry, rz] = self.axes.scatter(entries);
        [axes * Vector3::new(x, y, z), axes * Vector3::new(rx, ry, rz)]
    }

    /// Returns X_d with its derivatives at a time.
    fn target(&self, arm: &ArmState, time_s: f64) -> MovingPose {
        let pose = match (self.target_pose, self.frame.frame) {
            (TargetPose::Initial, _) => self.initial_pose(arm),
            (TargetPose::Fixed(pose), Frame::Fixed(frame)) => frame * pose,
            (TargetPose::Fixed(pose), Frame::Base | Frame::Tool) => pose,
        };
        let Some(displacement) = &self.target_displacement else { return MovingPose::resting(pose) };
        let axes = self.rotation(&pose.rotation);
        let displacement = displacement.at(arm.profile_time(arm.known_time(displacement, time_s)));
        MovingPose::displaced(&pose, &displacement, |entries| self.vectors(entries, &axes))
    }
}

/// Returns a pose with its orientation as a quaternion.
fn quaternion_pose(pose: &IsometryMatrix3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(pose.translation, UnitQuaternion::from_rotation_matrix(&pose.rotation))
}

/// A pose with its linear and angular velocity and acceleration, base axes.
struct MovingPose {
    pose: IsometryMatrix3<f64>,
    velocity: [Vector3<f64>; 2],
    acceleration: [Vector3<f64>; 2],
}

impl MovingPose {
    fn resting(pose: IsometryMatrix3<f64>) -> Self {
        Self { pose, velocity: [Vector3::zeros(); 2], acceleration: [Vector3::zeros(); 2] }
    }

    /// Returns the target of a stream; `None` if it is no pose.
    fn streamed(active: &ActiveStream) -> Option<Self> {
        let TargetValue::Pose(pose) = &active.stream.reference.value else { return None };
        let vectors = |six: &TaskVector| [Vector3::new(six[0], six[1], six[2]), Vector3::new(six[3], six[4], six[5])];
        Some(Self {
            pose: IsometryMatrix3::from_parts(pose.translation, pose.rotation.to_rotation_matrix()),
            velocity: vectors(&active.velocity),
            acceleration: vectors(&active.acceleration),
        })
    }

    /// Returns the pose moved by a displacement. `vectors` converts entries to linear and angular vectors, base axes.
    fn displaced(
        pose: &IsometryMatrix3<f64>,
        displacement: &SetPoint,
        vectors: impl Fn(&[f64]) -> [Vector3<f64>; 2],
    ) -> Self {
        let [moved, turned] = vectors(&displacement.value);
        let [linear_rate, angular_rate] = vectors(&displacement.rate);
        let [linear_acceleration, angular_acceleration] = vectors(&displacement.acceleration);
        let rotation = RotationMotion::new(turned, angular_rate, angular_acceleration);
        let position = pose.translation.vector + moved;
        Self {
            pose: IsometryMatrix3::from_parts(position.into(), rotation.rotation * pose.rotation),
            velocity: [linear_rate, rotation.velocity],
            acceleration: [linear_acceleration, rotation.acceleration],
        }
    }
}
