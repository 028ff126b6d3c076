//! Control periods, with the memory in the request or in a session.

use std::time::Duration;

use axum::extract::State;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use revprio_api::wire;

use super::Shared;
use crate::service::body::{Answer, Body, Unread};
use crate::service::drain::Draining;
use crate::service::error::ApiError;
use crate::service::events::{Shown, latest};
use crate::service::recent::StepCall;
use crate::service::segment::Segment;
use crate::service::sessions::Answered;
use crate::service::step::{open_session, stateless_step};
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
pub async fn step(State(app): Shared, body: Unread) -> Result<Answer<wire::StepAnswer>, ApiError> {
    let StepCall { mut kept, state, memory } = app.recent.read(&body, &app.robots)?;
    let answer = stateless_step(&mut kept.stepper, &state, memory.as_ref())?;
    app.metrics.solved(&answer.solver);
    app.recent.keep(kept);
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
) -> Result<impl IntoResponse, ApiError> {
    let created = open_session(request, &app.robots, &app.sessions)?;
    let location = [(header::LOCATION, format!("/v1/controllers/{}", created.id))];
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
) -> Result<Answer<Answered>, ApiError> {
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
) -> Result<Response, ApiError> {
    app.sessions.with(&id, |_, _| Ok(()))?;
    let upgrade = upgrade.map_err(|_| ApiError::upgrade_required())?;
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
) -> Result<impl IntoResponse, ApiError> {
    let (steps, controller) = app.sessions.with(&id, |_, session| Ok((session.watch(), session.controller())))?;
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
pub async fn show_controller(
    State(app): Shared,
    Segment(id): Segment,
) -> Result<Answer<wire::SessionStatus>, ApiError> {
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
pub async fn delete_controller(State(app): Shared, Segment(id): Segment) -> Result<StatusCode, ApiError> {
    app.sessions.delete(&id).map(|()| StatusCode::NO_CONTENT)
}
