//! The box shrinks towards full braking until the stop of the answer is free, and that of a watchdog too.

use super::hold::Holding;
use crate::collision::{CollisionGuard, Moment};
use crate::limits::{Hold, LimitedBox};
use crate::resolution::{ActiveSet, Problem, ProblemError, Resolution, Solve};
use crate::task::TaskStack;

/// Shares of the box that are tried one after the other.
const SHARES: [f64; 4] = [0.25, 0.0625, 0.015_625, 0.0];

/// Solves again in smaller boxes until the guard allows the answer, and a watchdog can brake after the time that the command may be held.
/// Returns whether the answer is allowed as it is; if not, the answer lies in `shrunk`, part of `limits`.
pub(super) fn keep_clear(
    (guard, moment): (&mut CollisionGuard, Moment),
    (limits, shrunk): (&LimitedBox, &mut LimitedBox),
    (problem, solver, resolution): (&mut Problem, &mut dyn Solve, &mut Resolution),
    (guess, mut holding, hold): (&[ActiveSet], Holding, &mut Hold),
) -> Result<bool, ProblemError> {
    let mut can_be_held = |guard: &mut CollisionGuard, command: &[f64], tasks: &TaskStack| {
        holding.update(hold, command, tasks);
        // A shorter hold leads another way, so the guard checks the time that the answer tells.
        let longest = hold.valid_for_ms(holding.config.valid_for_ms) as f64 * 1e-3;
        let (is_free, time) = guard.hold(moment, command, longest);
        hold.shorten(time, holding.config.period_s);
        is_free
    };
    let command = resolution.joint_velocity.as_slice();
    if guard.allows(moment, command) && can_be_held(guard, command, &problem.tasks) {
        return Ok(true);
    }
    for share in SHARES {
        shrunk.copy_from(limits);
        shrunk.shrink(guard.braking(), share);
        problem.limits.copy_from(&shrunk.velocity_box);
        solver.solve(problem, guess, resolution)?;
        guard.set_share(share);
        let (command, is_last) = (resolution.joint_velocity.as_slice(), share == 0.0);
        let is_allowed = guard.allows(moment, command) || is_last;
        if is_allowed && can_be_held(guard, command, &problem.tasks) {
            break;
        }
        if is_last {
            // Joints that keep their jerk limits brake otherwise than a watchdog.
            guard.set_violated();
        }
    }
    Ok(false)
}
