//! The calls that compute joint velocities.

use crate::clock::Instant;
use revprio_api::wire;
use revprio_core::resolution::Resolution;

use super::checked_stepper::CheckedStepper;
use super::convert::{self, ResolveProblem};
use super::error::ApiError;
use super::robots::Robots;
use super::solvers::solver_until;
use super::state_rules::LastState;

/// Maximum number of problems in a batch.
pub const MAX_ITEMS: usize = 10_000;

/// Number of problems that justify one more thread. Starting a thread costs as much as several problems.
pub const ITEMS_PER_THREAD: usize = 16;

/// Creates the stepper of a controller that stands at `/controller` of a stateless request.
pub fn stateless_stepper(request: &wire::Controller, robots: &Robots) -> Result<CheckedStepper, ApiError> {
    let controller = convert::controller(request, robots).map_err(|error| error.inside("/controller"))?;
    CheckedStepper::new(request, controller).map_err(|error| error.inside("/controller"))
}

/// Computes a stateless step: the memory comes with the request and returns with the answer.
pub fn stateless_step(
    stepper: &mut CheckedStepper,
    state: &wire::State,
    memory: Option<&wire::Memory>,
) -> Result<wire::StepAnswer, ApiError> {
    let start = Instant::now();
    let inside = |error: ApiError| error.inside("/state");
    let controller = stepper.controller().clone();
    let measurement = stepper.measurement(state).map_err(inside)?;
    let last = convert::last_state(memory, &controller)?;
    let mut memory = convert::memory(memory, state.sequence, &controller)?;
    let answer = stepper.step(&mut memory, last.as_ref(), state.sequence, &measurement, start);
    let mut answer = answer.map_err(|error| if error.is_about_memory() { error } else { inside(error) })?;
    let last =
        LastState { sequence: state.sequence, time_s: measurement.time_s, joint_position: measurement.joint_position };
    answer.memory = memory.map(|memory| convert::memory_answer(&controller, last, &memory));
    Ok(answer)
}

/// Resolves a problem that was read at `start`. Work that can take long ends early once it `is_abandoned`, and its answer has failed.
pub fn resolve(
    problem: &ResolveProblem,
    start: Instant,
    is_abandoned: impl Fn() -> bool + Send + 'static,
) -> Result<wire::ResolveAnswer, ApiError> {
    let mut resolution = Resolution::default();
    let mut solver = solver_until(problem.solver, is_abandoned);
    solver.solve(&problem.problem, &[], &mut resolution).map_err(convert::resolution_error)?;
    Ok(convert::resolve_answer(problem, &resolution, start))
}

/// Refuses a batch that is too long.
pub fn check_batch_size(items: usize) -> Result<(), ApiError> {
    if items <= MAX_ITEMS {
        return Ok(());
    }
    Err(ApiError::invalid("/items", format!("{items} items; a batch has at most {MAX_ITEMS}")))
}

/// Returns the result of item `i` of a batch.
pub fn batch_item(i: usize, answer: Result<wire::ResolveAnswer, ApiError>) -> wire::BatchItem {
    match answer {
        Ok(answer) => wire::BatchItem::Answer(Box::new(answer)),
        Err(error) => wire::BatchItem::Problem(error.inside(&format!("/items/{i}")).into_wire()),
    }
}
