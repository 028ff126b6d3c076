//! One control period: measured state in, joint velocities out.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    ActiveInequality, ActiveLimit, ChannelInput, ChannelMemory, CollisionReport, ContactMemory, Contradiction,
    Controller, DriveState, JointVector, ObstacleState, Pose, Side, Singularity, SolverReport, StreamedTarget,
    TargetStream, TaskOutcome, ViolatedInequality, ViolatedLimit, VirtualArm, Wrench, WrenchSensorMemory,
};
use super::{integer, object};

/// The measured state of one control period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Sequence number of the period; must increase. Repeat it only with an unchanged state, to get the same answer
    /// again.
    #[serde(deserialize_with = "integer::deserialize")]
    pub sequence: u64,
    /// Time t of the measurement, s, on any clock that runs evenly. Profiles count on the same clock; on the clock of Unix
    /// (times above 1e9 s) they count from the first state.
    pub time_s: f64,
    /// Measured joint position q, rad or m, in joint order or by name.
    pub joint_position: JointVector,
    /// Measured joint velocity q̇, rad/s or m/s. Omit it if the arm measures only positions or its velocities are
    /// noisy; default: the last command.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_velocity: Option<JointVector>,
    /// Measured wrench: without the weight of the tool, or the raw reading of the controller's `wrench_sensor`; required by the laws `contact`, `force`, `impedance` and
    /// `hybrid`, and by a `wrench_sensor`, also one that a tare has added.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub wrench: Option<Wrench>,
    /// Measured wrenches of tips other than the tool, by the name of the tip, without the weight of what the tip carries unless the
    /// controller has its sensor in `wrench_sensors`; required by
    /// the same laws of tasks whose `link` is such a tip. Axes are those of `wrench_frame`: of the base, or of the tip itself.
    /// Default: none.
    #[serde(default, deserialize_with = "object::map", skip_serializing_if = "BTreeMap::is_empty")]
    #[schema(example = json!({"right": {"force": [0, 0, 5], "torque": [0, 0, 0]}}))]
    pub wrenches: BTreeMap<String, Wrench>,
    /// New targets by task name, if any arrived since the last state; default: none. Between targets the task
    /// interpolates or extrapolates, as its `streaming` says.
    #[serde(default, deserialize_with = "object::map", skip_serializing_if = "BTreeMap::is_empty")]
    #[schema(example = json!({"hand": {"time_s": 0.95, "pose": {"position": [0.6, 0.1, 0.4]}}}))]
    pub targets: BTreeMap<String, StreamedTarget>,
    /// What arrived for the channels of the controller, by name; default: nothing.
    #[serde(default, deserialize_with = "object::map", skip_serializing_if = "BTreeMap::is_empty")]
    #[schema(example = json!({"gripper": {"target": 0.02, "measured": 0.08}}))]
    pub channels: BTreeMap<String, ChannelInput>,
    /// Where the moving obstacles of the controller are; each must be named. Default: none.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<ObstacleState>,
}

/// `POST /v1/step`: controller, state and memory in one body, without a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StepRequest {
    /// Controller; the same in every step, so that the service finds it again.
    #[serde(deserialize_with = "object::deserialize")]
    pub controller: Controller,
    /// Measured state.
    #[serde(deserialize_with = "object::deserialize")]
    pub state: State,
    /// Memory of the last answer, unchanged; `null` at the first step.
    #[serde(default, deserialize_with = "object::optional")]
    pub memory: Option<Memory>,
}

