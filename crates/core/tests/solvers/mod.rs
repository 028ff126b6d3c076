//! All solvers by name.
#![allow(dead_code)]

use std::sync::Arc;

use revprio_core::controller::{Controller, Stepper};
use revprio_core::resolution::{ActiveSet, Problem, ProblemError, Resolution, Resolver, Solve, Solver};
use revprio_reference::{ClosedForm, Qp};

/// Returns the solver of this name.
pub fn solver(name: Solver) -> Box<dyn Solve> {
    match name {
        Solver::Auto => Box::<Resolver>::default(),
        Solver::Qp => Box::<Qp>::default(),
        Solver::ClosedForm => Box::new(ClosedForm),
    }
}

/// Solves a problem with a new solver.
pub fn resolve_with(name: Solver, problem: &Problem, guess: &[ActiveSet]) -> Result<Resolution, ProblemError> {
    let mut answer = Resolution::default();
    solver(name).solve(problem, guess, &mut answer)?;
    Ok(answer)
}

/// Returns a stepper with the solver that the controller names.
pub fn stepper(controller: impl Into<Arc<Controller>>) -> Stepper {
    let controller = controller.into();
    let solver = solver(controller.config().solver);
    Stepper::with_solver(controller, solver).unwrap()
}
