//! Tasks in their order of priority.

use crate::{Matrix, Vector};

/// One task lower ≤ J_k q̇ ≤ upper. Rows whose bounds are equal are equations J_k q̇ = ẋ_k.
///
/// An inequality task has its own priority level, as every task does: its violation is as small as the higher tasks
/// permit.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Name that answers use.
    pub name: String,
    /// J_k, m_k × n, in m/s or rad/s per unit of joint speed.
    pub jacobian: Matrix,
    /// Lower bound of each row, m_k; m/s for linear rows, rad/s for angular rows; −∞: no lower bound.
    pub lower: Vector,
    /// Upper bound of each row, m_k, in the same units; +∞: no upper bound.
    pub upper: Vector,
    /// How a task of equations gives way to limits. `true`: its velocity keeps its direction, J_k q̇ = s ẋ_k with the
    /// largest s ≤ 1. `false`: its residual is as small as possible, and the direction may change.
    pub scaled: bool,
}

impl Task {
    /// Builds a task of equations J_k q̇ = ẋ_k (`velocity`) that is not scaled: limits may change its direction.
    pub fn new(name: impl Into<String>, jacobian: Matrix, velocity: Vector) -> Self {
        Self::between(name, jacobian, velocity.clone(), velocity)
    }

    /// Builds an inequality task lower ≤ J_k q̇ ≤ upper, with one bound of each kind per row; −∞ and +∞ are no bounds.
    pub fn between(name: impl Into<String>, jacobian: Matrix, lower: Vector, upper: Vector) -> Self {
        Self { name: name.into(), jacobian, lower, upper, scaled: false }
    }

    /// Returns whether all rows are equations.
    pub fn is_equation(&self) -> bool {
        self.lower.as_slice() == self.upper.as_slice()
    }

    /// Returns whether a row is an equation.
    pub fn has_equations(&self) -> bool {
        self.lower.iter().zip(self.upper.iter()).any(|(lower, upper)| lower == upper)
    }

    /// Returns the index of the first row that no finite velocity satisfies, or whose bound is NaN.
    fn empty_row(&self) -> Option<usize> {
        let (lower, upper) = (self.lower.as_slice(), self.upper.as_slice());
        if lower == upper && is_finite(lower) {
            return None;
        }
        // False for NaN.
        let allows =
            |(lower, upper): (&f64, &f64)| lower <= upper && *lower < f64::INFINITY && *upper > f64::NEG_INFINITY;
        lower.iter().zip(upper).position(|row| !allows(row))
    }

    /// Checks the numbers of the task with this index.
    fn check_numbers(&self, task: usize) -> Result<(), TaskError> {
        if !is_finite(self.jacobian.as_slice()) {
            return Err(TaskError::NotFinite { task });
        }
        match self.empty_row() {
            Some(row) => Err(TaskError::Bounds { task, row }),
            None => Ok(()),
        }
    }
}

/// Why a stack is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TaskError {
    /// The list of tasks is empty.
    #[error("give at least one task")]
    NoTasks,
    /// A task has no rows, or not one velocity (or lower and upper bound) per row.
    #[error("{rows} rows, but {velocities} velocities")]
    Rows {
        /// Index of the task, 0 = highest priority.
        task: usize,
        /// m_k.
        rows: usize,
        /// Number of velocities, or of bounds of the side whose number is wrong.
        velocities: usize,
    },
    /// A Jacobian does not have one column per joint.
    #[error("{columns} columns, but the arm has {joints} joints")]
    Columns {
        /// Index of the task, 0 = highest priority.
        task: usize,
        /// Columns of J_k.
        columns: usize,
        /// n.
        joints: usize,
    },
    /// An entry of a Jacobian is NaN or infinite.
    #[error("the entries of a Jacobian must be finite numbers")]
    NotFinite {
        /// Index of the task, 0 = highest priority.
        task: usize,
    },
    /// No finite velocity satisfies a row: its velocity is not finite, or its lower bound is above its upper bound.
    #[error(
        "row {row} allows no finite velocity; give a finite velocity, or a lower bound at or below the upper bound"
    )]
    Bounds {
        /// Index of the task, 0 = highest priority.
        task: usize,
        /// Index of the row, from 0.
        row: usize,
    },
    /// A task that is to be scaled has rows that are no equations, so it has no direction to keep.
    #[error("a scaled task needs velocities; it cannot have lower and upper bounds")]
    Scaled {
        /// Index of the task, 0 = highest priority.
        task: usize,
    },
}

/// One or more tasks over the same n ≥ 1 joints, with finite entries; index 0 is the highest priority (k = 1).
#[derive(Debug, Clone, PartialEq)]
pub struct TaskStack {
    tasks: Vec<Task>,
    joints: usize,
}

