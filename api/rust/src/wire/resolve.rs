//! `POST /v1/resolve` and `POST /v1/resolve/batch`: tasks at a posture in, joint velocities out, without a session.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    ActiveInequality, ActiveLimit, Axis, Certificate, Contradiction, Damping, Frame, Inequality, JointVector, Limits,
    Method, NullSpaceVelocity, Pose, Problem, Singularity, Solver, SolverReport, TaskOutcome, ViolatedInequality,
    ViolatedLimit,
};
use super::{bounds, object};

/// Prioritised tasks at one posture, to resolve into joint velocities.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ResolveRequest {
    /// Name of the robot, from `GET /v1/robots`; not needed if every task has its own `jacobian`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// Joint position q, rad or m; needed unless every task has its own `jacobian`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_position: Option<JointVector>,
    /// Joint velocity of the last command, rad/s or m/s; needed for acceleration limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_velocity: Option<JointVector>,
    /// Control period T, s: how long the answer will be commanded. Needed for position and acceleration limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// The tasks, highest priority first: put first what must not give way.
    #[serde(deserialize_with = "object::list")]
    pub tasks: Vec<ResolveTask>,
    /// Resolution method, the meaning of priorities. Set another one only to compare; default
    /// `strict_reverse_priority`.
    #[serde(default)]
    pub method: Method,
    /// Solver. Keep the default on an arm: `qp` is a second, slower solver to compare with, and `closed_form` ignores
    /// limits. Default `auto`.
    #[serde(default)]
    pub solver: Solver,
    /// Limits of the joint velocities. Set them if the answer moves an arm; default: `position_velocity` with robot,
    /// posture and period; `velocity` with a robot alone; otherwise `none`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<Limits>,
    /// Inequalities on the joint velocities besides the limits: set them to keep the arm behind planes, or to couple
    /// joints; default: none.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub inequalities: Vec<Inequality>,
    /// Damping near singularities, which trades accuracy for lower joint speeds. Set it if the posture may be singular;
    /// default: no damping.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub damping: Option<Damping>,
    /// Pose of the tool point and axes in the robot's own tool frame, m. Set it to the point that works, such as the
    /// tip of a gripper; default: that frame itself.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub tool_offset: Option<Pose>,
    /// Null-space velocity ζ̇, which the answer follows as far as the tasks permit. Set it to choose the posture of a
    /// redundant arm; default: rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub null_space_velocity: Option<NullSpaceVelocity>,
    /// Whether the answer has `why`, sentences that say what restricts it. Set it while you try a problem out; default
    /// `false`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[schema(example = true)]
    pub why: bool,
    /// Whether the answer has a `certificate`, with which anyone can check that it is optimal. Set it to audit an answer;
    /// default `false`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[schema(example = true)]
    pub certificate: bool,
}

/// One task: axes of the tool or its own Jacobian, and their velocity or bounds of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ResolveTask {
    /// Name, by which the answer names the task; default `task 1`, `task 2`, …
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Axes of the tool that the task moves, one per row; list only those that matter, so that lower tasks keep the
    /// others. Instead of `jacobian`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<Axis>>,
    /// Axes along which the rows are measured. Set `tool` for motions relative to the tool, or a pose for a surface;
    /// default `base`.
    #[serde(default)]
    pub frame: Frame,
    /// Reference point of the rows: x, y, z in the tool frame, m. Set it if this task moves another point than the
    /// others; default: the tool point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_point: Option<[f64; 3]>,
    /// Tip or link that the axes belong to, by its name, in place of the tool. Set it for a second arm, an elbow or a camera; only with
    /// `axes`; default: the first tip, which is the tool.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// Tip or link from which the motion is seen, by its name, in place of the base: poses, velocities and the frame `base` are then those of
    /// its frame. Set it for two hands that hold one part; only with `axes`; default: the base.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_to: Option<String>,
    /// Task Jacobian J_k, m × n, row by row. Set it for rows that you compute, such as those of a mobile base; instead
    /// of `axes`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jacobian: Option<Vec<Vec<f64>>>,
    /// Task velocity ẋ_k, one entry per row, m/s and rad/s; instead of `lower` and `upper`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Lower bounds of the task velocity J_k q̇, one entry per row, m/s and rad/s. Set bounds instead of `velocity` if
    /// the task only limits a motion; `null`: no bound; default: none.
    #[serde(default, deserialize_with = "bounds::lower", skip_serializing_if = "Option::is_none")]
    pub lower: Option<Vec<Option<f64>>>,
    /// Upper bounds of the task velocity J_k q̇, as `lower`.
    #[serde(default, deserialize_with = "bounds::upper", skip_serializing_if = "Option::is_none")]
    pub upper: Option<Vec<Option<f64>>>,
    /// Whether limits slow the task down in its direction, J_k q̇ = s ẋ_k with the largest s ≤ 1. Set it for paths that
    /// must keep their shape; only with `velocity`; default `false`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub scale: bool,
}

/// Joint velocities and their explanation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolveAnswer {
    /// Joint velocity q̇, the command, in joint order, rad/s or m/s.
    pub joint_velocity: Vec<f64>,
    /// Warnings: numbers that are probably in another unit, and a method that does not keep the order of the tasks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!(["task `hand`: 300 m/s along x is faster than arms are; velocities are in m/s, not in mm/s"]))]
    pub warnings: Vec<String>,
    /// Sentences that say what restricts the joint velocities, then what each task gives up; only if the request has
    /// `"why": true`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!(["joint `j6` is at its lower limit", "task `hold` gives up 0.030 rad/s"]))]
    pub why: Vec<String>,
    /// Outcome of each task, highest priority first.
    pub tasks: Vec<TaskOutcome>,
    /// Active limits: bounds that the answer reaches and that restrict it.
    pub active_limits: Vec<ActiveLimit>,
    /// Violated limits. The solver `closed_form` may violate all; others exceed only speed limits that `limits` do not
    /// contain.
    pub violated_limits: Vec<ViolatedLimit>,
    /// Active inequalities.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub active_inequalities: Vec<ActiveInequality>,
    /// Violated inequalities.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub violated_inequalities: Vec<ViolatedInequality>,
    /// Contradictions: minimal sets of demands that cannot all be kept.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!([{"task": "height", "members": [
        {"task": "height", "row": 0, "side": "lower"}, {"joint": "j2", "side": "upper"}]}]))]
    pub contradictions: Vec<Contradiction>,
    /// Names of joints whose acceleration limit contradicts position or velocity limits and is not kept.
    pub limit_conflict: Vec<String>,
    /// Solver path, status and optimality check.
    pub solver: SolverReport,
    /// Distance of the tasks from singularities.
    pub singularity: Singularity,
    /// Joint-limit index H: 0 with all joints in the middle of their ranges, ½ with all at a limit; only with a robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_limit_index: Option<f64>,
    /// Certificate of the answer; only if the request has `"certificate": true`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certificate: Option<Certificate>,
    /// Time to compute the answer, µs.
    pub elapsed_us: f64,
}

/// Independent problems to resolve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BatchRequest {
    /// Problems, at most 10 000. Each is solved on its own, so their order does not matter.
    #[serde(deserialize_with = "object::list")]
    pub items: Vec<ResolveRequest>,
}

/// The results of a batch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BatchAnswer {
    /// One answer or error per problem, in the order of the request.
    pub items: Vec<BatchItem>,
}

/// The result of one problem of a batch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum BatchItem {
    /// The answer of `POST /v1/resolve`.
    Answer(Box<ResolveAnswer>),
    /// The error of `POST /v1/resolve`; its pointer is into the whole batch.
    Problem(Problem),
}
