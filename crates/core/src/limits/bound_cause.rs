//! Which limit sets a bound of the box.

use revprio_robot::JointLimits;

/// The limit that sets a bound of a joint velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoundCause {
    /// No limit: the bound is infinite.
    #[default]
    Unlimited,
    /// A given box, which does not depend on the state.
    Given,
    /// The speed limit.
    Velocity,
    /// The position limit: the joint must be able to stop before it, or must move back to it.
    Position,
    /// The velocity limit near an end of the range, of a joint with a velocity envelope; in its place the position limit too.
    Envelope,
    /// The acceleration limit, after the last command.
    Acceleration,
    /// The jerk limit, after the last command and its acceleration.
    Jerk,
    /// The jerk limit of a joint that levels off at the velocity that its tasks want.
    LevellingOff,
    /// Distances: the stop after another command would come too near.
    Distance,
    /// The acceleration limit in the transition from another controller.
    Transition,
}

impl BoundCause {
    /// Returns what limits the speed of a joint that must be able to stop.
    pub(super) fn of_stop(limits: &JointLimits) -> Self {
        if limits.envelope.is_finite() { Self::Envelope } else { Self::Position }
    }
}
