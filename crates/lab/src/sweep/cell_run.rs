//! One cell of a sweep: a run of its scenario against a service.

use std::ops::ControlFlow;

use revprio_api::{ClientError, Service};

use super::plan::Plan;
use super::table::{self, Outcome};
use crate::simulator::recording::Value;
use crate::simulator::{CallMode, RunError, Scenario, run};

/// Runs a cell and returns its row. Errors of the cell are part of the row. An unreachable service is returned as an error.
pub fn row(plan: &Plan, index: usize, service: &dyn Service) -> Result<Vec<Value>, RunError> {
    let cell = plan.cell(index);
    let (warnings, outcome) = match plan.scenario(&cell).and_then(checked) {
        Err(problem) => (Vec::new(), Outcome::Failed("refused", problem)),
        Ok(scenario) => (warnings(&scenario, service), outcome(&scenario, service)?),
    };
    Ok(table::row(&plan.variations, &cell, &warnings, &outcome))
}

fn checked(scenario: Scenario) -> Result<Scenario, String> {
    match scenario.check() {
        Err(error) => Err(error.to_string()),
        Ok(()) => Ok(scenario),
    }
}

fn outcome(scenario: &Scenario, service: &dyn Service) -> Result<Outcome, RunError> {
    match run(scenario, service, CallMode::Session, |_| ControlFlow::Continue(())) {
        Ok(recording) => Ok(Outcome::Finished(Box::new(recording))),
        Err(error) => match outcome_word(&error) {
            Some(word) => Ok(Outcome::Failed(word, without_address(&error))),
            None => Err(error),
        },
    }
}

/// Returns the outcome of a failed run; `None` if the service cannot be reached.
fn outcome_word(error: &RunError) -> Option<&'static str> {
    match error {
        RunError::Service { source: ClientError::Refused { .. }, .. } => Some("refused"),
        RunError::Service { .. } => None,
        RunError::Diverged { .. } => Some("diverged"),
        RunError::AnswerSize { .. } | RunError::Stopped { .. } => Some("failed"),
        _ => Some("refused"),
    }
}

/// Returns the message without the address of the service, which differs from run to run.
fn without_address(error: &RunError) -> String {
    match error {
        RunError::Service { time_s, source: ClientError::Refused { problem, .. } } => {
            let pointer = problem.pointer.as_ref().map(|pointer| format!(" at {pointer}")).unwrap_or_default();
            format!("at t = {time_s} s: {}{pointer}", problem.detail)
        }
        other => other.to_string(),
    }
}

/// Returns the warnings of the service about unstable contacts.
fn warnings(scenario: &Scenario, service: &dyn Service) -> Vec<String> {
    let Ok(created) = service.create_controller(&scenario.controller_in_environment()) else { return Vec::new() };
    // If this fails, the service ends the idle session itself.
    let _ = service.delete_controller(&created.id);
    created.warnings
}
