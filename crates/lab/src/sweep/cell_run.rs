//! One cell of a sweep: a run of its scenario against a service.

use std::ops::ControlFlow;

use revprio_api::{ClientError, Service};

use super::plan::Plan;
use super::table::{self, Outcome};
use crate::simulator::recording::Value;
use crate::simulator::{CallMode, RunError, Scenario, run};

/// The row of a cell. Whatever goes wrong in it stands in its row; but a service that cannot be reached at all is no
/// property of the cell.
pub fn row(plan: &Plan, index: usize, service: &dyn Service) -> Result<Vec<Value>, RunError> {
    let cell = plan.cell(index);
    let (warnings, outcome) = match plan.scenario(&cell).and_then(sound) {
        Err(problem) => (Vec::new(), Outcome::Failed("refused", problem)),
        Ok(scenario) => (warnings(&scenario, service), outcome(&scenario, service)?),
    };
    Ok(table::row(&plan.variations, &cell, &warnings, &outcome))
}

fn sound(scenario: Scenario) -> Result<Scenario, String> {
    match scenario.flaw() {
        Some(flaw) => Err(flaw.to_string()),
        None => Ok(scenario),
    }
}

fn outcome(scenario: &Scenario, service: &dyn Service) -> Result<Outcome, RunError> {
    let word = match run(scenario, service, CallMode::Session, |_| ControlFlow::Continue(())) {
        Ok(recording) => return Ok(Outcome::Finished(Box::new(recording))),
        Err(error) => (kind(&error), error),
    };
    match word {
        (Some(word), error) => Ok(Outcome::Failed(word, without_address(&error))),
        (None, error) => Err(error),
    }
}

/// How the run ended, in a word; `None` where the service is not there.
fn kind(error: &RunError) -> Option<&'static str> {
    match error {
        RunError::Service { source: ClientError::Refused { .. }, .. } => Some("refused"),
        RunError::Service { .. } => None,
        RunError::Diverged { .. } => Some("diverged"),
        RunError::AnswerSize { .. } | RunError::Stopped { .. } => Some("failed"),
        _ => Some("refused"),
    }
}

/// The message without the address of the service, which differs from run to run.
fn without_address(error: &RunError) -> String {
    match error {
        RunError::Service { time_s, source: ClientError::Refused { problem, .. } } => {
            let pointer = problem.pointer.as_ref().map(|pointer| format!(" at {pointer}")).unwrap_or_default();
            format!("at t = {time_s} s: {}{pointer}", problem.detail)
        }
        other => other.to_string(),
    }
}

/// What the service warns of: contacts that would bounce for ever.
fn warnings(scenario: &Scenario, service: &dyn Service) -> Vec<String> {
    let Ok(created) = service.create_controller(&scenario.controller_in_environment()) else { return Vec::new() };
    // If that fails, the service ends it by itself.
    let _ = service.delete_controller(&created.id);
    created.warnings
}
