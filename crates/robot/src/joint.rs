//! One joint and its limits.

use nalgebra::IsometryMatrix3;

use super::{DenavitHartenberg, JointKind, VelocityEnvelope};

/// Position, velocity, acceleration and jerk limits of one joint; infinite where there is none.
///
/// Units: rad, rad/s, rad/s², rad/s³ for a revolute joint; m, m/s, m/s², m/s³ for a prismatic one.
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
    /// J, the largest change of the acceleration in a second, in either direction.
    pub jerk: f64,
    /// Limit of the speed that shrinks towards the ends of the range.
    pub envelope: VelocityEnvelope,
}

impl JointLimits {
    /// No limits.
    pub const NONE: Self = Self {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity: f64::INFINITY,
        acceleration: f64::INFINITY,
        jerk: f64::INFINITY,
        envelope: VelocityEnvelope::NONE,
    };

    /// Returns whether the position range is not empty, speed, acceleration and jerk are positive, and the envelope is valid.
    pub(crate) fn is_valid(&self) -> bool {
        let is_positive = self.velocity > 0.0 && self.acceleration > 0.0 && self.jerk > 0.0;
        self.lower <= self.upper && is_positive && self.envelope.is_valid() && self.leaves_a_range()
    }

    /// Returns the positions at which the joint may come to rest: q_lo … q_hi, without the margins of its envelope.
    pub fn resting_range(&self) -> [f64; 2] {
        let margin = self.envelope.margin();
        [self.lower + margin, self.upper - margin]
    }

    /// Returns whether the envelope leaves the joint a place to rest.
    pub(crate) fn leaves_a_range(&self) -> bool {
        let [lower, upper] = self.resting_range();
        lower <= upper
    }

    /// Returns limits with which a joint at `multiplier` q + `offset` keeps `follower` too.
    ///
    /// The position range may become empty.
    pub(crate) fn restricted_by(&self, follower: &Self, multiplier: f64, offset: f64) -> Self {
        if multiplier == 0.0 {
            return *self;
        }
        let [mut lower, mut upper] = [follower.lower, follower.upper].map(|position| (position - offset) / multiplier);
        if multiplier < 0.0 {
            (lower, upper) = (upper, lower);
        }
        let ratio = multiplier.abs();
        Self {
            lower: self.lower.max(lower),
            upper: self.upper.min(upper),
            velocity: self.velocity.min(follower.velocity / ratio),
            acceleration: self.acceleration.min(follower.acceleration / ratio),
            jerk: self.jerk.min(follower.jerk / ratio),
            envelope: self.envelope.restricted_by(&follower.envelope, ratio),
        }
    }
}

/// A joint with a coordinate of its own: one entry of the joint position.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, unique in the robot.
    pub name: String,
    /// Kind of motion.
    pub kind: JointKind,
    /// Pose of the joint's frame at position zero, m, in the frame that the joint before it in the tree moves; in the base
    /// if there is none.
    pub placement: IsometryMatrix3<f64>,
    /// Limits of the real arm.
    pub limits: JointLimits,
    /// Position range (lower, upper) in a publication, if it differs from `limits`. For information only.
    pub published_range: Option<[f64; 2]>,
    /// Denavit-Hartenberg row, if the joint was described by one. For information only: `placement` contains it.
    pub denavit_hartenberg: Option<DenavitHartenberg>,
}
