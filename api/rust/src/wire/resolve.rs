//! `POST /v1/resolve`: one stateless question.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::object;
use super::{
    ActiveInequality, ActiveLimit, Axis, Damping, Frame, Inequality, JointVector, Limits, Method, NullSpaceVelocity,
    Pose, Singularity, Solver, SolverReport, TaskOutcome, ViolatedInequality, ViolatedLimit,
};

/// Prioritised tasks at one posture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ResolveRequest {
    /// Name of a robot; may be left out when every task has its own `jacobian`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// q, rad or m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_position: Option<JointVector>,
    /// q̇⁻, the last command, rad/s or m/s; for acceleration limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_velocity: Option<JointVector>,
    /// T, s; for position and acceleration limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// The tasks, highest priority first.
    #[serde(deserialize_with = "object::list")]
    pub tasks: Vec<ResolveTask>,
    /// How priorities are understood.
    #[serde(default)]
    pub method: Method,
    /// How the problem is solved.
    #[serde(default)]
    pub solver: Solver,
    /// Allowed joint velocities; default `position_velocity` with a robot and a period, else `none`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<Limits>,
    /// What the velocities must obey beside the limits.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub inequalities: Vec<Inequality>,
    /// Damping near singularities; none (exact) if left out.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub damping: Option<Damping>,
    /// Where the tool point is, and how the tool's axes lie, in the robot's own tool frame; there if left out.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub tool_offset: Option<Pose>,
    /// ζ̇, what the joints do as far as the tasks allow; rest if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub null_space_velocity: Option<NullSpaceVelocity>,
}

/// One task: axes of the tool, or rows of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ResolveTask {
    /// Name; `task 1`, `task 2`, … if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Rows of the tool Jacobian.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<Axis>>,
    /// Along which axes the rows count.
    #[serde(default)]
    pub frame: Frame,
    /// The point at which they count: x, y, z in the tool frame, m; the tool point if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_point: Option<[f64; 3]>,
    /// Own rows, m × n.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jacobian: Option<Vec<Vec<f64>>>,
    /// ẋ_k, m/s and rad/s, one entry per row.
    pub velocity: Vec<f64>,
    /// Whether limits may slow the task down, but not bend it: J_k q̇ = s ẋ_k with the largest s ≤ 1.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub scale: bool,
}

/// Joint velocities and why they are what they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolveAnswer {
    /// q̇, rad/s or m/s.
    pub joint_velocity: Vec<f64>,
    /// What became of each task, highest priority first.
    pub tasks: Vec<TaskOutcome>,
    /// Limits that hold the answer back.
    pub active_limits: Vec<ActiveLimit>,
    /// Limits that the answer breaks.
    pub violated_limits: Vec<ViolatedLimit>,
    /// Inequalities that hold the answer back.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub active_inequalities: Vec<ActiveInequality>,
    /// Inequalities that the answer breaks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub violated_inequalities: Vec<ViolatedInequality>,
    /// Joints whose acceleration limit was overruled by position or velocity.
    pub limit_conflict: Vec<String>,
    /// How the answer was found.
    pub solver: SolverReport,
    /// How near the tasks are to singularities.
    pub singularity: Singularity,
    /// H, how near the joints are to the ends of their ranges: 0 with all in the middle, ½ with all at an end; only where
    /// robot and posture are given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_limit_index: Option<f64>,
    /// Time to compute it, µs.
    pub elapsed_us: f64,
}
