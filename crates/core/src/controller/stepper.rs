//! A controller with its workspace: the values that each step overwrites.

use std::sync::Arc;

use super::config::Controller;
use super::period::Period;
use super::state::{Command, Measurement, Memory, StepError};
use crate::resolution::{Resolver, Solve, Solver};

/// A controller with the workspace that its steps overwrite.
///
/// Memory is allocated when it is first needed, for example in the first step, and where the first limit is active or the
/// first task is damped. Once a stepper has met what its periods contain, a step allocates nothing. Exceptions, with the most
/// allocations of a period that `tests/allocations/exceptions.rs` allows:
///
/// | period | allocations |
/// |---|---|
/// | a state that comes late | 22 |
/// | a scaled task that limits slow down | 28 |
/// | bounds of a task, or inequalities, that cannot be kept together | 30; jerk limits before a plane: 54 |
/// | a task of 14 rows; up to 12 have a place without allocation | 19 |
pub struct Stepper {
    controller: Arc<Controller>,
    period: Period,
}

impl Stepper {
    /// Allocates the workspace of a controller with the solver `auto`.
    pub fn new(controller: impl Into<Arc<Controller>>) -> Result<Self, StepError> {
        let controller = controller.into();
        if controller.config().solver != Solver::Auto {
            return Err(StepError::Solver);
        }
        Self::with_solver(controller, Box::<Resolver>::default())
    }

    /// Allocates the workspace of a controller with the solver that its configuration names.
    pub fn with_solver(controller: impl Into<Arc<Controller>>, solver: Box<dyn Solve>) -> Result<Self, StepError> {
        let controller = controller.into();
        if solver.keeps_limits() != (controller.config().solver != Solver::ClosedForm) {
            return Err(StepError::Solver);
        }
        let period = Period::new(controller.config(), solver)?;
        Ok(Self { controller, period })
    }

    /// Returns the controller. It never changes, so other threads may share it.
    pub fn controller(&self) -> &Arc<Controller> {
        &self.controller
    }

    /// Computes the command for a measurement.
    ///
    /// `memory` is the memory of the previous step, `None` at the first step. The step replaces it by its own memory.
    /// On an error it stays unchanged.
    ///
    /// The same controller, memory and measurement give the same command to the last bit, whatever the stepper computed
    /// before.
    pub fn step(&mut self, memory: &mut Option<Memory>, measurement: &Measurement) -> Result<&Command, StepError> {
        self.period.run(self.controller.config(), memory, measurement)
    }

    /// Exchanges the command of the last step with `other`, whose content the next step overwrites.
    ///
    /// A caller that keeps commands can so return those that it does not need any more: a clone would allocate. `other`
    /// becomes a clone if it is not a command of this controller.
    pub fn exchange_command(&mut self, other: &mut Command) {
        let command = self.period.command();
        if other.has_size_of(command) {
            std::mem::swap(command, other);
        } else {
            other.clone_from(command);
        }
    }
}
