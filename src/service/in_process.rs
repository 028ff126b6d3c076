//! The service as function calls, for the runs that the service makes itself.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Duration;

use revprio_api::{ClientError, Service, wire};
use revprio_core::controller::Stepper;

use super::convert;
use super::error::ApiError;
use super::metrics::Metrics;
use super::robots::Robots;
use super::sessions::Sessions;
use super::step::{open_session, stateless_step};

/// Stateless controllers that are kept: two while one method replaces another.
const KEPT: usize = 2;

/// A run in this process has one session.
const MAX_SESSIONS: usize = 1;

/// Sessions of a run end with the run, not by time.
const NEVER_IDLE: Duration = Duration::MAX;

/// A service for one run. It gives the same answers as HTTP, to the last bit.
pub struct InProcess {
    robots: Robots,
    sessions: Sessions,
    /// The controllers of the last stateless steps, the latest one last.
    steppers: RefCell<Vec<(wire::Controller, Stepper)>>,
}

impl InProcess {
    /// Creates a service that knows these robots.
    pub fn new(robots: Robots) -> Self {
        let sessions = Sessions::new(MAX_SESSIONS, NEVER_IDLE, Arc::new(Metrics::new()));
        Self { robots, sessions, steppers: RefCell::default() }
    }

    fn stepper(&self, controller: &wire::Controller) -> Result<(wire::Controller, Stepper), ApiError> {
        let mut steppers = self.steppers.borrow_mut();
        if let Some(place) = steppers.iter().position(|(known, _)| known == controller) {
            return Ok(steppers.remove(place));
        }
        let checked = convert::controller(controller, &self.robots).map_err(|problem| problem.inside("/controller"))?;
        let stepper = Stepper::new(checked).map_err(|error| convert::step_problem(&error, "/state"))?;
        steppers.truncate(KEPT - 1);
        Ok((controller.clone(), stepper))
    }

    fn stateless(&self, request: &wire::StepRequest) -> Result<wire::StepAnswer, ApiError> {
        let (controller, mut stepper) = self.stepper(&request.controller)?;
        let answer = stateless_step(&mut stepper, &request.state, request.memory.as_ref());
        self.steppers.borrow_mut().push((controller, stepper));
        answer
    }
}

impl Service for InProcess {
    fn create_controller(&self, controller: &wire::Controller) -> Result<wire::CreatedController, ClientError> {
        open_session(controller.clone(), &self.robots, &self.sessions).map_err(refused)
    }

    fn step_controller(&self, id: &str, state: &wire::State) -> Result<wire::StepAnswer, ClientError> {
        self.sessions.step(id, state.clone()).map(|answered| answered.answer().clone()).map_err(refused)
    }

    fn delete_controller(&self, id: &str) -> Result<(), ClientError> {
        self.sessions.delete(id).map_err(refused)
    }

    fn step(&self, request: &wire::StepRequest) -> Result<wire::StepAnswer, ClientError> {
        self.stateless(request).map_err(refused)
    }
}

fn refused(problem: ApiError) -> ClientError {
    ClientError::Refused { url: "the service".to_owned(), problem: Box::new(problem.into_wire()) }
}
