//! A stepper that checks the states.

use std::sync::Arc;

use revprio_api::wire;
use revprio_core::controller::{Controller, Measurement, Memory, Stepper};
use tokio::time::Instant;

use super::convert::{self, LastState, StateRules};
use super::error::ApiError;

/// A controller with its workspace, and the rules for its states.
pub struct CheckedStepper {
    stepper: Stepper,
    rules: StateRules,
}

impl CheckedStepper {
    /// Creates the stepper of a controller.
    pub fn new(request: &wire::Controller, controller: Controller) -> Result<Self, ApiError> {
        let rules = StateRules::read(request)?;
        let stepper = Stepper::new(controller).map_err(|error| convert::step_error(&error))?;
        Ok(Self { stepper, rules })
    }

    /// Returns the controller.
    pub fn controller(&self) -> &Arc<Controller> {
        self.stepper.controller()
    }

    /// Reads a state and refuses one beyond the bounds of the controller.
    pub fn measurement(&self, state: &wire::State) -> Result<Measurement, ApiError> {
        let measurement = convert::measurement(state, self.controller())?;
        self.rules.check(&measurement, self.controller())?;
        Ok(measurement)
    }

    /// Computes the answer to a measurement of [`Self::measurement`], without memory.
    pub fn step(
        &mut self,
        memory: &mut Option<Memory>,
        last: Option<&LastState>,
        sequence: u64,
        measurement: &Measurement,
        start: Instant,
    ) -> Result<wire::StepAnswer, ApiError> {
        let controller = self.stepper.controller().clone();
        let command = self.stepper.step(memory, measurement).map_err(|error| convert::step_error(&error))?;
        let mut answer = convert::step_answer(&controller, &self.rules, sequence, command, start);
        self.rules.warn(&mut answer.warnings, measurement, &controller, command);
        convert::warn_about_targets(&mut answer.warnings, &controller, command);
        if let Some(last) = last {
            last.compare(&mut answer.warnings, sequence, measurement, &controller);
        }
        Ok(answer)
    }
}
