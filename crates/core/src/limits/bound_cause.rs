//! Which limit sets a bound of the box.

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
