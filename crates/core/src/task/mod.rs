//! Cartesian tasks in their order of priority.

use crate::linalg::{Matrix, Vector};

/// One task: J_k q̇ = ẋ_k.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Name, for people and answers.
    pub name: String,
    /// J_k, m_k × n; rows in m/s or rad/s per unit of joint speed.
    pub jacobian: Matrix,
    /// ẋ_k, m_k; m/s for linear rows, rad/s for angular rows.
    pub velocity: Vector,
    /// Where limits cut the task: `true` keeps its direction, J_k q̇ = s ẋ_k with the largest s ≤ 1; `false` leaves the
    /// least residual, whatever its direction.
    pub scaled: bool,
}

impl Task {
    /// A task that limits may bend.
    pub fn new(name: impl Into<String>, jacobian: Matrix, velocity: Vector) -> Self {
        Self { name: name.into(), jacobian, velocity, scaled: false }
    }
}

/// Why a stack is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TaskError {
    /// Nothing to do.
    #[error("give at least one task")]
    NoTasks,
    /// Rows and velocities do not pair.
    #[error("{rows} rows, but {velocities} velocities")]
    Rows {
        /// Place in the stack, 0 = highest priority.
        task: usize,
        /// m_k.
        rows: usize,
        /// Entries of ẋ_k.
        velocities: usize,
    },
    /// Every task is about the same joints.
    #[error("{columns} columns, but the arm has {joints} joints")]
    Columns {
        /// Place in the stack, 0 = highest priority.
        task: usize,
        /// Columns of J_k.
        columns: usize,
        /// n.
        joints: usize,
    },
    /// NaN or infinite.
    #[error("rows and velocities must be finite numbers")]
    NotFinite {
        /// Place in the stack, 0 = highest priority.
        task: usize,
    },
}

/// Tasks over the same n ≥ 1 joints, index 0 = highest priority (k = 1); at least one, all finite.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskStack {
    tasks: Vec<Task>,
    joints: usize,
}

impl TaskStack {
    /// Checks that the tasks fit together; highest priority first.
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

    /// Overwrites rows and velocities, which keep their sizes: `write(k, J_k, ẋ_k)` for each task, index 0 = highest
    /// priority.
    ///
    /// On an error the numbers are those that were written; the stack must be overwritten again.
    pub fn overwrite(&mut self, mut write: impl FnMut(usize, &mut Matrix, &mut Vector)) -> Result<(), TaskError> {
        let mut sound = Ok(());
        for (task, Task { jacobian, velocity, .. }) in self.tasks.iter_mut().enumerate() {
            write(task, jacobian, velocity);
            let finite = |entries: &[f64]| entries.iter().all(|entry| entry.is_finite());
            if sound.is_ok() && !(finite(jacobian.as_slice()) && finite(velocity.as_slice())) {
                sound = Err(TaskError::NotFinite { task });
            }
        }
        sound
    }

    /// The tasks, highest priority first.
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// n, the number of joints.
    pub fn joint_count(&self) -> usize {
        self.joints
    }

    /// All J_k, highest priority on top, Σm_k × n.
    pub fn stacked_jacobian(&self) -> Matrix {
        self.tasks
            .iter()
            .fold(Matrix::zeros(0, self.joints), |stacked, task| crate::linalg::stack(&stacked, &task.jacobian))
    }

    /// All ẋ_k, in the same order, Σm_k.
    pub fn stacked_velocity(&self) -> Vector {
        self.tasks.iter().fold(Vector::zeros(0), |stacked, task| crate::linalg::concatenate(&stacked, &task.velocity))
    }
}
