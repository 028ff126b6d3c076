//! The solvers by name.

use std::sync::Arc;

use revprio_core::controller::{Controller, StepError, Stepper};
use revprio_core::resolution::{Resolver, Solve, Solver};
use revprio_reference::{ClosedForm, Qp};

/// Returns a new solver.
pub fn solver(name: Solver) -> Box<dyn Solve> {
    match name {
        Solver::Auto => Box::<Resolver>::default(),
        Solver::Qp => Box::<Qp>::default(),
        Solver::ClosedForm => Box::new(ClosedForm),
    }
}

/// Returns a new solver that gives up once `is_abandoned`, if its problems can take long.
pub fn solver_until(name: Solver, is_abandoned: impl Fn() -> bool + Send + 'static) -> Box<dyn Solve> {
    match name {
        Solver::Qp => Box::new(Qp::until(is_abandoned)),
        Solver::Auto | Solver::ClosedForm => solver(name),
    }
}

/// Returns the stepper of a controller, with the solver that its configuration names.
pub fn stepper(controller: impl Into<Arc<Controller>>) -> Result<Stepper, StepError> {
    let controller = controller.into();
    let solver = solver(controller.config().solver);
    Stepper::with_solver(controller, solver)
}
