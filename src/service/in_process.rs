//! The service as function calls, for the simulations that the service runs itself.

use std::sync::Arc;
use std::time::Duration;

use revprio_api::{ClientError, Service, wire};

use super::error::ApiError;
use super::metrics::Metrics;
use super::ownership::{Owner, Ownership};
use super::platform::OperatingSystem;
use super::robots::Robots;
use super::sessions::{Sessions, open_session};
use super::stateless_service::StatelessService;

/// A run has one session.
const MAX_SESSIONS: usize = 1;

/// A session ends with its run, never by time.
const IDLE_TIMEOUT: Duration = Duration::MAX;

/// A service for one run in this process. Its joint velocities equal those over HTTP to the last bit.
pub struct InProcess {
    stateless: StatelessService,
    sessions: Sessions,
}

impl InProcess {
    /// Creates a service that knows these robots.
    pub fn new(robots: Robots) -> Self {
        let sessions = Sessions::new(MAX_SESSIONS, IDLE_TIMEOUT, Arc::new(Metrics::new()), Arc::new(OperatingSystem));
        Self { stateless: StatelessService::new(robots), sessions }
    }
}

impl Service for InProcess {
    fn create_controller(&self, controller: &wire::Controller) -> Result<wire::CreatedController, ClientError> {
        open_session(controller.clone(), Ownership::default(), self.stateless.robots(), &self.sessions)
            .map_err(client_error)
    }

    fn step_controller(&self, id: &str, state: &wire::State) -> Result<wire::StepAnswer, ClientError> {
        self.sessions.step_here(id, state.clone()).map(|answer| answer.answer().clone()).map_err(client_error)
    }

    fn delete_controller(&self, id: &str) -> Result<(), ClientError> {
        self.sessions.delete(id, &Owner::default()).map_err(client_error)
    }

    fn step(&self, request: &wire::StepRequest) -> Result<wire::StepAnswer, ClientError> {
        self.stateless.step(request)
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
}
