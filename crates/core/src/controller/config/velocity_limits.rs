//! Which limits bound the joint velocities.

use revprio_robot::RobotModel;

use crate::limits::{JointMotion, LimitKind, LimitedBox, VelocityBox, robot_box};

/// The limits of the joint velocities.
#[derive(Debug, Clone, PartialEq)]
pub enum Limits {
    /// The robot's own limits at the measured state.
    Robot(LimitKind),
    /// A box that does not depend on the state, n, rad/s.
    Fixed(VelocityBox),
}

impl Limits {
    /// Returns whether the speed limits of the robot are among them.
    pub fn include_speeds(&self) -> bool {
        matches!(self, Self::Robot(kind) if *kind != LimitKind::None)
    }

    /// Returns whether the acceleration limits of the robot are among them.
    pub fn include_accelerations(&self) -> bool {
        matches!(self, Self::Robot(kind) if kind.includes_acceleration())
    }

    /// Returns the allowed velocities at a state; `period`: T, s.
    pub fn at(&self, robot: &RobotModel, motion: JointMotion, period: f64) -> LimitedBox {
        match self {
            Self::Robot(kind) => robot_box(robot, *kind, motion, period),
            Self::Fixed(velocity_box) => LimitedBox::given(velocity_box.clone()),
        }
    }
}
