//! The box shrinks towards full braking until the stop of the answer is free.

use crate::collision::{CollisionGuard, Moment};
use crate::limits::LimitedBox;
use crate::resolution::{ActiveSet, Problem, ProblemError, Resolution, Solve};

/// Shares of the box that are tried one after the other.
const SHARES: [f64; 4] = [0.25, 0.0625, 0.015_625, 0.0];

/// Solves again in smaller boxes until the guard allows the answer. Returns whether it allows the answer as it is; if not, the answer
/// lies in `shrunk`, part of `limits`.
pub(super) fn keep_clear(
    (guard, moment): (&mut CollisionGuard, Moment),
    (limits, shrunk): (&LimitedBox, &mut LimitedBox),
    (problem, solver, resolution): (&mut Problem, &mut dyn Solve, &mut Resolution),
    guess: &[ActiveSet],
) -> Result<bool, ProblemError> {
    if guard.allows(moment, resolution.joint_velocity.as_slice()) {
        return Ok(true);
    }
    for share in SHARES {
        shrunk.copy_from(limits);
        shrunk.shrink(guard.braking(), share);
        problem.limits.copy_from(&shrunk.velocity_box);
        solver.solve(problem, guess, resolution)?;
        guard.set_share(share);
        if guard.allows(moment, resolution.joint_velocity.as_slice()) {
            break;
        }
    }
    Ok(false)
}
