//! `GET /v1/simulations/{id}`: the state and the metrics of a run of the built-in simulator.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Method, Solver, defaults};

/// The pace of an interactive run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Interactive {
    /// Simulated seconds per second of real time, if the machine is fast enough. Set less than 1 to watch a contact;
    /// default 1.
    #[serde(default = "defaults::one")]
    pub speed: f64,
    /// Whether the run starts paused, to step it with `step`; default `false`.
    #[serde(default)]
    pub paused: bool,
}

/// A run of a scenario.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Simulation {
    /// Identifier of the run, part of its address.
    pub id: String,
    /// Name of the scenario.
    pub scenario: String,
    /// Resolution method.
    pub method: Method,
    /// Solver.
    pub solver: Solver,
    /// Number of control periods of the whole run.
    pub periods: u64,
    /// State of the run.
    pub state: SimulationState,
    /// Finished fraction of the run, 0 to 1.
    pub progress: f64,
    /// Reason of the failure; only if the run failed.
    #[schema(example = "the service refused a state: a wrench is needed")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Pace of the run; only if it is interactive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interactive: Option<Interactive>,
    /// Metrics of the run; only when it is finished.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metrics: Option<SimulationMetrics>,
}

/// The state of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SimulationState {
    /// Waiting for other runs.
    Queued,
    /// Running.
    Running,
    /// Finished, with a trace.
    Finished,
    /// Ended early by an error; see `error`.
    Failed,
    /// Ended early by `DELETE`.
    Cancelled,
}

/// The metrics of a run; `null` if one is not defined. "In contact" is touching a wall or, without a wall, measuring a
/// force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SimulationMetrics {
    /// Root mean square of F_x − F_d,x, N; from 5 s in runs longer than 10 s, otherwise from the first contact.
    pub rmse_force_x_n: Option<f64>,
    /// Root mean square of F_y − F_d,y, N, over the same time.
    pub rmse_force_y_n: Option<f64>,
    /// Maximum excess of F_x over its target, N.
    pub overshoot_n: Option<f64>,
    /// Maximum excess of F_x over its target, % of the target.
    pub overshoot_percent: Option<f64>,
    /// Time from which F_x stays within 5 % of its target, s.
    pub settling_time_s: Option<f64>,
    /// F_x at the end, N.
    pub final_force_n: Option<f64>,
    /// Maximum F_x, N.
    pub peak_force_n: Option<f64>,
    /// Time of the first contact, s.
    pub first_contact_s: Option<f64>,
    /// Number of separate intervals in contact.
    pub contacts: usize,
    /// Maximum joint speed, rad/s.
    pub largest_joint_speed_rad_s: Option<f64>,
    /// Least distance of the pairs of shapes that the controller watches, m; `null` without such a pair.
    #[serde(default)]
    pub least_distance_m: Option<f64>,
    /// Control periods per second of real time.
    pub calls_per_second: Option<f64>,
}
