//! Control periods, with the memory in the request or in a session.

use std::time::{Duration, Instant};

use axum::extract::State;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use revprio_api::wire;

use super::Shared;
use crate::service::body::{Answer, Body, Unread};
use crate::service::drain::Draining;
use crate::service::events::{Shown, latest};
use crate::service::problem::Problem;
use crate::service::recent::{StepCall, Stepper};
use crate::service::segment::Segment;
use crate::service::sessions::Answered;
use crate::service::{convert, stream};

/// Between two periods that are shown to a watcher: 30 a second, as often as an eye needs.
const WATCH_PAUSE: Duration = Duration::from_millis(33);

/// Steps a controller without a session.
///
/// One control period; the memory travels with the request, so that any replica answers any call.
#[utoipa::path(
    post,
    path = "/v1/step",
    tag = "control",
    request_body = wire::StepRequest,
    responses(
        (
            status = 200,
            body = wire::StepAnswer,
            description = "Joint velocities for one period, and the memory for the next request."
        ),
        (status = 409, description = "The sequence number does not grow: `sequence`.")
    )
)]
pub async fn step(State(app): Shared, body: Unread) -> Result<Answer<wire::StepAnswer>, Problem> {
    let StepCall { mut stepper, state, memory } = app.recent.read(&body, &app.robots)?;
    let start = Instant::now();
    let Stepper { controller, workspace, .. } = &mut *stepper;
    let measurement = convert::measurement(&state, controller).map_err(|p| p.inside("/state"))?;
    let mut memory = convert::memory(memory.as_ref(), state.sequence, controller)?;
    let command = controller.step_in(workspace, &mut memory, &measurement);
    let command = command.map_err(|e| convert::step_problem(&e, "/state"))?;
    let mut answer = convert::step_answer(controller, state.sequence, command, start);
    app.metrics.solved(&answer.solver);
    answer.memory = memory.map(|memory| convert::memory_answer(controller, state.sequence, &memory));
    app.recent.keep(stepper);
    Ok(Answer(answer))
}

/// Lists the sessions.
///
/// Those that are open, the one that stepped last first.
#[utoipa::path(
    get,
    path = "/v1/controllers",
    tag = "control",
    responses((status = 200, body = wire::SessionList, description = "The sessions."))
)]
pub async fn controllers(State(app): Shared) -> Answer<wire::SessionList> {
    Answer(app.sessions.list())
}

/// Opens a session.
///
/// A controller that keeps its memory on the service until it is deleted or idle for too long.
#[utoipa::path(
    post,
    path = "/v1/controllers",
    tag = "control",
    request_body = wire::Controller,
    responses(
        (
            status = 201,
            body = wire::CreatedController,
            description = "The session is open.",
            headers(("Location" = String, description = "Address of what was made."))
        )
    )
)]
pub async fn create_controller(
    State(app): Shared,
    Body(request): Body<wire::Controller>,
) -> Result<impl IntoResponse, Problem> {
    let controller = convert::controller(&request, &app.robots)?;
    let joints = controller.config().robot.joints().iter().map(|joint| joint.name.clone()).collect();
    let warnings = convert::warnings(&request)?;
    let id = app.sessions.create(request, controller)?.to_string();
    let location = [(header::LOCATION, format!("/v1/controllers/{id}"))];
    let created = wire::CreatedController { id, joints, idle_timeout_s: app.config.session_idle.as_secs(), warnings };
    Ok((StatusCode::CREATED, location, Answer(created)))
}

/// Steps a session.
///
/// One control period. The same state sent again is answered again, without another step.
#[utoipa::path(
    post,
    path = "/v1/controllers/{id}/step",
    tag = "control",
    request_body = wire::State,
    responses(
        (status = 200, body = wire::StepAnswer, description = "Joint velocities for one period."),
        (status = 409, description = "The sequence number does not grow: `sequence`.")
    )
)]
pub async fn step_controller(
    State(app): Shared,
    Segment(id): Segment,
    Body(state): Body<wire::State>,
) -> Result<Answer<Answered>, Problem> {
    app.sessions.step(&id, state).map(Answer)
}

/// Streams a session.
///
/// Upgrades to WebSocket: one state per message in, one answer per state out. The AsyncAPI document describes it.
#[utoipa::path(
    get,
    path = "/v1/controllers/{id}/stream",
    tag = "control",
    responses(
        (status = 101, description = "The connection speaks WebSocket from here on."),
        (status = 426, description = "The request asks for no WebSocket: `upgrade-required`.")
    )
)]
pub async fn stream_controller(
    State(app): Shared,
    Segment(id): Segment,
    draining: Draining,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Result<Response, Problem> {
    app.sessions.with(&id, |_, _| Ok(()))?;
    let upgrade = upgrade.map_err(|_| Problem::upgrade_required())?;
    Ok(stream::accept(upgrade, app, id, draining))
}

/// Watches a session.
///
/// States with their answers as server-sent events `step`, 30 a second at most; the data of each is a `WatchedStep`.
#[utoipa::path(
    get,
    path = "/v1/controllers/{id}/watch",
    tag = "control",
    responses(
        (
            status = 200,
            body = String,
            content_type = "text/event-stream",
            description = "Events until the session or the service ends."
        )
    )
)]
pub async fn watch_controller(
    State(app): Shared,
    Segment(id): Segment,
    draining: Draining,
) -> Result<impl IntoResponse, Problem> {
    let (steps, controller) = app.sessions.with(&id, |_, session| Ok((session.watch(), session.controller.clone())))?;
    Ok(latest(steps, draining, WATCH_PAUSE, move |step| match step {
        Some(step) => Shown::Event("step", convert::watched_step(&controller, step)),
        None => Shown::Nothing,
    }))
}

/// Shows a session.
///
/// Configuration, last sequence number, counters.
#[utoipa::path(
    get,
    path = "/v1/controllers/{id}",
    tag = "control",
    responses((status = 200, body = wire::SessionStatus, description = "The session."))
)]
pub async fn show_controller(State(app): Shared, Segment(id): Segment) -> Result<Answer<wire::SessionStatus>, Problem> {
    app.sessions.with(&id, |id, session| Ok(session.status(id))).map(Answer)
}

/// Ends a session.
///
/// Its memory is forgotten and its streams are closed.
#[utoipa::path(
    delete,
    path = "/v1/controllers/{id}",
    tag = "control",
    responses((status = 204, description = "The session has ended."))
)]
pub async fn delete_controller(State(app): Shared, Segment(id): Segment) -> Result<StatusCode, Problem> {
    app.sessions.delete(&id).map(|()| StatusCode::NO_CONTENT)
}
