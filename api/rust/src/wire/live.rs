//! Runs that are paced, pushed and changed while they go on, and what is seen of them.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Controller, Method, Path, Pose, Simulation, Solver, Status, object};

/// How a run is paced.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Interactive {
    /// Simulated seconds per second of real time, as far as the machine keeps up.
    #[serde(default = "real_time")]
    pub speed: f64,
    /// Whether simulated time stands still.
    #[serde(default)]
    pub paused: bool,
}

fn real_time() -> f64 {
    1.0
}

/// `POST /v1/simulations/{id}/control`: what is to change; everything else stays.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SimulationControl {
    /// Whether simulated time stands still.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paused: Option<bool>,
    /// Control periods to go on for, and to pause after.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<u64>,
    /// Simulated seconds per second of real time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Pushes the tool, N, base axes. It ends a second of real time after it was last said, so say it again to hold it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub external_force: Option<[f64; 3]>,
    /// How priorities are understood from now on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// How each period's problem is solved from now on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<Solver>,
    /// The controller from now on; from the one before it may differ in method, solver, and the laws `force`,
    /// `impedance` and `hybrid`, which integrate and so do not jump.
    #[serde(deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub controller: Option<Controller>,
    /// Whether the run is finished here: what there is of it becomes its trace. A run that is paused does one more period.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub end: bool,
}

/// What is seen of a run at one moment, and what happened since the frame before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LiveFrame {
    /// The run with its pace, method and solver as they are now.
    pub run: Simulation,
    /// Simulated time, s.
    pub time_s: f64,
    /// Control periods done.
    pub done: u64,
    /// Simulated seconds per second of real time that were reached of late.
    pub reached_speed: f64,
    /// What pushes the tool from outside, N, base axes.
    pub external_force: [f64; 3],
    /// The arm as it stands now.
    pub arm: ArmView,
    /// How many periods each way solved.
    pub paths: PathCounts,
    /// Time to compute the answers.
    pub solve_time: TimeHistogram,
    /// Time between states and answers.
    pub round_trip: TimeHistogram,
    /// Periods since the frame before, oldest first: some of them, evenly spread.
    pub samples: Vec<LiveSample>,
}

/// An arm at a posture, for drawing it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ArmView {
    /// The joints, base first.
    pub joints: Vec<JointView>,
    /// The tool in the base frame.
    pub tool: Pose,
}

/// A joint in space and the velocities that it may have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JointView {
    /// A point of its axis, base frame, m.
    pub origin: [f32; 3],
    /// Direction of its axis, base frame, of unit length.
    pub axis: [f32; 3],
    /// Smallest velocity that the limits allow in this period, rad/s or m/s; `null` without a bound.
    pub lower: Option<f32>,
    /// Largest velocity that they allow.
    pub upper: Option<f32>,
}

/// How many periods each way solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
pub struct PathCounts {
    /// By pseudo-inverses.
    pub closed_form: u64,
    /// By active sets that start from the last one.
    pub active_set: u64,
    /// By Clarabel.
    pub qp: u64,
}

/// How often a time took how long.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct TimeHistogram {
    /// Counts, ten bins per decade: the first one below 1 µs, bin k from 10^((k−1)/10) µs on, the last one from 0.1 s on.
    pub counts: Vec<u64>,
    /// The longest time, µs.
    pub worst_us: f64,
}

/// One control period, to single precision. Vectors of joints follow the robot's joint order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LiveSample {
    /// Simulated time, s.
    pub time_s: f64,
    /// q, rad or m.
    pub joint_position: Vec<f32>,
    /// q̇ as commanded, rad/s or m/s.
    pub joint_velocity: Vec<f32>,
    /// Tool position in the base frame, m.
    pub position: [f32; 3],
    /// F_e on the environment, N.
    pub force: [f32; 3],
    /// F_d, N; `null` where the axis is not force-controlled.
    pub target_force: [Option<f32>; 3],
    /// Distance to the wall, m, positive when free; `null` without a wall.
    pub wall_distance_m: Option<f32>,
    /// ‖J_k q̇ − ẋ_k‖ per task, highest priority first.
    pub residual_norms: Vec<f32>,
    /// σ_min of all task rows together.
    pub smallest_singular_value: f32,
    /// Joints, counted from 0, that were at their lower bound since the sample before.
    pub at_lower: Vec<usize>,
    /// Joints, counted from 0, that were at their upper bound since the sample before.
    pub at_upper: Vec<usize>,
    /// Which way led to the command.
    pub path: Path,
    /// How sure the command is.
    pub status: Status,
    /// Residual of the optimality conditions.
    pub kkt_residual: Option<f32>,
    /// Time to compute the answer, µs.
    pub solve_us: f32,
    /// Time between state and answer, µs.
    pub round_trip_us: f32,
    /// Whether the service answered in this period.
    pub answered: bool,
}
