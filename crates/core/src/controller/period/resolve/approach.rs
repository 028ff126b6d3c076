//! How joints with a jerk limit approach the velocity that their tasks want.
//!
//! A limit of the jerk alone lets a joint pass the velocity that its tasks want: when it arrives there with the acceleration
//! a, it goes on by a²/2J, returns as fast, and swings for ever. So a period is solved twice. The first solution, without
//! limits of acceleration and jerk, is the velocity that the tasks want. The box of the second one then lets each joint only
//! arrive there with the acceleration of that velocity; see [`LimitedBox::approach`]. When the first solution already lies
//! in this box, it is the answer, and nothing is solved again.
//!
//! Joints that each arrive as fast as they can do not arrive together: on the way they would move what a higher task holds, for the sake of
//! a lower one. So if the second solution loses of a task that is not the lowest what the first one achieves, the period is solved once
//! more, and each joint may also arrive more slowly or go away from its velocity. Where that loses less, it is the answer: the order of the
//! tasks decides which joints wait. It is not used where an inequality acts.
//!
//! Planes and other inequalities go before such an arrival: if the second solution violates one, the box of all limits is
//! solved as it is.

use crate::arm_state::ArmState;
use crate::controller::config::ControllerConfig;
use crate::controller::period::allow::Allowed;
use crate::controller::state::Memory;
use crate::limits::{LimitedBox, Pace};
use crate::linalg::Vector;
use crate::resolution::{Problem, ProblemError, Resolution, Solve};

/// Loss of a task's velocity that counts as rounding, m/s or rad/s.
const LOSS: f64 = 1e-6;

/// The memory of a controller that keeps jerk limits.
#[derive(Debug)]
pub(super) struct Approach {
    /// The box of all limits, narrowed.
    narrowed: LimitedBox,
    /// The velocity that the tasks want, n.
    requested: Vector,
    /// What the tasks miss of their velocities without these limits.
    missed: Vec<f64>,
}

impl Approach {
    /// Allocates the memory of a controller; `None` if it keeps no jerk limit.
    pub fn new(config: &ControllerConfig) -> Option<Self> {
        let n = config.robot.joint_count();
        config.keeps_jerk().then(|| Self {
            narrowed: LimitedBox::unbounded(n),
            requested: Vector::zeros(n),
            missed: Vec::with_capacity(config.tasks.len()),
        })
    }

    /// Solves a period, whose box without limits of acceleration and jerk is `without_jerk`. Returns the box in which the answer
    /// lies, and the velocity that the tasks want, n. `period`: T, s.
    pub fn resolve<'a>(
        &'a mut self,
        (arm, previous, allowed): (&ArmState, &Memory, &'a Allowed),
        without_jerk: &'a LimitedBox,
        (problem, solver, resolution): (&mut Problem, &mut dyn Solve, &mut Resolution),
        period: f64,
    ) -> Result<(&'a LimitedBox, &'a Vector), ProblemError> {
        let Self { narrowed, requested, missed } = self;
        let mut solve = |limits: &LimitedBox, resolution: &mut Resolution| {
            problem.limits.copy_from(&limits.velocity_box);
            solver.solve(problem, &previous.active_set, resolution)
        };
        solve(without_jerk, resolution)?;
        requested.copy_from(&resolution.joint_velocity);
        let last = previous.jerk.as_ref().map_or(&previous.last_command, |jerk| &jerk.requested);
        let narrow = |narrowed: &mut LimitedBox, pace| {
            narrowed.copy_from(&allowed.limits);
            let velocities = (requested.as_slice(), last.as_slice());
            narrowed.approach((&arm.robot, period), arm.motion(), velocities, pace);
        };
        narrow(narrowed, Pace::Fast);
        if narrowed.velocity_box.allows(requested.as_slice()) {
            return Ok((without_jerk, requested));
        }
        missed.clear();
        missed.extend(resolution.tasks.iter().map(|task| task.residual_norm));
        solve(narrowed, resolution)?;
        let lost = loss(resolution, missed);
        if lost > LOSS && resolution.active_constraints().next().is_none() {
            narrow(narrowed, Pace::AtMost);
            solve(narrowed, resolution)?;
            let is_better = loss(resolution, missed) < lost;
            if !is_better || resolution.active_constraints().next().is_some() {
                narrow(narrowed, Pace::Fast);
                solve(narrowed, resolution)?;
            }
        }
        if resolution.broken_constraints().next().is_none() {
            return Ok((narrowed, requested));
        }
        solve(&allowed.limits, resolution)?;
        Ok((&allowed.limits, requested))
    }
}

/// Returns what tasks that are not the lowest miss of their velocities beyond what they `missed`, the largest, m/s or rad/s.
fn loss(resolution: &Resolution, missed: &[f64]) -> f64 {
    let upper = resolution.tasks.len().saturating_sub(1);
    let losses = resolution.tasks.iter().take(upper).zip(missed).map(|(task, missed)| task.residual_norm - missed);
    losses.fold(0.0, f64::max)
}
