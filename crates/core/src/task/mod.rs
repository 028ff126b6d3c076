//! Tasks in their order of priority.

use crate::linalg::{Matrix, Vector};

/// One task J_k q̇ = ẋ_k.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Name that answers use.
    pub name: String,
    /// J_k, m_k × n, in m/s or rad/s per unit of joint speed.
    pub jacobian: Matrix,
    /// ẋ_k, m_k; m/s for linear rows, rad/s for angular rows.
    pub velocity: Vector,
    /// How the task gives way to limits. `true`: its velocity keeps its direction, J_k q̇ = s ẋ_k with the largest
    /// s ≤ 1. `false`: its residual is as small as possible, and the direction may change.
    pub scaled: bool,
}

impl Task {
    /// Builds a task that is not scaled: limits may change its direction.
    pub fn new(name: impl Into<String>, jacobian: Matrix, velocity: Vector) -> Self {
        Self { name: name.into(), jacobian, velocity, scaled: false }
    }
}

/// Why a stack is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TaskError {
    /// The list of tasks is empty.
    #[error("give at least one task")]
    NoTasks,
    /// A task has no rows, or not one velocity per row.
    #[error("{rows} rows, but {velocities} velocities")]
    Rows {
        /// Index of the task, 0 = highest priority.
        task: usize,
        /// m_k.
        rows: usize,
        /// Entries of ẋ_k.
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
    /// A row or velocity is NaN or infinite.
    #[error("rows and velocities must be finite numbers")]
    NotFinite {
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
        for (task, Task { jacobian, velocity, .. }) in tasks.iter().enumerate() {
            if jacobian.nrows() != velocity.len() || velocity.is_empty() {
                return Err(TaskError::Rows { task, rows: jacobian.nrows(), velocities: velocity.len() });
            }
            if jacobian.ncols() != joints || joints == 0 {
                return Err(TaskError::Columns { task, columns: jacobian.ncols(), joints });
            }
            if !jacobian.iter().chain(velocity.iter()).all(|entry| entry.is_finite()) {
                return Err(TaskError::NotFinite { task });
            }
        }
        Ok(Self { tasks, joints })
    }

    /// Overwrites Jacobians and velocities: calls `write(index, J_k, ẋ_k)` for each task, index 0 = highest priority.
    ///
    /// `write` must keep the sizes. On an error the stack holds the invalid numbers and must be overwritten again.
    pub fn overwrite(&mut self, mut write: impl FnMut(usize, &mut Matrix, &mut Vector)) -> Result<(), TaskError> {
        let mut result = Ok(());
        for (task, Task { jacobian, velocity, .. }) in self.tasks.iter_mut().enumerate() {
            write(task, jacobian, velocity);
            let finite = |entries: &[f64]| entries.iter().all(|entry| entry.is_finite());
            if result.is_ok() && !(finite(jacobian.as_slice()) && finite(velocity.as_slice())) {
                result = Err(TaskError::NotFinite { task });
            }
        }
        result
    }

    /// Returns the tasks, highest priority first.
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// Returns n, the number of joints.
    pub fn joint_count(&self) -> usize {
        self.joints
    }

    /// Returns all J_k, highest priority on top, Σm_k × n.
    pub fn stacked_jacobian(&self) -> Matrix {
        self.tasks
            .iter()
            .fold(Matrix::zeros(0, self.joints), |stacked, task| crate::linalg::stack(&stacked, &task.jacobian))
    }

    /// Returns all ẋ_k in the same order, Σm_k.
    pub fn stacked_velocity(&self) -> Vector {
        self.tasks.iter().fold(Vector::zeros(0), |stacked, task| crate::linalg::concatenate(&stacked, &task.velocity))
    }
}
