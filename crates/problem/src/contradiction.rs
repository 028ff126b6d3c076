//! Demands that contradict each other.

use crate::Side;

/// A minimal set of demands that contradict each other: without any one of them the rest can be kept together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contradiction {
    /// The task whose inequality rows cannot all be kept, index from 0; `None` for the hard inequalities before all tasks.
    pub task: Option<usize>,
    /// The demands.
    pub members: Vec<Member>,
}

/// A demand of a contradiction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Member {
    /// A row of a task. An equation of a higher task stands for the value that it achieves.
    Row {
        /// Index of the task, from 0.
        task: usize,
        /// Index of the row, from 0.
        row: usize,
        /// Which bound.
        side: Side,
    },
    /// A joint velocity limit.
    Limit {
        /// Index of the joint, from 0.
        joint: usize,
        /// Which bound.
        side: Side,
    },
    /// A hard inequality.
    Inequality {
        /// Index in the list, from 0.
        index: usize,
        /// Which bound.
        side: Side,
    },
}
