//! The calls of a control loop, shared by the HTTP handlers and by runs in this process.

use std::time::Instant;

use revprio_api::wire;
use revprio_core::controller::Stepper;

use super::convert;
use super::error::ApiError;
use super::robots::Robots;
use super::sessions::Sessions;

/// Opens a session for a controller.
pub fn open_session(
    request: wire::Controller,
    robots: &Robots,
    sessions: &Sessions,
) -> Result<wire::CreatedController, ApiError> {
    let controller = convert::controller(&request, robots)?;
    let joints = controller.config().robot.joints().iter().map(|joint| joint.name.clone()).collect();
    let warnings = convert::warnings(&request)?;
    let id = sessions.create(request, controller)?.to_string();
    Ok(wire::CreatedController { id, joints, idle_timeout_s: sessions.idle_timeout().as_secs(), warnings })
}

/// Creates the stepper of a controller that stands at `/controller` of a stateless request.
pub fn stateless_stepper(controller: &wire::Controller, robots: &Robots) -> Result<Stepper, ApiError> {
    let controller = convert::controller(controller, robots).map_err(|error| error.inside("/controller"))?;
    Stepper::new(controller).map_err(|error| convert::step_error(&error, "/state"))
}

/// Computes a stateless step: the memory comes with the request and returns with the answer.
pub fn stateless_step(
    stepper: &mut Stepper,
    state: &wire::State,
    memory: Option<&wire::Memory>,
) -> Result<wire::StepAnswer, ApiError> {
    let start = Instant::now();
    let controller = stepper.controller().clone();
    let measurement = convert::measurement(state, &controller).map_err(|error| error.inside("/state"))?;
    let mut memory = convert::memory(memory, state.sequence, &controller)?;
    let command = stepper.step(&mut memory, &measurement);
    let command = command.map_err(|error| convert::step_error(&error, "/state"))?;
    let mut answer = convert::step_answer(&controller, state.sequence, command, start);
    answer.memory = memory.map(|memory| convert::memory_answer(&controller, state.sequence, &memory));
    Ok(answer)
}