/// The memory of a controller. Clients send it back unchanged with the next state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    /// Sequence number of the last state.
    #[serde(deserialize_with = "integer::deserialize")]
    pub sequence: u64,
    /// Time of the last state, s; default: unknown, then the next state is not compared with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// Joint position of the last state, rad or m; default: unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_position: Option<Vec<f64>>,
    /// Validity of the last answer, ms: how long the arm may have held its command. Default: unknown, then the next state
    /// counts as one period later, whatever its time.
    #[schema(example = 100)]
    #[serde(default, deserialize_with = "integer::optional", skip_serializing_if = "Option::is_none")]
    pub valid_for_ms: Option<u64>,
    /// `stop_time_s` of the last answer, s; default: each joint brakes at its own deceleration.
    #[schema(example = 0.05)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop_time_s: Option<f64>,
    /// How far the joints move behind the modelled drive in the period after the last state, rad or m: positions tell by it whether
    /// a state is late or the clock jumped. Default: the velocity of the drive for a period.
    #[schema(example = json!([0.001, 0.0, -0.002]))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub way: Option<Vec<f64>>,
    /// Time of the first state, from which profiles count, s; default: 0, unless that time is above 1e9 s.
    #[schema(example = 1_780_000_000.0)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_time_s: Option<f64>,
    /// Integrator velocity of each task, m/s and rad/s.
    pub task_velocities: Vec<Vec<f64>>,
    /// Tool pose at the first step, base frame, m.
    #[serde(deserialize_with = "object::deserialize")]
    pub initial_pose: FramePose,
    /// Joint velocity of the last command, rad/s or m/s.
    pub last_command: Vec<f64>,
    /// The commands that the drive still has to follow; default: the last command for long.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub drive: Option<DriveState>,
    /// What joints with a jerk limit remember; default: they have moved at the last command for long.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub jerk: Option<JerkState>,
    /// Active limits of the last command, per level of the solver.
    pub active_set: Vec<Vec<ActiveLimitName>>,
    /// Streamed targets of the tasks; default: none.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub target_streams: Vec<TargetStream>,
    /// Joint position of the first state, rad or m; default: that of the next state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial_joint_position: Option<Vec<f64>>,
    /// How each task follows its requests; default: all follow.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub task_progress: Vec<Progress>,
    /// Joints that did not follow their commands lately; default: none.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub stalls: Vec<Stall>,
    /// How the joints turn and what the tasks gained by it, so that the arm comes to rest; default: the next state starts anew.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub rest: Option<RestState>,
    /// The virtual arm of laws that look ahead; default: none, or the next state starts anew.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub virtual_arm: Option<VirtualArm>,
    /// What the law `contact` remembers of each of its axes, in the order of the tasks; default: the next state starts anew.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub contacts: Vec<ContactMemory>,
    /// What the wrench sensors remember, the tool first, then the other tips in the order of the robot; default: they start.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!([{"velocity": [0.01, 0.0, -0.02]}]))]
    pub wrench_sensors: Vec<WrenchSensorMemory>,
    /// Whether the controller replaces another one and still limits accelerations for that; default: no.
    #[schema(example = false)]
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub in_transition: bool,
    /// The channels of the controller; default: none had a target.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<ChannelMemory>,
}

/// How the joints turn and what the tasks gained by it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RestState {
    /// W, what the joints have spent by turning without a gain, 0 to 2.7.
    #[schema(example = 0.12)]
    pub spent: f64,
    /// How often they have spent all; default 0.
    #[serde(default, deserialize_with = "integer::deserialize")]
    pub exhausted: u32,
    /// Time since which the requests fade, s; default: they do not.
    #[schema(example = 12.4)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fading_since_s: Option<f64>,
    /// How each joint turns, in joint order.
    #[serde(deserialize_with = "object::list")]
    pub joints: Vec<JointTurns>,
    /// What the tasks that follow positions have gained.
    #[serde(deserialize_with = "object::list")]
    pub tasks: Vec<TaskGain>,
}

/// How a joint turns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JointTurns {
    /// Command at the last turning point and extreme since then, rad/s or m/s.
    #[schema(example = json!([0.0, 0.4]))]
    pub velocity: [f64; 2],
    /// Whether the command falls since the last turning point; default: no.
    #[schema(example = false)]
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub falls: bool,
    /// Positions of the last two turns and extreme since then, rad or m; default: the joint has not moved.
    #[schema(example = json!([0.1, 0.1, 0.3]))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// How often in a row the joint turned where it had turned before; default 0.
    #[serde(default, deserialize_with = "integer::deserialize")]
    pub repeats: u32,
}

