//! The service as function calls, for the simulations that the service runs itself.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Duration;

use revprio_api::{ClientError, Service, wire};

use super::checked_stepper::CheckedStepper;
use super::error::ApiError;
use super::metrics::Metrics;
use super::ownership::{Owner, Ownership};
use super::platform::OperatingSystem;
use super::robots::Robots;
use super::sessions::Sessions;
use super::step::{open_session, stateless_step, stateless_stepper};

/// Maximum number of stateless controllers that are kept: two while one method replaces another.
const MAX_STEPPERS: usize = 2;

/// A run has one session.
const MAX_SESSIONS: usize = 1;

/// A session ends with its run, never by time.
const IDLE_TIMEOUT: Duration = Duration::MAX;

/// A service for one run in this process. Its joint velocities equal those over HTTP to the last bit.
pub struct InProcess {
    robots: Robots,
    sessions: Sessions,
    /// The controllers of the last stateless steps, the last used one at the end.
    steppers: RefCell<Vec<(wire::Controller, CheckedStepper)>>,
}

impl InProcess {
    /// Creates a service that knows these robots.
    pub fn new(robots: Robots) -> Self {
        let sessions = Sessions::new(MAX_SESSIONS, IDLE_TIMEOUT, Arc::new(Metrics::new()), Arc::new(OperatingSystem));
        Self { robots, sessions, steppers: RefCell::default() }
    }

    /// Removes the stepper of this controller from the kept ones, or creates a new one.
    fn take_stepper(&self, controller: &wire::Controller) -> Result<(wire::Controller, CheckedStepper), ApiError> {
        let mut steppers = self.steppers.borrow_mut();
        if let Some(index) = steppers.iter().position(|(known, _)| known == controller) {
            return Ok(steppers.remove(index));
        }
        let stepper = stateless_stepper(controller, &self.robots)?;
        if steppers.len() == MAX_STEPPERS {
            steppers.remove(0);
        }
        Ok((controller.clone(), stepper))
    }

    fn stateless(&self, request: &wire::StepRequest) -> Result<wire::StepAnswer, ApiError> {
        let (controller, mut stepper) = self.take_stepper(&request.controller)?;
        let answer = stateless_step(&mut stepper, &request.state, request.memory.as_ref());
        self.steppers.borrow_mut().push((controller, stepper));
        answer
    }
}

impl Service for InProcess {
    fn create_controller(&self, controller: &wire::Controller) -> Result<wire::CreatedController, ClientError> {
        open_session(controller.clone(), Ownership::default(), &self.robots, &self.sessions).map_err(client_error)
    }

    fn step_controller(&self, id: &str, state: &wire::State) -> Result<wire::StepAnswer, ClientError> {
        self.sessions.step_here(id, state.clone()).map(|answer| answer.answer().clone()).map_err(client_error)
    }

    fn delete_controller(&self, id: &str) -> Result<(), ClientError> {
        self.sessions.delete(id, &Owner::default()).map_err(client_error)
    }

    fn step(&self, request: &wire::StepRequest) -> Result<wire::StepAnswer, ClientError> {
        self.stateless(request).map_err(client_error)
    }
}

fn client_error(error: ApiError) -> ClientError {
    ClientError::Refused { url: "the service".to_owned(), problem: Box::new(error.into_wire()) }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use revprio_api::Client;
    use revprio_lab::simulator::{CallMode, Scenario, run};

    use super::*;
    use crate::service::{AppState, RunningServer, router};

    /// Returns the joint velocities of all periods, as bits.
    fn joint_velocities(scenario: &Scenario, service: &dyn Service, mode: CallMode) -> Vec<Vec<u64>> {
        let recording = run(scenario, service, mode, |_| ControlFlow::Continue(())).unwrap();
        let bits = |values: &Vec<f64>| values.iter().map(|value| value.to_bits()).collect();
        recording.samples.iter().map(|sample| bits(&sample.joint_velocity)).collect()
    }

    #[test]
    fn joint_velocities_equal_those_over_http_to_the_last_bit() {
        let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
        let over_http = Client::new(&server.url());
        let mut scenario = Scenario::find("stiff_wall_singular").unwrap();
        scenario.duration_s = 0.45;
        for (solver, mode) in [
            (wire::Solver::Auto, CallMode::Session),
            (wire::Solver::Qp, CallMode::Session),
            (wire::Solver::ClosedForm, CallMode::Session),
            (wire::Solver::Auto, CallMode::Stateless),
            (wire::Solver::Qp, CallMode::Stateless),
        ] {
            scenario.controller.solver = solver;
            let (sent, answered) = (over_http.requests(), server.answered());
            let in_process = joint_velocities(&scenario, &InProcess::new(Robots::built_in()), mode);
            assert!(in_process.len() == 450 && in_process.iter().flatten().any(|bits| *bits != 0));
            assert_eq!((over_http.requests(), server.answered()), (sent, answered));
            assert!(in_process == joint_velocities(&scenario, &over_http, mode), "{solver} {mode:?}");
            assert!(over_http.requests() >= sent + 450 && server.answered() >= answered + 450);
        }
    }

    #[test]
    fn the_last_used_steppers_are_kept() {
        let service = InProcess::new(Robots::built_in());
        let example: wire::StepRequest = serde_json::from_str(include_str!("../../api/examples/step.json")).unwrap();
        let step = |period_s: f64| {
            let controller = wire::Controller { period_s, ..example.controller.clone() };
            service.step(&wire::StepRequest { controller, ..example.clone() }).unwrap();
        };
        [0.001, 0.002, 0.003].into_iter().for_each(step);
        let kept: Vec<f64> = service.steppers.borrow().iter().map(|(controller, _)| controller.period_s).collect();
        assert_eq!(kept, [0.002, 0.003]);
    }
}
