//! One control period: a state in, joint velocities out.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::object;
use super::{
    ActiveInequality, ActiveLimit, Controller, JointVector, Side, Singularity, SolverReport, TaskOutcome,
    ViolatedInequality, ViolatedLimit,
};

/// The measured state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Number of the period; must grow.
    pub sequence: u64,
    /// t, s.
    pub time_s: f64,
    /// q, rad or m.
    pub joint_position: JointVector,
    /// q̇, rad/s or m/s; the last command stands for it if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_velocity: Option<JointVector>,
    /// Measured wrench; may be left out where no law needs it.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub wrench: Option<Wrench>,
}

/// Force and torque at the tool point, along the axes of the controller's `wrench_frame`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Wrench {
    /// N.
    pub force: [f64; 3],
    /// N·m.
    pub torque: [f64; 3],
}

/// `POST /v1/step`: controller, state and memory in one body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StepRequest {
    /// The controller.
    #[serde(deserialize_with = "object::deserialize")]
    pub controller: Controller,
    /// The state.
    #[serde(deserialize_with = "object::deserialize")]
    pub state: State,
    /// The last answer's memory; `null` at the first step.
    #[serde(default, deserialize_with = "object::optional")]
    pub memory: Option<Memory>,
}

/// What a controller remembers; opaque to clients, who send it back as it came.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    /// Sequence number of the state that led here.
    pub sequence: u64,
    /// Integrator of each task, m/s and rad/s.
    pub task_velocities: Vec<Vec<f64>>,
    /// Tool pose at the first step.
    #[serde(deserialize_with = "object::deserialize")]
    pub initial_pose: FramePose,
    /// q̇ of the last command, rad/s or m/s.
    pub last_command: Vec<f64>,
    /// Active limits of the last command, level by level.
    pub active_set: Vec<Vec<ActiveLimitName>>,
}

/// A pose that survives writing and reading to the last bit: a rotation matrix, not a quaternion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FramePose {
    /// x, y, z in the base frame, m.
    pub position: [f64; 3],
    /// Rotation matrix, row by row.
    pub rotation: [[f64; 3]; 3],
}

/// A limit by joint and side, or an inequality by name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ActiveLimitName {
    /// Joint name, for a bound of a joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// Name of an inequality, for that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inequality: Option<String>,
    /// Which bound; inequalities have an upper one.
    pub side: Side,
}

/// Joint velocities for one period and why they are what they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StepAnswer {
    /// q̇, rad/s or m/s.
    pub joint_velocity: Vec<f64>,
    /// Sequence number of the state.
    pub sequence: u64,
    /// To be sent with the next state; only in stateless answers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory: Option<Memory>,
    /// Time from the measurement of the state after which, without a newer answer, the arm is to ramp to zero, ms.
    pub valid_for_ms: u64,
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
    /// H, how near the joints are to the ends of their ranges: 0 with all in the middle, ½ with all at an end.
    pub joint_limit_index: f64,
    /// Time to compute it, µs.
    pub elapsed_us: f64,
}
