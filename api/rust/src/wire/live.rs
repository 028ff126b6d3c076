//! Interactive simulations, and live views of simulations and sessions.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    CollisionReport, ContactFault, ContactState, Controller, Method, ObstacleState, Path, Pose, Simulation, Solver,
    State, Status, StepAnswer, StreamedTarget, integer, object,
};

/// `POST /v1/simulations/{id}/control`: changes to a run. A field that is left out changes nothing.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SimulationControl {
    /// Whether the run pauses, or goes on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paused: Option<bool>,
    /// Number of control periods to run before the run pauses.
    #[serde(deserialize_with = "integer::optional", skip_serializing_if = "Option::is_none")]
    pub step: Option<u64>,
    /// Simulated seconds per second of real time; less than 1 to watch a contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// External force on the tool, N, base axes. Send it again at least once a second: it ends 1 s (real time) after
    /// the last request that sets it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub external_force: Option<[f64; 3]>,
    /// New targets by task name, without `time_s`: part of the next state. Between targets the task interpolates or
    /// extrapolates, as its `streaming` says.
    #[serde(deserialize_with = "object::map", skip_serializing_if = "BTreeMap::is_empty")]
    #[schema(example = json!({"push x": {"force": [25]}}))]
    pub targets: BTreeMap<String, StreamedTarget>,
    /// New resolution method. The change is blended over 0.1 s of simulated time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// New solver; the joint velocities change only if one of both is `closed_form`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<Solver>,
    /// New controller. It may differ from the present one in method, solver, `why` and the laws `contact`, `force`, `impedance`,
    /// `hybrid`.
    #[serde(deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub controller: Option<Controller>,
    /// Whether to finish the run now and keep its trace so far; a paused run does one more period. Default `false`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub end: bool,
}

/// The state of a run at one moment, and samples since the previous frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LiveFrame {
    /// The run with its present pace, method and solver.
    pub run: Simulation,
    /// Simulated time, s.
    pub time_s: f64,
    /// Number of finished control periods.
    pub done: u64,
    /// Recently reached speed, simulated seconds per second of real time.
    pub reached_speed: f64,
    /// External force on the tool, N, base axes.
    pub external_force: [f64; 3],
    /// Present posture of the arm.
    pub arm: ArmView,
    /// Number of periods per solver path.
    pub paths: PathCounts,
    /// Histogram of the times to compute an answer.
    pub solve_time: TimeHistogram,
    /// Histogram of the times from state to answer.
    pub round_trip: TimeHistogram,
    /// Some of the periods since the previous frame, evenly spaced, oldest first.
    pub samples: Vec<LiveSample>,
}

/// An arm at a posture, for drawing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ArmView {
    /// The joints, base first.
    pub joints: Vec<JointView>,
    /// Tool pose in the base frame, m.
    pub tool: Pose,
    /// The chain to each tip, first the tool; absent if all joints are one chain.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!([{"joints": [0, 1, 2, 3], "tip": [0.5, 0.2, 0.0]}]))]
    pub chains: Vec<ChainView>,
}

/// The chain of joints from the base to a tip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ChainView {
    /// Its joints, base first: places in `joints`, from 0.
    #[schema(example = json!([0, 1, 2, 3]))]
    pub joints: Vec<usize>,
    /// Position of the tip in the base frame, m.
    #[schema(example = json!([0.5, 0.2, 0.0]))]
    pub tip: [f32; 3],
}

/// The axis of a joint, and the velocities that its limits allow.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JointView {
    /// Point on the axis, base frame, m.
    pub origin: [f32; 3],
    /// Direction of the axis, unit vector, base frame.
    pub axis: [f32; 3],
    /// Minimum velocity in this period, rad/s or m/s; `null` without a bound.
    pub lower: Option<f32>,
    /// Maximum velocity in this period, rad/s or m/s; `null` without a bound.
    pub upper: Option<f32>,
}

/// Number of periods per solver path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
pub struct PathCounts {
    /// Solved by pseudo-inverses.
    pub closed_form: u64,
    /// Solved by active sets, starting from the last one.
    pub active_set: u64,
    /// Solved by Clarabel.
    pub qp: u64,
}

/// A histogram of times.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct TimeHistogram {
    /// Counts, ten bins per decade: bin 0 below 1 µs, bin k from 10^((k−1)/10) µs, the last bin from 0.1 s.
    pub counts: Vec<u64>,
    /// Maximum time, µs.
    pub worst_us: f64,
}

