//! Sessions and stateless steps, for HTTP handlers and for runs within this process alike.

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

/// Computes a step whose memory travels with request and answer.
pub fn stateless_step(
    stepper: &mut Stepper,
    state: &wire::State,
    memory: Option<&wire::Memory>,
) -> Result<wire::StepAnswer, ApiError> {
    let start = Instant::now();
    let controller = stepper.controller().clone();
    let measurement = convert::measurement(state, &controller).map_err(|problem| problem.inside("/state"))?;
    let mut memory = convert::memory(memory, state.sequence, &controller)?;
    let command = stepper.step(&mut memory, &measurement);
    let command = command.map_err(|error| convert::step_problem(&error, "/state"))?;
    let mut answer = convert::step_answer(&controller, state.sequence, command, start);
    answer.memory = memory.map(|memory| convert::memory_answer(&controller, state.sequence, &memory));
    Ok(answer)
}
