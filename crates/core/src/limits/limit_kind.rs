//! Which limits of a robot apply.

use revprio_problem::VelocityBox;
use revprio_robot::RobotModel;

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

/// Restricts a box to velocities that the robot reaches from the last command (n) within a period (T, s). Where there is
/// none, it becomes the reachable velocity nearest to the box.
pub fn bound_changes(velocity_box: &mut VelocityBox, robot: &RobotModel, last_command: &[f64], period: f64) {
    for (i, (joint, last)) in robot.joints().iter().zip(last_command).enumerate() {
        let max_change = joint.limits.acceleration * period;
        let reachable = |bound: f64| bound.clamp(last - max_change, last + max_change);
        velocity_box.set_joint(i, reachable(velocity_box.lower()[i]), reachable(velocity_box.upper()[i]));
    }
}
