//! `GET /v1/simulations/{id}`: how far a run of the built-in simulator is, and what came of it.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Interactive, Method, Solver};

/// A run of a scenario.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Simulation {
    /// Name of the run, part of its address.
    pub id: String,
    /// Name of the scenario.
    pub scenario: String,
    /// How priorities are understood.
    pub method: Method,
    /// How each period's problem is solved.
    pub solver: Solver,
    /// Control periods of the whole run.
    pub periods: u64,
    /// What it is doing.
    pub state: SimulationState,
    /// Part of the run that is done, 0 to 1.
    pub progress: f64,
    /// Why it failed.
    #[schema(example = "the service refused a state: a wrench is needed")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// How it is paced, if it is interactive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interactive: Option<Interactive>,
    /// Measures of the run, once it is finished.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub metrics: Option<SimulationMetrics>,
}

/// What a run is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SimulationState {
    /// Others come first.
    Queued,
    /// At work.
    Running,
    /// Done; there is a trace.
    Finished,
    /// Ended early; `error` says why.
    Failed,
    /// Ended early by `DELETE`.
    Cancelled,
}

/// Measures of a run; `null` where one has no meaning. In contact: touching a wall or, without one, feeling a force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SimulationMetrics {
    /// Root mean square of F_x − F_d,x, N; from 5 s on in runs longer than 10 s, else from the first contact on.
    pub rmse_force_x_n: Option<f64>,
    /// The same for y, N.
    pub rmse_force_y_n: Option<f64>,
    /// Largest excess of F_x over its target, N.
    pub overshoot_n: Option<f64>,
    /// The same as a percentage of the target.
    pub overshoot_percent: Option<f64>,
    /// Time from which F_x stays within 5 % of its target, s.
    pub settling_time_s: Option<f64>,
    /// F_x in the end, N.
    pub final_force_n: Option<f64>,
    /// Largest F_x, N.
    pub peak_force_n: Option<f64>,
    /// Time of the first contact, s.
    pub first_contact_s: Option<f64>,
    /// Separate intervals in contact.
    pub contacts: usize,
    /// Largest joint speed, rad/s.
    pub largest_joint_speed_rad_s: Option<f64>,
    /// Control periods per second of real time.
    pub calls_per_second: Option<f64>,
}
