//! Which limits of a robot apply.

/// The limits of a robot that apply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// No limits: an unbounded box.
    None,
    /// The speed limit.
    Velocity,
    /// The speed limit and the position limits: the joint can still stop before a position limit. The change of the velocity
    /// from period to period has no limit.
    PositionVelocity,
    /// All limits: the acceleration limit also bounds the change of the velocity from period to period, and the jerk limit
    /// that of the acceleration.
    PositionVelocityAcceleration,
}

impl LimitKind {
    /// Returns whether the speed limit applies.
    pub fn includes_velocity(self) -> bool {
        self != Self::None
    }

    /// Returns whether the position limits apply.
    pub fn includes_position(self) -> bool {
        matches!(self, Self::PositionVelocity | Self::PositionVelocityAcceleration)
    }

    /// Returns whether the acceleration limit applies.
    pub fn includes_acceleration(self) -> bool {
        self == Self::PositionVelocityAcceleration
    }
}