/// What a task has gained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TaskGain {
    /// Name of the task.
    pub task: String,
    /// The least distance from the target since it changed, m and rad together.
    #[schema(example = 0.02)]
    pub least: f64,
    /// The target of a task on the tool.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
    /// The target of a task on joints, one number per row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<f64>>,
}

/// What joints with a jerk limit remember.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JerkState {
    /// Acceleration of the last command, rad/s² or m/s²; 0 for joints without jerk limit.
    #[schema(example = json!([0.1]))]
    pub acceleration: Vec<f64>,
    /// Joint velocity that the tasks wanted in the last period, rad/s or m/s.
    #[schema(example = json!([0.5]))]
    pub requested: Vec<f64>,
}

/// How far a joint was commanded and has moved since it last followed its commands, or lately.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Stall {
    /// Name of the joint.
    #[schema(example = "j6")]
    pub joint: String,
    /// Commanded distance, behind the drive of the controller, rad or m.
    #[schema(example = 0.15)]
    pub commanded: f64,
    /// Measured distance, rad or m.
    #[schema(example = 0.0001)]
    pub moved: f64,
    /// Time of both distances, s.
    #[schema(example = 0.5)]
    pub time_s: f64,
}

/// How a task follows its requests over time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    /// Filtered share of the requested velocity that the task achieves, 0 to 1.
    pub share: f64,
    /// Time since which the share is below one half, s; default: it is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slow_since_s: Option<f64>,
    /// Time at which the arm began to leave the posture, s; default: it does not leave.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub leaving_since_s: Option<f64>,
    /// How often the arm has left since a target changed; default 0.
    #[serde(default, deserialize_with = "integer::deserialize")]
    pub attempts: u32,
    /// Distance of the task from its target when the arm left last, m and rad together; default: it has not left.
    #[schema(example = 0.4)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_at: Option<f64>,
}

/// A task that makes no progress: over half a second, it achieves less than 5 % of the velocity that it requests, or less than 5 % of its
/// request is passed on, see `request_share`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StuckTask {
    /// Name of the task.
    pub task: String,
    /// Time since which it makes no progress, or since which requests fade, s.
    #[schema(example = 3.2)]
    pub since_s: f64,
    /// What holds it back; empty while the arm leaves the posture, and where nothing but its own request does, which fades.
    #[schema(example = json!(["limits"]))]
    pub held_by: Vec<Obstacle>,
    /// Whether the arm leaves the posture, by a motion towards the middle of the ranges of its joints.
    #[schema(example = false)]
    pub leaving: bool,
}

/// What holds a task back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Obstacle {
    /// Limits of joints, or inequalities.
    Limits,
    /// A singular posture: no joint moves the task in the missing direction.
    Singularity,
    /// Tasks of higher priority.
    HigherTasks,
}

/// A pose with a rotation matrix, which keeps every bit when it is written and read, unlike a quaternion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FramePose {
    /// Position x, y, z in the base frame, m.
    pub position: [f64; 3],
    /// Rotation matrix, 3 × 3, row by row.
    pub rotation: [[f64; 3]; 3],
}

/// An active limit: a joint, an inequality, or a row of a task, and a side.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ActiveLimitName {
    /// Name of the joint, for a limit of a joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// Name of the inequality, for an inequality.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inequality: Option<String>,
    /// Name of the task, for a row of a task.
    #[schema(example = "height")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// Index of the row in its task, from 0.
    #[serde(default, deserialize_with = "integer::optional", skip_serializing_if = "Option::is_none")]
    #[schema(example = 0)]
    pub row: Option<usize>,
    /// Lower or upper bound; `upper` for an inequality.
    pub side: Side,
}

