//! How the joints move before a command, and where it leads them.

use revprio_robot::JointLimits;
use revprio_robot::kinematics::Configuration;

/// The motion of the joints before a command.
#[derive(Debug, Clone, Copy)]
pub struct JointMotion<'a> {
    /// q, measured position, n.
    pub position: &'a [f64],
    /// p − q, how far the joints move on if all later commands are zero, n; empty: they stop at once. See
    /// [`DriveState`](crate::limits::DriveState).
    pub distance_to_rest: &'a [f64],
    /// q̇⁻, the last command, n.
    pub last_command: &'a [f64],
    /// a⁻, the acceleration of the last command, n; empty: jerk limits do not apply.
    pub last_acceleration: &'a [f64],
}

impl JointMotion<'_> {
    /// Returns the same motion with joints that stop at once.
    pub(crate) fn stopping_at_once(self) -> Self {
        Self { distance_to_rest: &[], ..self }
    }

    /// Returns the distances of a joint to its lower and to its upper limit, as it is now and as it comes to rest,
    /// whichever is smaller. A joint with a velocity envelope comes to rest at its margin, so the limit is nearer by it.
    pub(crate) fn distances(&self, joint: usize, limits: &JointLimits) -> (f64, f64) {
        let (q, to_rest) = (self.position[joint], self.distance_to_rest.get(joint).copied().unwrap_or(0.0));
        let margin = limits.envelope.margin();
        (q - limits.lower - margin + to_rest.min(0.0), limits.upper - q - margin - to_rest.max(0.0))
    }
}

/// Where the next command moves the arm: from its position of rest p to p + T u, see [`DriveState`](crate::limits::DriveState).
#[derive(Debug, Clone, Copy)]
pub struct Ahead<'a> {
    /// The arm at p, where the Jacobians of the tasks are taken.
    pub rest: &'a Configuration,
    /// The arm at m = p + ½ T q̇⁻, half of the way if the last command continues.
    pub half_way: &'a Configuration,
    /// q̇⁻, the last command, n, rad/s or m/s.
    pub last_command: &'a [f64],
}

/// How the joints brake before a plane.
#[derive(Debug, Clone, Copy)]
pub struct JointBraking<'a> {
    /// a_j, n, rad/s² or m/s²; infinite for a joint without limit.
    pub deceleration: &'a [f64],
    /// τ, time for which the point may move on before it brakes, s.
    pub reaction_s: f64,
}
