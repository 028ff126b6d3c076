//! Joint limits as a box of joint velocities that is never empty.
//!
//! # The box
//!
//! For a joint with positions q_lo … q_hi, speed limit V, acceleration limit A, period T, last command q̇⁻ and
//! distance d = q_hi − q ≥ 0 to the upper limit:
//!
//! q̇ ≤ min( V, A(−T + √(T² + 2d/A)), q̇⁻ + A T ), and the mirror image below.
//!
//! The middle term solves v T + v²/2A = d: the joint may move one period at v and can still stop at A before q_hi.
//!
//! # Why it is never empty
//!
//! Let the last command obey its own box: q̇⁻ T + q̇⁻²/2A ≤ d⁻, and the joint track it: d = d⁻ − q̇⁻ T.
//! Then v = max(0, q̇⁻ − A T), the gentlest slowing down, obeys the braking term: for q̇⁻ ≤ A T it is v = 0; otherwise
//! v T + v²/2A = (q̇⁻ − A T) T + (q̇⁻² − 2 q̇⁻ A T + A²T²)/2A = q̇⁻²/2A − A T²/2 ≤ d⁻ − q̇⁻ T = d.
//! So q̇⁻ − A T never exceeds the upper braking term, nor, mirrored, q̇⁻ + A T fall below the lower one: velocity,
//! acceleration and position limits hold together for ever after a start inside.
//!
//! # Outside
//!
//! A measured state may lie outside. Beyond a position limit the box demands the way back, at no more than V and A.
//! Where the acceleration limit contradicts the others, as after a jump of the measured state, position and velocity win
//! and the joint is reported as in conflict.

//!
//! # Beside the box
//!
//! Inequalities a·q̇ ≤ b, given or made from a virtual wall at each posture, count like joint limits in the QP cascade.
//! Where they contradict the box or each other, the box holds, they are broken as little as possible, and the answer
//! names them.

mod barrier;
mod inequality;
mod plane;
mod velocity_box;

pub use barrier::Barrier;
pub use inequality::{Inequality, InequalityError};
pub use plane::{APPROACH_RATE, PlanePoint, VirtualPlane, VirtualPlaneError};
pub use velocity_box::{LimitKind, LimitedBox, VelocityBox, VelocityBoxError, robot_box};
