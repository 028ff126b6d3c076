//! Laws.

use serde::de::{Error, MapAccess};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::ToSchema;

use super::string_or_map::{self, StringOrMap};
use super::{PerAxis, Profile, TargetPose};
use super::{object, words};

/// How a task's velocity is made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Law {
    /// ẋ as given.
    Velocity {
        /// ẋ, m/s and rad/s.
        #[serde(deserialize_with = "object::deserialize")]
        target_velocity: Profile,
    },
    /// Go to a pose: ẋ = ẋ_d + K (x_d − x).
    Pose {
        /// K, 1/s.
        gain: PerAxis<f64>,
        /// X_d.
        #[serde(default)]
        target_pose: TargetPose,
        /// Added to X_d, m and rad (rotation vector).
        #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
        target_displacement: Option<Profile>,
    },
    /// Lead joints: q̇ = q̇_d + K (q_d − q), or −K ∇H towards the middle of their ranges.
    Posture {
        /// Names of the joints; if left out all, towards `mid_range` all that have a range.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        joints: Option<Vec<String>>,
        /// K, one for all or one per joint, 1/s; towards `mid_range` rad²/s or m²/s.
        gain: PerAxis<f64>,
        /// q_d.
        target_position: PostureTarget,
    },
    /// Follow a force.
    Force {
        /// M_d, kg and kg·m².
        inertia: PerAxis<f64>,
        /// B_d, N·s/m and N·m·s/rad.
        damping: PerAxis<f64>,
        /// F_d, N and N·m.
        #[serde(deserialize_with = "object::deserialize")]
        target_force: Profile,
    },
    /// Behave as mass, damper and spring about a pose.
    Impedance {
        /// M_d, kg and kg·m².
        inertia: PerAxis<f64>,
        /// B_d, N·s/m and N·m·s/rad.
        damping: PerAxis<f64>,
        /// K_d, N/m and N·m/rad.
        stiffness: PerAxis<f64>,
        /// X_d.
        #[serde(default)]
        target_pose: TargetPose,
        /// Added to X_d, m and rad (rotation vector).
        #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
        target_displacement: Option<Profile>,
    },
    /// Some axes follow a force, the others a pose.
    Hybrid {
        /// M_d, kg and kg·m².
        inertia: PerAxis<f64>,
        /// B_d, N·s/m and N·m·s/rad.
        damping: PerAxis<f64>,
        /// K_d, N/m and N·m/rad; counts on position-controlled axes.
        stiffness: PerAxis<f64>,
        /// S: true = position-controlled, false = force-controlled.
        position_controlled: PerAxis<bool>,
        /// F_d, N and N·m; counts on force-controlled axes.
        #[serde(deserialize_with = "object::deserialize")]
        target_force: Profile,
        /// X_d.
        #[serde(default)]
        target_pose: TargetPose,
        /// Added to X_d, m and rad (rotation vector).
        #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
        target_displacement: Option<Profile>,
    },
}

/// Where a posture leads its joints.
#[derive(Debug, Clone, PartialEq)]
pub enum PostureTarget {
    /// `"mid_range"`: to the middle of their ranges.
    MidRange,
    /// To positions, one per joint, rad or m.
    Profile(Profile),
}

impl Serialize for PostureTarget {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::MidRange => serializer.serialize_str("mid_range"),
            Self::Profile(profile) => profile.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for PostureTarget {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        string_or_map::deserialize(deserializer)
    }
}

impl StringOrMap for PostureTarget {
    const EXPECTED: &'static str = "`mid_range` or a profile of joint positions";

    fn from_string<E: Error>(text: &str) -> Result<Self, E> {
        match text {
            "mid_range" => Ok(Self::MidRange),
            _ => Err(E::unknown_variant(text, &["mid_range"])),
        }
    }

    fn from_map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        words::from_map(map).map(Self::Profile)
    }
}
