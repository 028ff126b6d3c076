//! The state that a command answers.

use crate::linalg::Vector;

/// The state that the last command answers, and how long the command may be held.
#[derive(Debug, Clone, PartialEq)]
pub struct AnsweredState {
    /// t, time of the state, s.
    pub time_s: f64,
    /// q of the state, n, rad or m.
    pub joint_position: Vector,
    /// How far the joints move behind the modelled drive in the period after the state, n, rad or m; `None`: unknown.
    pub way: Option<Vector>,
    /// Time from the state on for which the command may be held, ms.
    pub valid_for_ms: u64,
    /// Time in which a watchdog brings all joints to rest together after that, s; `None`: each brakes at its own deceleration.
    pub stop_time_s: Option<f64>,
}
