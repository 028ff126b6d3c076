//! A controller together with the memory that it computes in.

use std::sync::Arc;

use super::workspace::Workspace;
use super::{Command, Controller, Measurement, Memory, StepError};

/// A controller that is ready for its next period.
///
/// It owns everything that a step overwrites, so that after the first few periods a step allocates nothing. Exceptions:
/// levels that Clarabel solves, tasks that limits scale, names of active inequalities, and vectors of more than 12 entries
/// (joints, rows of all tasks together, limits).
pub struct Stepper {
    controller: Arc<Controller>,
    workspace: Workspace,
}

impl Stepper {
    /// Allocates the memory of a controller.
    pub fn new(controller: impl Into<Arc<Controller>>) -> Result<Self, StepError> {
        let controller = controller.into();
        let workspace = Workspace::new(controller.config())?;
        Ok(Self { controller, workspace })
    }

    /// The controller. It never changes, so that others can share it.
    pub fn controller(&self) -> &Arc<Controller> {
        &self.controller
    }

    /// Turns a measurement into a command. `memory` is that of the step before, `None` at the first step; it is replaced
    /// by the memory of this step.
    ///
    /// The same controller, memory and measurement give the same command to the last bit, whatever the stepper did before.
    /// On an error the memory stays as it was.
    pub fn step(&mut self, memory: &mut Option<Memory>, measurement: &Measurement) -> Result<&Command, StepError> {
        self.controller.step(&mut self.workspace, memory, measurement)
    }
}
