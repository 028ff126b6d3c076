//! The parts that all answers with joint velocities share.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{ChunkStatus, ContactReport, Path, Side, Status, TargetState, defaults};

/// The outcome of one task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TaskOutcome {
    /// Name of the task.
    pub name: String,
    /// Requested task velocity ẋ_k, m/s and rad/s; for a task with bounds the allowed velocity nearest to the achieved one.
    pub requested: Vec<f64>,
    /// Achieved task velocity J_k q̇, m/s and rad/s.
    pub achieved: Vec<f64>,
    /// Norm of the residual, ‖J_k q̇ − ẋ_k‖; for a task with bounds the norm of their violation.
    pub residual_norm: f64,
    /// Rank of the task Jacobian J_k.
    pub rank: usize,
    /// Whether the rows of the task depend on the rows of lower tasks (algorithmic singularity, Eq. (12)).
    pub algorithmic: bool,
    /// Factor s of a task with `"scale": true`, J_k q̇ = s ẋ_k; absent if no factor keeps its direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Target force F_d of this period per row, N and N·m; `null` on rows without one; only in answers to a state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_force: Option<Vec<Option<f64>>>,
    /// Contact of each row with the law `contact`; absent for other laws.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!([{"state": "contact", "stiffness_bound": 15300.0, "stiffness": 12000.0, "stiffness_uncertainty": 130.0,
        "predicted_force": 29.9, "surface_velocity": 0.0, "energy_j": 2.16, "approach_speed": 0.012, "unavoidable_peak": 32.7}]))]
    pub contact: Vec<ContactReport>,
    /// Where the streamed target of this period comes from; absent if no target was streamed to this task.
    #[schema(example = "following")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_state: Option<TargetState>,
    /// Time of the state minus time of the newest streamed target, s; negative if the target lies ahead.
    #[schema(example = 0.012)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_age_s: Option<f64>,
    /// The chunk of actions that the task follows; absent if none came.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chunk: Option<ChunkStatus>,
    /// Active rows of a task with bounds: rows that reach a bound and restrict the answer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!([{"row": 0, "side": "upper", "multiplier": 0.04}]))]
    pub active_rows: Vec<ActiveRow>,
}

/// An active row: a row of a task that reaches a bound and restricts the answer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ActiveRow {
    /// Index of the row in its task, from 0.
    #[schema(example = 0)]
    pub row: usize,
    /// Lower or upper bound.
    pub side: Side,
    /// Lagrange multiplier: decrease of ½ residual² of the highest restricted task per unit of a wider bound.
    pub multiplier: f64,
}

/// A contradiction: demands that cannot all be kept, of which any one can be dropped so that the others can.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Contradiction {
    /// Name of the task whose bounds cannot all be kept; `null` for the inequalities, which come before all tasks.
    pub task: Option<String>,
    /// Demands that contradict each other.
    #[schema(example = json!([{"task": "height", "row": 0, "side": "lower"}, {"joint": "j2", "side": "upper"}]))]
    pub members: Vec<ContradictionMember>,
}

/// A demand in a contradiction: a row of a task, a joint limit, or an inequality, and a side.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct ContradictionMember {
    /// Name of the task, for a row of a task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// Index of the row in its task, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub row: Option<usize>,
    /// Name of the joint, for a limit of a joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// Name of the inequality, for an inequality.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inequality: Option<String>,
    /// Lower or upper bound.
    pub side: Side,
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

/// A limit that the answer violates.
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

/// Solver path, status and optimality check of an answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SolverReport {
    /// Solver path that found the answer.
    pub path: Path,
    /// Whether the answer is certified optimal.
    pub status: Status,
    /// Number of iterations of Clarabel over all levels; 0 unless the solver is `qp`.
    pub iterations: u32,
    /// Number of levels for which Clarabel found no answer, with the solver `qp`. An answer at its cap of iterations counts
    /// as one; its residual judges it. Where a level has no answer, the result keeps what the levels above achieved, and
    /// `status` is not `optimal`.
    #[serde(default)]
    pub failures: u32,
    /// Largest relative residual of the optimality conditions; `null` without an answer or if not finite, never if
    /// `status` is `optimal`.
    pub kkt_residual: Option<f64>,
    /// Whether a rank decision lies so near its threshold that rounding may have decided it; default `false`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[schema(example = true)]
    pub rank_uncertain: bool,
    /// Number of working sets (sets of active limits) that the solver `auto` tried; 0 with the others.
    #[serde(default)]
    pub working_sets: u32,
    /// Number of problems for which the solver `auto` needed its last resort, one change of the active limits
    /// at a time; absent if 0.
    #[serde(default, skip_serializing_if = "defaults::is_default")]
    #[schema(example = 1)]
    pub last_resorts: u32,
    /// What Clarabel did at each level, in the order of solution; only with the solver `qp`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<SolverLevel>,
}

/// What Clarabel did at one level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SolverLevel {
    /// Number of iterations; 0 with a `clarabel_residual` of 0 where the levels above leave nothing to decide.
    pub iterations: u32,
    /// Largest relative residual of the optimality conditions of the level at Clarabel's answer; `null` without an answer.
    /// Where the level was solved again from its first answer, this is the residual of the first one.
    pub clarabel_residual: Option<f64>,
    /// The same after the polish, one linear solve on Clarabel's active limits, if that is more accurate; otherwise before
    /// it. Where the level was solved again from its first answer, this is the residual of the last one. It is at least the
    /// relative change that lower levels made to the rows that the level keeps, so it can be larger than `clarabel_residual`.
    pub residual: Option<f64>,
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
