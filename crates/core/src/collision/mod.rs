//! Keeping clear of obstacles and of the robot's own links.
//!
//! # What is kept
//!
//! The *stop* after a command u is what the arm does if u acts for one period T and full braking follows: each joint lowers its
//! speed as fast as its limits of acceleration and jerk allow. A stop is *free* if no watched pair of shapes comes nearer than d_min on its whole way,
//! behind the lag and the dead time of the drive. A command is sent only if its stop is free, or if the stop is for no pair nearer than that
//! of full braking.
//!
//! # Why the distance is kept
//!
//! Let the world stand still, let the drive be as stated, and let the stop after the last command be free. Full braking now is the rest of
//! that stop, so its own stop is free. Hence there is always a command whose stop is free, and one of them is sent. By
//! induction every posture lies on a free stop. That holds for any number of pairs, and for any answer of the solver: the stop is checked
//! and not assumed. `docs/collisions.md` in the repository has the
//! bound of the distance between the samples.
//!
//! # How the solver finds such commands
//!
//! Linear rows tell the solver how its command changes the distances along the stop; see `rows`. They are first-order. If
//! the stop of the answer is not free all the same, the box of the velocities is shrunk towards full braking, and the problem is solved again. Shrunk to a
//! point, it is full braking.

mod avoidance;
mod clearance;
mod guard;
mod obstacle;
mod pair;
mod report;
mod rows;
mod stop;

pub use self::avoidance::{CollisionAvoidance, CollisionAvoidanceError, MAX_OBSTACLES, ROWS};
pub(crate) use self::guard::{CollisionGuard, Moment};
pub use self::obstacle::{Obstacle, ObstacleError, ObstacleShape, ObstacleState};
pub use self::report::{CollisionReport, PairReport};
pub(crate) use self::rows::NAME;
