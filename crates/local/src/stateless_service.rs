//! Stateless steps as function calls, for simulations without sessions.

use std::cell::RefCell;

use revprio_api::{ClientError, Service, wire};

use super::checked_stepper::CheckedStepper;
use super::error::ApiError;
use super::robots::Robots;
use super::step::{stateless_step, stateless_stepper};

/// Maximum number of stateless controllers that are kept: two while one method replaces another.
const MAX_STEPPERS: usize = 2;

/// A service that knows some robots and has no sessions.
pub struct StatelessService {
    robots: Robots,
    /// The controllers of the last steps, the last used one at the end.
    steppers: RefCell<Vec<(wire::Controller, CheckedStepper)>>,
}

impl StatelessService {
    /// Creates a service that knows these robots.
    pub fn new(robots: Robots) -> Self {
        Self { robots, steppers: RefCell::default() }
    }

    /// Returns the robots.
    pub fn robots(&self) -> &Robots {
        &self.robots
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

impl Service for StatelessService {
    fn create_controller(&self, _: &wire::Controller) -> Result<wire::CreatedController, ClientError> {
        Err(client_error(ApiError::not_found("this service has no sessions")))
    }

    fn step_controller(&self, id: &str, _: &wire::State) -> Result<wire::StepAnswer, ClientError> {
        Err(client_error(ApiError::unknown_controller(id)))
    }

    fn delete_controller(&self, id: &str) -> Result<(), ClientError> {
        Err(client_error(ApiError::unknown_controller(id)))
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
    use super::*;

    #[test]
    fn the_last_used_steppers_are_kept() {
        let service = StatelessService::new(Robots::built_in());
        let example: wire::StepRequest = serde_json::from_str(include_str!("../../../api/examples/step.json")).unwrap();
        let step = |period_s: f64| {
            let controller = wire::Controller { period_s, ..example.controller.clone() };
            service.step(&wire::StepRequest { controller, ..example.clone() }).unwrap();
        };
        [0.001, 0.002, 0.003].into_iter().for_each(step);
        let kept: Vec<f64> = service.steppers.borrow().iter().map(|(controller, _)| controller.period_s).collect();
        assert_eq!(kept, [0.002, 0.003]);
    }
}