/// One control period, in single precision. Vectors of joints follow the robot's joint order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LiveSample {
    /// Simulated time, s.
    pub time_s: f64,
    /// Joint position q, rad or m.
    pub joint_position: Vec<f32>,
    /// Commanded joint velocity q̇, rad/s or m/s.
    pub joint_velocity: Vec<f32>,
    /// Tool position in the base frame, m.
    pub position: [f32; 3],
    /// Orientation of the tool in the base frame, a unit quaternion w, x, y, z.
    #[serde(default)]
    #[schema(required = true)]
    pub orientation: [f32; 4],
    /// Force F_e of the tool on the environment, base axes, N.
    pub force: [f32; 3],
    /// Target force F_d, N; `null` on axes that are not force-controlled.
    pub target_force: [Option<f32>; 3],
    /// Distance to the wall, m, positive when free; `null` without a wall.
    pub wall_distance_m: Option<f32>,
    /// Residual ‖J_k q̇ − ẋ_k‖ per task, highest priority first.
    pub residual_norms: Vec<f32>,
    /// Achieved minus requested velocity J_k q̇ − ẋ_k per task and row, m/s and rad/s, highest priority first.
    #[serde(default)]
    #[schema(required = true)]
    pub task_residuals: Vec<Vec<f32>>,
    /// Smallest singular value of all task rows together.
    pub smallest_singular_value: f32,
    /// Joints (index from 0) at their lower bound at any time since the previous sample.
    pub at_lower: Vec<usize>,
    /// Joints (index from 0) at their upper bound at any time since the previous sample.
    pub at_upper: Vec<usize>,
    /// Names of the inequalities that restricted the command at any time since the previous sample.
    #[serde(default)]
    #[schema(required = true)]
    pub active_inequalities: Vec<String>,
    /// Solver path of the command.
    pub path: Path,
    /// Whether the command is certified optimal.
    pub status: Status,
    /// Relative residual of the optimality conditions; `null` if there is none.
    pub kkt_residual: Option<f32>,
    /// Time to compute the answer, µs.
    pub solve_us: f32,
    /// Time from state to answer, µs.
    pub round_trip_us: f32,
    /// Whether the service answered in this period.
    pub answered: bool,
    /// Commands of the channels by name.
    #[schema(example = json!({"gripper": 0.031}))]
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub channels: BTreeMap<String, f32>,
    /// The room around the arm; absent without collision avoidance, and before the first answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub room: Option<LiveRoom>,
    /// Contacts of the tasks with the law `contact`; absent without such a task.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!([{"task": 0, "row": 0, "state": "contact", "force": 29.7, "target_force": 30.0, "stiffness": 12000.0}]))]
    pub contacts: Vec<LiveContact>,
    /// What restricts the command and what its tasks give up, in sentences; only if the controller has `"why": true`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!(["joint `j6` is at its lower limit", "task `hold` gives up 0.031 rad/s"]))]
    pub why: Vec<String>,
}

/// The contact of one axis with the law `contact` in one control period, along its pressing direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LiveContact {
    /// Place of the task, from 0, highest priority first.
    #[schema(example = 0)]
    pub task: usize,
    /// Row of the task, from 0.
    #[schema(example = 0)]
    pub row: usize,
    /// State of the contact.
    pub state: ContactState,
    /// Why the contact is given up; only in the state `fault`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<ContactFault>,
    /// Measured force, N or N·m.
    #[schema(example = 29.7)]
    pub force: f32,
    /// Target force, N or N·m.
    #[schema(example = 30.0)]
    pub target_force: f32,
    /// Estimated stiffness, N/m or N·m/rad; absent until it is known.
    #[schema(example = 12_000.0)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f32>,
}

/// The room around an arm in one control period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LiveRoom {
    /// Distances of the answer.
    pub report: CollisionReport,
    /// Where the moving obstacles are.
    pub obstacles: Vec<ObstacleState>,
}

/// One control period of a session, as `GET /v1/controllers/{id}/watch` shows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WatchedStep {
    /// The measured state.
    pub state: State,
    /// The answer to it.
    pub answer: StepAnswer,
    /// The arm at this state, for drawing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<ArmView>,
}
