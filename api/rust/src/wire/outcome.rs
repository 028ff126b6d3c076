//! The parts that every answer with joint velocities has.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Path, Side, Status};

/// What became of one task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TaskOutcome {
    /// The task's name.
    pub name: String,
    /// ẋ_k, m/s and rad/s.
    pub requested: Vec<f64>,
    /// J_k q̇, m/s and rad/s.
    pub achieved: Vec<f64>,
    /// ‖J_k q̇ − ẋ_k‖.
    pub residual_norm: f64,
    /// Rank of J_k.
    pub rank: usize,
    /// Whether the task depends on lower ones: its rank and theirs add up to more than that of all together, Eq. (12).
    pub algorithmic: bool,
    /// s of a task with `"scale": true`, J_k q̇ = s ẋ_k; left out where no s keeps its direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// F_d of this period per row, N and N·m, `null` where no force is followed; only in answers to a state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_force: Option<Vec<Option<f64>>>,
}

/// A limit that holds the answer back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ActiveLimit {
    /// Joint name.
    pub joint: String,
    /// Which bound.
    pub side: Side,
    /// The bound, rad/s or m/s.
    pub value: f64,
    /// How much ½ residual² of the highest task that the limit holds back would fall per unit of a wider bound.
    pub multiplier: f64,
}

/// A limit that the answer breaks; only the solver `closed_form` does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ViolatedLimit {
    /// Joint name.
    pub joint: String,
    /// Which bound.
    pub side: Side,
    /// The bound, rad/s or m/s.
    pub limit: f64,
    /// The velocity, rad/s or m/s.
    pub value: f64,
}

/// How the answer was found and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SolverReport {
    /// Which way led to it.
    pub path: Path,
    /// How sure it is.
    pub status: Status,
    /// Iterations of Clarabel over all levels.
    pub iterations: u32,
    /// Levels that Clarabel failed to solve; an exact active-set method stood in.
    #[serde(default)]
    pub failures: u32,
    /// Largest relative residual of the optimality conditions; `null` without an answer or beyond the numbers, never
    /// when `status` is `optimal`.
    pub kkt_residual: Option<f64>,
}

/// How near the tasks are to singularities.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Singularity {
    /// σ_min of all task rows together.
    pub smallest_singular_value: f64,
    /// Product of their singular values.
    pub manipulability: f64,
    /// Whether a task depends on lower ones.
    pub algorithmic: bool,
}
