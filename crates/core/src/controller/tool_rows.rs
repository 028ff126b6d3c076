//! Tasks about directions of the tool, and the pose that they are to reach.

use nalgebra::{IsometryMatrix3, Rotation3, Vector3};
use revprio_robot::kinematics::{AxisSelection, Frame, RotationMotion, TaskFrame, orientation_error};

use super::task::Sensed;
use crate::law::{Profile, SetPoint, TaskState};
use crate::linalg::TaskVector;

/// Directions of the tool, at a point and along axes, and where it is to go.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolRows {
    /// The rows.
    pub axes: AxisSelection,
    /// Where and along which axes they count.
    pub frame: TaskFrame,
    /// X_d.
    pub target_pose: TargetPose,
    /// What is added to it, m rows, m and rad (rotation vector): along the axes of the frame, for those of the tool along
    /// the tool's axes in the target pose.
    pub target_displacement: Option<Profile>,
}

/// The pose that displacements ΔX are counted from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum TargetPose {
    /// Where the tool was at the first step.
    #[default]
    Initial,
    /// A pose of the reference point, parallel to the tool, m: in the stated frame where the task has one, else in the
    /// base.
    Fixed(IsometryMatrix3<f64>),
}

impl ToolRows {
    /// All rows along the base at the tool point, about the pose at the first step.
    pub fn new(axes: AxisSelection) -> Self {
        Self { axes, frame: TaskFrame::default(), target_pose: TargetPose::Initial, target_displacement: None }
    }

    /// The selected entries of a twist or a wrench, m.
    pub(super) fn entries_of(&self, six: &[f64; 6]) -> TaskVector {
        let axes = self.axes.axes();
        TaskVector::from_fn(axes.len(), |row| six[axes[row].index()])
    }

    /// What the law sees; `velocity`: Ẋ, m.
    pub(super) fn state(&self, velocity: TaskVector, sensed: &Sensed) -> TaskState {
        let placed = self.frame.at(sensed.configuration);
        let rows = |[linear, angular]: [Vector3<f64>; 2]| self.entries_of(&placed.components(linear, angular));
        let target = self.target(sensed);
        let actual = self.frame.pose(sensed.configuration.tool_pose());
        let displacement = [
            actual.translation.vector - target.pose.translation.vector,
            orientation_error(&actual.rotation, &target.pose.rotation),
        ];
        TaskState {
            time_s: sensed.time_s,
            velocity,
            displacement: rows(displacement),
            target_velocity: rows(target.velocity),
            target_acceleration: rows(target.acceleration),
            force: self.entries_of(&placed.wrench(&sensed.wrench)),
        }
    }

    /// X_d with its derivatives.
    fn target(&self, sensed: &Sensed) -> MovingPose {
        let resting = match (self.target_pose, self.frame.frame) {
            (TargetPose::Initial, _) => self.frame.pose(&sensed.initial_pose),
            (TargetPose::Fixed(pose), Frame::Fixed(frame)) => frame * pose,
            (TargetPose::Fixed(pose), Frame::Base | Frame::Tool) => pose,
        };
        let Some(displacement) = &self.target_displacement else { return MovingPose::resting(resting) };
        let axes = match self.frame.frame {
            Frame::Base => Rotation3::identity(),
            Frame::Tool => resting.rotation,
            Frame::Fixed(frame) => frame.rotation,
        };
        MovingPose::displaced(&resting, &displacement.at(sensed.time_s), |entries| {
            let [x, y, z, rx, ry, rz] = self.axes.scatter(entries);
            [axes * Vector3::new(x, y, z), axes * Vector3::new(rx, ry, rz)]
        })
    }
}

/// A pose with its derivatives, linear and angular, base axes.
struct MovingPose {
    pose: IsometryMatrix3<f64>,
    velocity: [Vector3<f64>; 2],
    acceleration: [Vector3<f64>; 2],
}

impl MovingPose {
    fn resting(pose: IsometryMatrix3<f64>) -> Self {
        Self { pose, velocity: [Vector3::zeros(); 2], acceleration: [Vector3::zeros(); 2] }
    }

    /// The pose moved by a displacement, which `vectors` makes linear and angular in base axes.
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
