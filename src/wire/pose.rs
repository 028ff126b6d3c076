//! Poses.

use serde::de::{Error, MapAccess, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::object;
use super::string_or_map::{self, StringOrMap};

/// A unit quaternion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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

/// A pose of the tool in the base frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// x, y, z, m.
    pub position: [f64; 3],
    /// Orientation.
    #[serde(deserialize_with = "object::deserialize")]
    pub orientation: Orientation,
}

/// The pose that displacements are counted from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum TargetPose {
    /// `"initial"`: where the tool was at the first step.
    #[default]
    Initial,
    /// A pose in the base frame.
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
