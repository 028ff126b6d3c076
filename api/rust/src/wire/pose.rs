//! Poses, target poses and frames.

use serde::de::{Error, MapAccess, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::ToSchema;

use super::object;
use super::string_or_map::{self, StringOrMap};

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

impl Serialize for TargetPose {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Initial => serializer.serialize_str("initial"),
            Self::Fixed(pose) => pose.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for TargetPose {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        string_or_map::deserialize(deserializer)
    }
}

impl StringOrMap for TargetPose {
    const EXPECTED: &'static str = "`initial` or an object with `position` and `orientation`";

    fn from_string<E: Error>(text: &str) -> Result<Self, E> {
        match text {
            "initial" => Ok(Self::Initial),
            _ => Err(E::unknown_variant(text, &["initial"])),
        }
    }

    fn from_map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        Pose::deserialize(MapAccessDeserializer::new(map)).map(Self::Fixed)
    }
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

impl Serialize for Frame {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Base => serializer.serialize_str("base"),
            Self::Tool => serializer.serialize_str("tool"),
            Self::Fixed(pose) => pose.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Frame {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        string_or_map::deserialize(deserializer)
    }
}

impl StringOrMap for Frame {
    const EXPECTED: &'static str = "`base`, `tool` or an object with `position` and `orientation`";

    fn from_string<E: Error>(text: &str) -> Result<Self, E> {
        match text {
            "base" => Ok(Self::Base),
            "tool" => Ok(Self::Tool),
            _ => Err(E::unknown_variant(text, &["base", "tool"])),
        }
    }

    fn from_map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        Pose::deserialize(MapAccessDeserializer::new(map)).map(Self::Fixed)
    }
}