/// Joint velocities for one control period and their explanation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StepAnswer {
    /// Joint velocity q̇, the command, in joint order, rad/s or m/s.
    pub joint_velocity: Vec<f64>,
    /// Sequence number of the state.
    pub sequence: u64,
    /// Memory to send with the next state; only in answers without a session.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory: Option<Memory>,
    /// Wrench with which the laws computed: corrected, of the tool on the environment, at the tool point, base axes; absent without
    /// `wrench_sensor`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wrench: Option<Wrench>,
    /// The same of tips with a sensor in `wrench_sensors`, by the name of the tip.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schema(example = json!({"right_hand": {"force": [0, 0, 5], "torque": [0, 0, 0]}}))]
    pub wrenches: BTreeMap<String, Wrench>,
    /// Commands of the channels by name, m, rad, N or N·m; a channel without target so far is absent.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schema(example = json!({"gripper": 0.031}))]
    pub channels: BTreeMap<String, f64>,
    /// Validity of the command from the time of measurement, ms. Without a newer answer, brake the joints then: together
    /// within `stop_time_s`, or each at `braking_deceleration` if there is none. At most the controller's `valid_for_ms`; shorter, but at least a period (in whole ms, rounded down,
    /// and at least 1), if a joint would otherwise leave its range before it stops, if the `limits` include positions and the `solver` is
    /// not `closed_form`. Obstacles, and a tool that approaches or presses with the law `contact`, shorten it too.
    pub valid_for_ms: u64,
    /// Time in which a watchdog lowers the speeds of all joints evenly to rest, s, so that the tool keeps its direction: `joint_velocity`
    /// times 1 − t/`stop_time_s`. No joint then brakes faster than at its `braking_deceleration`, and every joint stops inside its range on
    /// the same terms. Absent: each joint brakes at its own. The law `contact` sets it where stopping together presses less, if the controller
    /// keeps no distances to obstacles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.05)]
    pub stop_time_s: Option<f64>,
    /// Deceleration with which a watchdog brakes each joint without `stop_time_s`, in joint order, rad/s² or m/s²; `null`: stop at once. With it
    /// every joint stops inside its range after `valid_for_ms`, if the `limits` include positions and the `solver` is not
    /// `closed_form`.
    #[serde(default)]
    #[schema(required = true, example = json!([8.0, 8.0, null]))]
    pub braking_deceleration: Vec<Option<f64>>,
    /// Warnings: what is not plausible about the state, and what to do.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!(["time_s went back from 3 to 1"]))]
    pub warnings: Vec<String>,
    /// Sentences that say what restricts the joint velocities, then what each task gives up; only if the controller has
    /// `"why": true`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!(["joint `j6` is at its lower limit", "task `hold` gives up 0.030 rad/s"]))]
    pub why: Vec<String>,
    /// Outcome of each task, highest priority first.
    pub tasks: Vec<TaskOutcome>,
    /// Tasks that make no progress, and what holds them back.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!([{"task": "hold", "since_s": 3.2, "held_by": ["limits"], "leaving": true}]))]
    pub stuck_tasks: Vec<StuckTask>,
    /// Share of the requests that remains, 0 to 1, because joints turn again and again although no task gains by it. At 0 the arm
    /// rests, perhaps short of its targets, until a target changes. Default: 1.
    #[schema(example = 0.0)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub request_share: Option<f64>,
    /// Time since which the requests fade, s; default: they do not.
    #[schema(example = 12.4)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fading_since_s: Option<f64>,
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
    /// Distances of the shapes; absent: the controller watches none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub collisions: Option<CollisionReport>,
    /// Names of joints whose acceleration or jerk limit contradicts position or velocity limits and is not kept.
    pub limit_conflict: Vec<String>,
    /// Solver path, status and optimality check.
    pub solver: SolverReport,
    /// Distance of the tasks from singularities.
    pub singularity: Singularity,
    /// Joint-limit index H: 0 with all joints in the middle of their ranges, ½ with all at a limit.
    pub joint_limit_index: f64,
    /// Time to compute the answer, µs.
    pub elapsed_us: f64,
}
