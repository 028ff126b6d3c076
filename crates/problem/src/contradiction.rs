//! Demands that contradict each other.

use crate::Bound;

/// A minimal set of demands that contradict each other: without any one of them the rest can be kept together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contradiction {
    /// The task whose inequality rows cannot all be kept, index from 0; `None` for the hard inequalities before all tasks.
    pub task: Option<usize>,
    /// The demands. An equation stands for the value that it achieves.
    pub members: Vec<Bound>,
}
