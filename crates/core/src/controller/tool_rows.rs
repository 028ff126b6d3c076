//! Tasks of axes of the tool, and their target pose.

use nalgebra::{IsometryMatrix3, Rotation3, Vector3};
use revprio_robot::kinematics::{AxisSelection, Frame, RotationMotion, TaskFrame, orientation_error};

use super::task::ArmState;
use crate::law::{Profile, SetPoint, TaskState};
use crate::linalg::TaskVector;

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

    /// Selects the entries of a twist or a wrench, m.
    pub(super) fn select(&self, six: &[f64; 6]) -> TaskVector {
        let axes = self.axes.axes();
        TaskVector::from_fn(axes.len(), |row| six[axes[row].index()])
    }

    /// Returns the state for the law; `velocity`: Ẋ, m.
    pub(super) fn state(&self, velocity: TaskVector, arm: &ArmState) -> TaskState {
        let placed = self.frame.at(arm.configuration);
        let rows = |[linear, angular]: [Vector3<f64>; 2]| self.select(&placed.components(linear, angular));
        let target = self.target(arm);
        let actual = self.frame.pose(arm.configuration.tool_pose());
        let displacement = [
            actual.translation.vector - target.pose.translation.vector,
            orientation_error(&actual.rotation, &target.pose.rotation),
        ];
        TaskState {
            time_s: arm.time_s,
            velocity,
            displacement: rows(displacement),
            target_velocity: rows(target.velocity),
            target_acceleration: rows(target.acceleration),
            force: self.select(&placed.wrench(&arm.wrench)),
        }
    }

    /// Returns X_d with its derivatives.
    fn target(&self, arm: &ArmState) -> MovingPose {
        let pose = match (self.target_pose, self.frame.frame) {
            (TargetPose::Initial, _) => self.frame.pose(&arm.initial_pose),
            (TargetPose::Fixed(pose), Frame::Fixed(frame)) => frame * pose,
            (TargetPose::Fixed(pose), Frame::Base | Frame::Tool) => pose,
        };
        let Some(displacement) = &self.target_displacement else { return MovingPose::resting(pose) };
        let axes = match self.frame.frame {
            Frame::Base => Rotation3::identity(),
            Frame::Tool => pose.rotation,
            Frame::Fixed(frame) => frame.rotation,
        };
        MovingPose::displaced(&pose, &displacement.at(arm.time_s), |entries| {
            let [x, y, z, rx, ry, rz] = self.axes.scatter(entries);
            [axes * Vector3::new(x, y, z), axes * Vector3::new(rx, ry, rz)]
        })
    }
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
