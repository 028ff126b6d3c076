//! The answer about a simulation, and the largest one.

use revprio_api::wire::Simulation;
use revprio_lab::simulator::Scenario;

use super::progress::Progress;
use super::run_control::RunControl;
use crate::error::ApiError;

/// Maximum number of control periods of a simulation.
const MAX_PERIODS: u64 = 100_000;

/// Maximum number of integration steps of a simulation: control periods times substeps.
const MAX_STEPS: u64 = 1_000_000;

/// Refuses a simulation that is too long.
pub fn check_size(scenario: &Scenario) -> Result<(), ApiError> {
    let periods = scenario.cycles();
    if periods > MAX_PERIODS {
        let detail = format!("{periods} control periods; a simulation has at most {MAX_PERIODS}");
        return Err(ApiError::invalid("/scenario/duration_s", detail));
    }
    let steps = periods * scenario.substeps as u64;
    if steps > MAX_STEPS {
        let detail = format!("{steps} steps (control periods times substeps); a simulation has at most {MAX_STEPS}");
        return Err(ApiError::invalid("/scenario/substeps", detail));
    }
    Ok(())
}

/// Returns the answer to `GET` for this progress. A run with a `run_control` is interactive.
pub fn status(id: &str, scenario: &Scenario, run_control: Option<&RunControl>, progress: &Progress) -> Simulation {
    let stated = (scenario.controller.method, scenario.controller.solver);
    let (method, solver) = run_control.map_or(stated, RunControl::method_and_solver);
    Simulation {
        id: id.to_owned(),
        scenario: scenario.name.clone(),
        method,
        solver,
        interactive: run_control.map(RunControl::pace),
        periods: scenario.cycles(),
        state: progress.state,
        progress: progress.done as f64 / scenario.cycles() as f64,
        error: progress.error.clone(),
        metrics: progress.result.as_ref().map(|result| result.metrics),
    }
}
