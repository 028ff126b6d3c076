//! A method as a list of hierarchical problems, solved in order; each one starts from the answer q̇' of the one before.
//!
//! | method | problems |
//! |---|---|
//! | `strict_reverse_priority`, `task_priority` | one: the tasks as levels, with limits |
//! | `reverse_priority` | stages k = l … 1: task k, then the lower tasks at what q̇' achieved; limits at stage 1 |
//! | `singularity_robust` | the same stages without the second level |
//! | `pseudoinverse`, `damped_least_squares` | one: all rows as one level, with limits |

use revprio_problem::Method;

/// One problem of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// All rows are one level.
    OneLevel,
    /// Each task is a level, highest priority first.
    Levels,
    /// Task k, above the lower tasks.
    Stage {
        /// k, from 0.
        task: usize,
        /// Whether lower tasks are a level of their own.
        keeps_lower_tasks: bool,
    },
}

impl Step {
    /// Returns the problems of a method for this many tasks, in the order of solution.
    pub fn of(method: Method, tasks: usize) -> Vec<Self> {
        let stages = |keeps_lower_tasks| (0..tasks).rev().map(|task| Self::Stage { task, keeps_lower_tasks }).collect();
        match method {
            Method::Pseudoinverse | Method::DampedLeastSquares => vec![Self::OneLevel],
            Method::TaskPriority | Method::StrictReversePriority => vec![Self::Levels],
            Method::SingularityRobust => stages(false),
            Method::ReversePriority => stages(true),
        }
    }

    /// Returns whether limits apply: they belong to the last problem of a plan.
    pub fn is_last(self) -> bool {
        !matches!(self, Self::Stage { task: 1.., .. })
    }
}
