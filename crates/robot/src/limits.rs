//! What a joint may do.

use super::ModelError;

/// Position, velocity and acceleration limits of one joint; infinite where there is none.
///
/// Units: rad, rad/s, rad/s² for a revolute joint, m, m/s, m/s² for a prismatic one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimits {
    /// q_lo, the smallest position.
    pub lower: f64,
    /// q_hi, the largest position.
    pub upper: f64,
    /// V, the largest speed in either direction.
    pub velocity: f64,
    /// A, the largest acceleration in either direction.
    pub acceleration: f64,
}

impl JointLimits {
    /// No limit at all.
    pub const NONE: Self =
        Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY, velocity: f64::INFINITY, acceleration: f64::INFINITY };

    /// Refuses an empty range, and speeds or accelerations that are not positive.
    pub(super) fn validated(self, joint: &str) -> Result<Self, ModelError> {
        let valid = self.lower <= self.upper && self.velocity > 0.0 && self.acceleration > 0.0;
        if valid { Ok(self) } else { Err(ModelError::Limits { joint: joint.to_owned() }) }
    }
}
