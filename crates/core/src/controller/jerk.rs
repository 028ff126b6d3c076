//! Joints with a jerk limit: their memory, and the velocity that they approach.
//!
//! A limit of the jerk alone lets a joint pass the velocity that its tasks want: when it arrives there with the acceleration
//! a, it goes on by a²/2J, returns as fast, and swings for ever. So a period is solved twice. The first solution, without
//! limits of acceleration and jerk, is the velocity that the tasks want. The box of the second one then lets each joint only
//! arrive there with the acceleration of that velocity; see [`LimitedBox::approach`]. When the first solution already lies
//! in this box, it is the answer, and nothing is solved again.
//!
//! Planes and other inequalities go before such an arrival: if the second solution violates one, the box of all limits is
//! solved as it is.

use revprio_robot::RobotModel;

use super::{ControllerConfig, Memory};
use crate::limits::{JerkLimit, JointMotion, LimitKind, LimitedBox, VelocityBox};
use crate::linalg::Vector;
use crate::resolution::{Problem, ProblemError, Resolution, Solve};

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
    pub(super) fn moving(velocity: &Vector) -> Self {
        Self { acceleration: Vector::zeros(velocity.len()), requested: velocity.clone() }
    }

    /// Advances by a command (n) after the command `last` (n); `period`: T, s.
    fn advance(&mut self, robot: &RobotModel, last: &Vector, command: &Vector, requested: &Vector, period: f64) {
        for (i, joint) in robot.joints().iter().enumerate() {
            let jerk = JerkLimit::of(&joint.limits, period);
            self.acceleration[i] =
                jerk.map_or(0.0, |jerk| jerk.next_acceleration(self.acceleration[i], last[i], command[i]));
        }
        self.requested.copy_from(requested);
    }
}

impl ControllerConfig {
    /// Returns whether the commands keep the jerk limit of a joint, beyond what its acceleration limit implies.
    pub fn keeps_jerk(&self) -> bool {
        let binds = |joint: &revprio_robot::Joint| JerkLimit::of(&joint.limits, self.period_s).is_some();
        self.kept_limits().is_some_and(LimitKind::includes_acceleration) && self.robot.joints().iter().any(binds)
    }
}

/// The workspace of a controller that keeps jerk limits.
pub(super) struct Approach {
    /// The limits without those of acceleration and jerk.
    wide: LimitedBox,
    /// All limits.
    all: VelocityBox,
    /// The velocity that the tasks want, n.
    requested: Vector,
}

impl Approach {
    /// Returns the workspace of a controller; `None` if it keeps no jerk limit.
    pub fn new(config: &ControllerConfig) -> Option<Self> {
        let n = config.robot.joint_count();
        config.keeps_jerk().then(|| Self {
            wide: LimitedBox::unbounded(n),
            all: VelocityBox::unbounded(n),
            requested: Vector::zeros(n),
        })
    }

    /// Solves a period. `limited`: the box of all limits, which is narrowed.
    pub fn resolve(
        &mut self,
        config: &ControllerConfig,
        (problem, solver): (&mut Problem, &mut dyn Solve),
        limited: &mut LimitedBox,
        motion: JointMotion,
        previous: &Memory,
        resolution: &mut Resolution,
    ) -> Result<(), ProblemError> {
        self.all.copy_from(&limited.velocity_box);
        self.wide.update(&config.robot, LimitKind::PositionVelocity, motion, config.period_s);
        problem.limits.copy_from(&self.wide.velocity_box);
        solver.solve(problem, &previous.active_set, resolution)?;
        self.requested.copy_from(&resolution.joint_velocity);
        let last = previous.jerk.as_ref().map_or(&previous.last_command, |jerk| &jerk.requested);
        limited.approach(&config.robot, motion, self.requested.as_slice(), last.as_slice(), config.period_s);
        problem.limits.copy_from(&limited.velocity_box);
        if problem.limits.allows(self.requested.as_slice()) {
            return Ok(());
        }
        solver.solve(problem, &previous.active_set, resolution)?;
        if resolution.broken_constraints().next().is_some() {
            problem.limits.copy_from(&self.all);
            solver.solve(problem, &previous.active_set, resolution)?;
        }
        Ok(())
    }

    /// Updates the memory after a command; its last command is still that before it.
    pub fn update_memory(&self, memory: &mut Memory, config: &ControllerConfig, command: &Vector) {
        let Memory { jerk, last_command, .. } = memory;
        let state = jerk.get_or_insert_with(|| JerkState::moving(last_command));
        state.advance(&config.robot, last_command, command, &self.requested, config.period_s);
    }
}
