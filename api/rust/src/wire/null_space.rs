//! What the joints do where the tasks leave them free.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{JointVector, object};

/// ζ̇ as such, or what makes it from the posture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(
    untagged,
    expecting = "expected joint velocities, as a list or by joint name, or `kind` `joint_limits` with `gain`, or `kind` \
                 `posture` with `joint_position` and `gain`"
)]
pub enum NullSpaceVelocity {
    /// Made from the posture.
    Motion(#[serde(deserialize_with = "object::deserialize")] NullSpaceMotion),
    /// ζ̇, rad/s or m/s.
    Constant(JointVector),
}

/// A velocity that depends on the posture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum NullSpaceMotion {
    /// −k ∇H, away from the ends of the joints' ranges.
    JointLimits {
        /// k, rad²/s or m²/s.
        gain: f64,
    },
    /// K (q_d − q), towards a posture.
    Posture {
        /// q_d, rad or m.
        joint_position: JointVector,
        /// K, 1/s.
        gain: f64,
    },
}
