//! Poses, target poses and frames.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::object;
use super::string_or_map::string_or_object;

/// An orientation as a unit quaternion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Orientation {
    /// Scalar part.
    pub w: f64,
    /// x of the vector part.
    pub x: f64,
    /// y of the vector part.
    pub y: f64,
    /// z of the vector part.
    pub z: f64,
}

/// A pose in the frame that the description of its field names.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Position x, y, z, m.
    pub position: [f64; 3],
    /// Orientation, unit quaternion.
    #[serde(deserialize_with = "object::deserialize")]
    pub orientation: Orientation,
}

/// The target pose, from which displacements are measured.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum TargetPose {
    /// `"initial"`: the pose at the first step.
    #[default]
    Initial,
    /// A pose of the reference point, in the task's frame if that is a pose, otherwise in the base frame.
    Fixed(Pose),
}

string_or_object! {
    TargetPose { Initial = "initial" } or Fixed(Pose),
    expected "`initial` or an object with `position` and `orientation`",
    "Target pose, from which displacements are measured: `initial` (the pose at the first step), or a pose of the \
     reference point (m, unit quaternion), in the task's `frame` if that is a pose, otherwise in the base frame."
}

/// The axes of a task.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Frame {
    /// `"base"`: the axes of the base.
    #[default]
    Base,
    /// `"tool"`: the axes of the tool, which turn with it.
    Tool,
    /// The axes of a frame with this pose in the base; target poses are given in that frame.
    Fixed(Pose),
}

string_or_object! {
    Frame { Base = "base", Tool = "tool" } or Fixed(Pose),
    expected "`base`, `tool` or an object with `position` and `orientation`",
    "Axes of a task: of the base, of the tool, or of a frame with this pose in the base (m, unit quaternion). In the \
     last case, target poses are given in that frame."
}
