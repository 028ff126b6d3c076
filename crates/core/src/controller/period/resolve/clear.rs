//! The box shrinks towards full braking until the stop of the answer is free, and that of a watchdog too.

use crate::collision::{CollisionGuard, Moment};
use crate::limits::LimitedBox;
use crate::resolution::{ActiveSet, Problem, ProblemError, Resolution, Solve};

/// Shares of the box that are tried one after the other.
const SHARES: [f64; 4] = [0.25, 0.0625, 0.015_625, 0.0];

/// Solves again in smaller boxes until the guard allows the answer, and a watchdog can brake some time after it, at most `longest` (s).
/// Returns whether the answer is allowed as it is; if not, the answer lies in `shrunk`, part of `limits`.
pub(super) fn keep_clear(
    (guard, moment): (&mut CollisionGuard, Moment),
    (limits, shrunk): (&LimitedBox, &mut LimitedBox),
    (problem, solver, resolution): (&mut Problem, &mut dyn Solve, &mut Resolution),
    (guess, longest): (&[ActiveSet], f64),
) -> Result<bool, ProblemError> {
    let command = resolution.joint_velocity.as_slice();
    if guard.allows(moment, command) && guard.update_hold(moment, command, longest) {
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
        if is_allowed && guard.update_hold(moment, command, longest) {
            break;
        }
    }
    Ok(false)
}