impl TaskStack {
    /// Checks and builds a stack; highest priority first.
    pub fn new(tasks: Vec<Task>) -> Result<Self, TaskError> {
        let joints = tasks.first().ok_or(TaskError::NoTasks)?.jacobian.ncols();
        for (index, task) in tasks.iter().enumerate() {
            let (rows, columns) = task.jacobian.shape();
            let mismatch = [task.lower.len(), task.upper.len()].into_iter().find(|given| *given != rows || rows == 0);
            if let Some(velocities) = mismatch {
                return Err(TaskError::Rows { task: index, rows, velocities });
            }
            if columns != joints || joints == 0 {
                return Err(TaskError::Columns { task: index, columns, joints });
            }
            task.check_numbers(index)?;
            if task.scaled && !task.is_equation() {
                return Err(TaskError::Scaled { task: index });
            }
        }
        Ok(Self { tasks, joints })
    }

    /// Overwrites Jacobians and bounds: calls `write(index, J_k, lower, upper)` for each task, index 0 = highest priority.
    ///
    /// `write` must keep the sizes, and the rows of scaled tasks equations. On an error the stack holds the invalid numbers
    /// and must be overwritten again.
    pub fn overwrite(
        &mut self,
        mut write: impl FnMut(usize, &mut Matrix, &mut Vector, &mut Vector),
    ) -> Result<(), TaskError> {
        let mut result = Ok(());
        for (index, task) in self.tasks.iter_mut().enumerate() {
            write(index, &mut task.jacobian, &mut task.lower, &mut task.upper);
            result = result.and(task.check_numbers(index));
        }
        result
    }

    /// Overwrites Jacobians: calls `write(index, J_k)` for each task, which must keep the size. On an error the stack holds
    /// the invalid numbers and must be overwritten again.
    pub fn overwrite_jacobians(&mut self, mut write: impl FnMut(usize, &mut Matrix)) -> Result<(), TaskError> {
        let mut result = Ok(());
        for (task, Task { jacobian, .. }) in self.tasks.iter_mut().enumerate() {
            write(task, jacobian);
            result =
                result.and(if is_finite(jacobian.as_slice()) { Ok(()) } else { Err(TaskError::NotFinite { task }) });
        }
        result
    }

    /// Returns the tasks, highest priority first.
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// Returns the place of a task's first row among the rows of all tasks.
    pub fn first_row(&self, task: usize) -> usize {
        self.tasks[..task].iter().map(|task| task.jacobian.nrows()).sum()
    }

    /// Returns n, the number of joints.
    pub fn joint_count(&self) -> usize {
        self.joints
    }
}

/// Returns whether all entries are finite numbers: 0 times infinity or NaN is NaN.
fn is_finite(entries: &[f64]) -> bool {
    let (chunks, rest) = entries.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for chunk in chunks {
        for lane in 0..4 {
            sums[lane] += 0.0 * chunk[lane];
        }
    }
    rest.iter().all(|entry| entry.is_finite()) && sums == [0.0; 4]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn between(lower: f64, upper: f64) -> Task {
        Task::between(
            "",
            Matrix::from_element(1, 2, 1.0),
            Vector::from_element(1, lower),
            Vector::from_element(1, upper),
        )
    }

    #[test]
    fn bounds_that_no_velocity_satisfies_are_refused() {
        for (lower, upper) in [
            (1.0, 0.5),
            (f64::INFINITY, f64::INFINITY),
            (f64::NEG_INFINITY, f64::NEG_INFINITY),
            (f64::NAN, 1.0),
            (0.0, f64::NAN),
        ] {
            let refused = TaskStack::new(vec![between(0.0, 0.0), between(lower, upper)]);
            assert_eq!(refused, Err(TaskError::Bounds { task: 1, row: 0 }), "{lower} {upper}");
        }
        for (lower, upper) in [(f64::NEG_INFINITY, f64::INFINITY), (-1.0, f64::INFINITY), (0.5, 0.5)] {
            assert!(TaskStack::new(vec![between(lower, upper)]).is_ok(), "{lower} {upper}");
        }
    }

    #[test]
    fn only_tasks_of_equations_can_be_scaled() {
        let scaled = |task: Task| TaskStack::new(vec![Task { scaled: true, ..task }]);
        assert_eq!(scaled(between(0.0, 1.0)), Err(TaskError::Scaled { task: 0 }));
        assert!(scaled(between(0.5, 0.5)).is_ok());
    }

    #[test]
    fn every_row_needs_both_bounds() {
        let longer = Task { upper: Vector::zeros(2), ..between(0.0, 1.0) };
        assert_eq!(TaskStack::new(vec![longer]), Err(TaskError::Rows { task: 0, rows: 1, velocities: 2 }));
    }

    #[test]
    fn overwritten_numbers_are_checked() {
        let mut stack = TaskStack::new(vec![between(0.0, 1.0), between(0.0, 1.0)]).unwrap();
        let mut set = |row: f64, bound: f64| {
            stack.overwrite(|k, jacobian, lower, _| {
                if k == 1 {
                    (jacobian[(0, 0)], lower[0]) = (row, bound);
                }
            })
        };
        assert_eq!(set(f64::INFINITY, 0.0), Err(TaskError::NotFinite { task: 1 }));
        assert_eq!(set(1.0, 2.0), Err(TaskError::Bounds { task: 1, row: 0 }));
        assert_eq!(set(1.0, 1.0), Ok(()));
    }
}
