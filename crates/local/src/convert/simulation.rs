//! `POST /v1/simulations`.

use std::sync::Arc;

use revprio_api::wire;
use revprio_lab::metrics::Metrics;
use revprio_lab::simulator::{NamedScenario, Scenario, SimulationRequest};
use revprio_robot::RobotModel;

use super::checks::{Inside, Missing, Result};
use super::controller::controller;
use super::numbers::joint_list;
use super::resolve::known_robot;
use crate::error::ApiError;
use crate::robots::Robots;

/// Reads a request. Returns the checked scenario and its robot.
pub fn scenario(request: SimulationRequest, robots: &Robots) -> Result<(Scenario, Arc<RobotModel>)> {
    let mut scenario = match request.scenario {
        NamedScenario::BuiltIn(name) => built_in(&name)?,
        NamedScenario::Own(scenario) => own(*scenario, robots).inside("/scenario")?,
    };
    scenario.controller.method = request.method.unwrap_or(scenario.controller.method);
    scenario.controller.solver = request.solver.unwrap_or(scenario.controller.solver);
    let robot = known_robot(&scenario.controller.robot, robots)?;
    Ok((scenario, robot))
}

fn built_in(name: &str) -> Result<Scenario> {
    let known = Scenario::names();
    let unknown = format_args!("there is no scenario `{name}`; known: {known}; or give a whole scenario");
    Scenario::built_in(name).or_invalid("/scenario", unknown)?.map_err(|_| ApiError::internal())
}

fn own(scenario: Scenario, robots: &Robots) -> Result<Scenario> {
    scenario.check().map_err(|error| ApiError::invalid(error.pointer, error.problem))?;
    let controller = controller(&scenario.controller, robots).inside("/controller")?;
    let joints = controller.config().robot.joint_count();
    joint_list::<Vec<f64>>(&scenario.start_joint_position, joints, "/start_joint_position").map(|_| scenario)
}

/// Returns the measures of a run.
pub fn metrics_answer(metrics: &Metrics) -> wire::SimulationMetrics {
    let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
    wire::SimulationMetrics {
        rmse_force_x_n: finite(metrics.rmse_fx),
        rmse_force_y_n: finite(metrics.rmse_fy),
        overshoot_n: finite(metrics.overshoot.map(|overshoot| overshoot.newton)),
        overshoot_percent: finite(metrics.overshoot.map(|overshoot| overshoot.percent)),
        settling_time_s: finite(metrics.settling_time_s),
        final_force_n: finite(metrics.final_force),
        peak_force_n: finite(Some(metrics.peak_force)),
        first_contact_s: finite(metrics.first_contact_s),
        contacts: metrics.contacts,
        largest_joint_speed_rad_s: finite(Some(metrics.max_joint_speed)),
        least_distance_m: finite(metrics.least_distance_m),
        calls_per_second: finite(metrics.calls_per_second),
    }
}
