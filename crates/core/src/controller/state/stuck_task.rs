//! Tasks that make no progress.

/// What holds a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obstacle {
    /// Limits of joints, or inequalities.
    Limits,
    /// A singular posture: no joint moves the task in the missing direction.
    Singularity,
    /// Tasks of higher priority.
    HigherTasks,
}

/// A task that makes no progress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StuckTask {
    /// Index of the task, from 0.
    pub task: usize,
    /// Time since which it makes no progress, s.
    pub since_s: f64,
    /// What holds it; empty while the arm leaves the posture.
    pub held_by: &'static [Obstacle],
    /// Whether the arm leaves the posture.
    pub leaving: bool,
}
