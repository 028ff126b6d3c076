//! The parts that all answers with joint velocities share.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Path, Side, Status};

/// The outcome of one task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TaskOutcome {
    /// Name of the task.
    pub name: String,
    /// Requested task velocity ẋ_k, m/s and rad/s.
    pub requested: Vec<f64>,
    /// Achieved task velocity J_k q̇, m/s and rad/s.
    pub achieved: Vec<f64>,
    /// Norm of the residual, ‖J_k q̇ − ẋ_k‖.
    pub residual_norm: f64,
    /// Rank of the task Jacobian J_k.
    pub rank: usize,
    /// Whether the rows of the task depend on the rows of lower tasks (algorithmic singularity, Eq. (12)).
    pub algorithmic: bool,
    /// Factor s of a task with `"scale": true`, J_k q̇ = s ẋ_k; absent if no factor keeps its direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Target force F_d of this period per row, N and N·m; `null` on rows without one; only in answers to a state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_force: Option<Vec<Option<f64>>>,
}

/// An active limit: a bound that the answer reaches and that restricts it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ActiveLimit {
    /// Name of the joint.
    pub joint: String,
    /// Lower or upper bound.
    pub side: Side,
    /// Bound, rad/s or m/s.
    pub value: f64,
    /// Lagrange multiplier: decrease of ½ residual² of the highest restricted task per unit of a wider bound.
    pub multiplier: f64,
}

/// A limit that the answer violates. Only the solver `closed_form` violates limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ViolatedLimit {
    /// Name of the joint.
    pub joint: String,
    /// Lower or upper bound.
    pub side: Side,
    /// Bound, rad/s or m/s.
    pub limit: f64,
    /// Velocity of the joint, rad/s or m/s.
    pub value: f64,
}

/// Solver path, status and certificate of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SolverReport {
    /// Solver path that found the answer.
    pub path: Path,
    /// Whether the answer is certified optimal.
    pub status: Status,
    /// Number of iterations of Clarabel over all levels.
    pub iterations: u32,
    /// Number of levels that Clarabel failed to solve; an exact active-set method solved them.
    #[serde(default)]
    pub failures: u32,
    /// Largest relative residual of the optimality conditions; `null` without an answer or if not finite, never if
    /// `status` is `optimal`.
    pub kkt_residual: Option<f64>,
}

/// Distance of the tasks from singularities.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Singularity {
    /// Smallest singular value of all task rows together.
    pub smallest_singular_value: f64,
    /// Manipulability, the product of the singular values of all task rows together.
    pub manipulability: f64,
    /// Whether the rows of any task depend on the rows of lower tasks.
    pub algorithmic: bool,
}
