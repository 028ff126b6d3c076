//! One cell of a sweep: a run of its scenario against a service.

use std::ops::ControlFlow;

use revprio_api::wire::Problem;
use revprio_api::{ClientError, Service};

use super::plan::Plan;
use super::table::{self, Outcome};
use crate::simulator::recording::{Recording, Value};
use crate::simulator::{CallMode, Faults, RunError, Scenario, run};

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
        Ok(recording) => Ok(finished(scenario, recording)),
        Err(error) => match outcome_word(&error) {
            Some(word) => Ok(Outcome::Failed(word, without_address(&error))),
            None => Err(error),
        },
    }
}

/// Returns the outcome of a run that ended. One in which the service was away, without a fault of the scenario, measures the service.
fn finished(scenario: &Scenario, recording: Recording) -> Outcome {
    let periods = recording.samples.len();
    let unanswered = recording.samples.iter().filter(|sample| !sample.answered).count();
    if unanswered > 0 && scenario.faults == Faults::default() {
        return Outcome::Failed("failed", format!("{unanswered} of {periods} periods without an answer"));
    }
    Outcome::Finished(Box::new(recording))
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

fn is_about_environment(problem: &Problem) -> bool {
    problem.pointer.as_ref().is_some_and(|pointer| pointer.starts_with("/environment"))
}

/// Returns the warnings of the service, and that stability is not checked if it refuses the environment.
fn warnings(scenario: &Scenario, service: &dyn Service) -> Vec<String> {
    let mut warnings = Vec::new();
    let created = match service.create_controller(&scenario.controller_in_environment()) {
        Err(ClientError::Refused { problem, .. }) if is_about_environment(&problem) => {
            warnings.push(format!("stability is not checked: {}", problem.detail));
            service.create_controller(&scenario.controller)
        }
        created => created,
    };
    if let Ok(created) = created {
        // If this fails, the service ends the idle session itself.
        let _ = service.delete_controller(&created.id);
        warnings.extend(created.warnings);
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::recording::Sample;

    /// A service that was away for some periods is no property of the cell, unless the scenario has faults.
    #[test]
    fn a_run_without_all_its_answers_has_not_finished() {
        let mut scenario = Scenario::find("stiff_wall").unwrap();
        let recording = |answered: [bool; 3]| {
            let samples = answered.map(|answered| Sample { answered, ..Sample::at_rest() }).to_vec();
            Recording { samples, ..Recording::empty() }
        };
        assert!(matches!(finished(&scenario, recording([true; 3])), Outcome::Finished(_)));
        let Outcome::Failed(word, error) = finished(&scenario, recording([true, false, true])) else { panic!() };
        assert_eq!((word, error.as_str()), ("failed", "1 of 3 periods without an answer"));
        scenario.faults.dropped = 0.1;
        assert!(matches!(finished(&scenario, recording([true, false, true])), Outcome::Finished(_)));
    }
}
