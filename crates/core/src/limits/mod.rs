//! Joint limits as a box of allowed joint velocities that is never empty. Each bound of the box names the limit that sets it.
//!
//! # The box
//!
//! A joint has position limits q_lo … q_hi, a speed limit V and an acceleration limit A. T is the period, q̇⁻ the last
//! command and d = q_hi − max(q, p) ≥ 0 the distance to the upper limit, as the joint is now and as it comes to rest behind
//! its drive ([`DriveState`]). The reaction time is τ = T + max(T, 10 ms). Then
//!
//! q̇ ≤ min( V, a(−τ + √(τ² + 2d/a)), q̇⁻ + A T ),
//!
//! and the lower bound is its mirror image. The middle term solves v τ + v²/2a = d: the joint may move for τ at v and can
//! still stop at a before q_hi. Here a is the deceleration of [`braking_deceleration`]: A, or V/0.25 s for a joint without
//! acceleration limit. The limits `PositionVelocity` omit the last term.
//!
//! Because τ is longer than a period, a command can be held for a while when no answer follows; see [`Hold`].
//!
//! # Why the box is never empty
//!
//! Let the last command obey its own box, q̇⁻ τ + q̇⁻²/2A ≤ d⁻, and let the joint follow it: d = d⁻ − q̇⁻ T. Then
//! v = max(0, q̇⁻ − A T), the smallest speed that the acceleration limit allows, obeys the braking term. For q̇⁻ ≤ A T
//! it is v = 0. Otherwise
//!
//! v τ + v²/2A = (q̇⁻ − A T) τ + (q̇⁻² − 2 q̇⁻ A T + A²T²)/2A = q̇⁻ τ + q̇⁻²/2A − q̇⁻ T − A T (τ − T/2) ≤ d⁻ − q̇⁻ T = d.
//!
//! So q̇⁻ − A T never exceeds the upper braking term. By symmetry, q̇⁻ + A T is never below the lower one. If the arm
//! starts inside its limits and follows its commands, then position, velocity and acceleration limits hold at all
//! times.
//!
//! A joint with a jerk limit may change its acceleration by at most J T in a period; see [`JerkLimit`] for its box.
//!
//! Behind a drive the same proof holds for p, which follows the commands exactly. A drive that is faster than stated moves
//! p less regularly. If the braking term then demands more than full braking, full braking is allowed as long as the joint
//! could still stop if it had no drive.
//!
//! Noise of the measured position and lost states can demand more than full braking as well. If full braking from then on ends
//! within δ = 0.5 mrad (0.5 mm) and A T²/8 more distance, it is allowed. Let the error be at most ε ≤ δ/2. Then v τ + v²/2A ≤ max(0, d + ε) after every command,
//! for the true d: the box of the measured distance ensures it, and full braking keeps it, as above. As d + ε is at most
//! the measured distance + 2 ε, full braking is always allowed, and no limits contradict each other.
//!
//! # Velocity limits near the ends
//!
//! A joint with a velocity envelope ([`revprio_robot::VelocityEnvelope`]) must not be faster than √(2 D d) − o towards an end at the
//! distance d. This is v o/D + v²/2D ≤ d − m with m = o²/2D. So such a joint has ends that are nearer by m, the reaction time τ' = τ + o/D
//! and the deceleration b = min(a, D) in the terms above:
//!
//! v τ' + v²/2b ≤ d − m.
//!
//! It implies (v + o)²/2D ≤ d − v τ, so a command keeps the envelope for τ, until after the next one. The box is not empty: with
//! r = A/b ≥ 1 and v = q̇⁻ − A T > 0,
//!
//! v τ' + v²/2b = q̇⁻ τ' + q̇⁻²/2b − r q̇⁻ T − A T (τ' − r T/2) ≤ d⁻ − m − q̇⁻ T,
//!
//! because (r − 1) q̇⁻ T + A T τ' ≥ (r − 1) A T² + A T² ≥ r A T²/2. A watchdog that brakes at a ≥ b keeps the envelope: on its ramp
//! v o/D + v²/2b falls by at least v per second.
//!
//! Behind a drive, position and velocity of the joint are means, with the same weights, of earlier p and of the commands at these
//! times. The pairs of d and v with v ≤ √(2 D d) − o are a convex set. So the joint keeps the envelope as well.
//!
//! # Outside the limits
//!
//! A measured state may lie outside. Beyond a position limit the box demands a motion back, within V and A. If the
//! acceleration limit contradicts the others, for example after a jump of the measured state, then position and
//! velocity limits hold, the acceleration limit does not, and the joint is reported as a conflict.

mod bound_cause;
mod braking;
mod drive;
#[cfg(test)]
mod envelope_tests;
mod full_braking;
mod hold;
mod jerk;
mod limit_kind;
mod limited_box;

pub use bound_cause::BoundCause;
pub use braking::{braking_deceleration, may_jump, ramp_deceleration, reaction_time, spare_time};
pub use drive::{Drive, DriveState, MAX_DRIVE_DELAY};
pub(crate) use full_braking::full_braking;
pub use hold::Hold;
pub use jerk::JerkLimit;
pub use limit_kind::LimitKind;
pub use limited_box::{LimitedBox, Pace, robot_box};
pub use revprio_problem::{VelocityBox, VelocityBoxError};

pub use crate::arm_state::JointMotion;
