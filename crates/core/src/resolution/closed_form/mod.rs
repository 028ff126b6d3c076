//! Pseudo-inverse formulas; limits are unknown here.

mod least_squares;
mod reverse_priority;
mod strict;

pub use least_squares::least_squares;
pub use reverse_priority::reverse_priority;
pub use strict::Descent;

use crate::linalg::TaskVector;

/// A joint velocity and its distance from the optimality conditions of the problem it solves.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedForm {
    /// q̇, n, rad/s.
    pub joint_velocity: TaskVector,
    /// Largest relative stationarity residual of all levels.
    pub kkt_residual: f64,
}
