//! What joints with a jerk limit remember.

use revprio_robot::RobotModel;

use crate::limits::JerkLimit;
use crate::linalg::Vector;

/// What joints with a jerk limit remember.
#[derive(Debug, Clone, PartialEq)]
pub struct JerkState {
    /// a⁻, acceleration of the last command, n, rad/s² or m/s²; 0 for joints without jerk limit.
    pub acceleration: Vector,
    /// Velocity that the tasks wanted in the last period, n, rad/s or m/s.
    pub requested: Vector,
}

impl JerkState {
    /// Returns the state of joints that move at a constant velocity (n).
    pub(in crate::controller) fn moving(velocity: &Vector) -> Self {
        Self { acceleration: Vector::zeros(velocity.len()), requested: velocity.clone() }
    }

    /// Advances by a command (n) after the command `last` (n); `requested`: what the tasks wanted, n; `period`: T, s.
    pub(in crate::controller) fn advance(
        &mut self,
        robot: &RobotModel,
        last: &Vector,
        command: &Vector,
        requested: &Vector,
        period: f64,
    ) {
        for (i, joint) in robot.joints().iter().enumerate() {
            let jerk = JerkLimit::of(&joint.limits, period);
            self.acceleration[i] =
                jerk.map_or(0.0, |jerk| jerk.next_acceleration(self.acceleration[i], last[i], command[i]));
        }
        self.requested.copy_from(requested);
    }
}
