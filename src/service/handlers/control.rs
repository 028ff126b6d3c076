//! Control periods, stateless and in sessions.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::http::{Extensions, StatusCode, header};
use axum::response::{IntoResponse, Response};
use revprio_api::wire;

use super::{Segment, Shared};
use crate::service::body::{Answer, Body, LargeAnswer};
use crate::service::checked_stepper::PreparedController;
use crate::service::error::ApiError;
use crate::service::events::{Shown, latest};
use crate::service::format::RawBody;
use crate::service::interleaving::Source;
use crate::service::ownership::{Owner, Ownership};
use crate::service::sessions::{SharedAnswer, open_session};
use crate::service::{convert, step_once, stream};

/// Time between two events for a watcher: 30 events a second are enough for display.
const WATCH_PAUSE: Duration = Duration::from_millis(33);

/// Steps a controller without a session.
///
/// One control period. The memory comes with the request, so any instance of the service can answer any call.
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
        (status = 409, description = "The sequence number is not greater than the last one: `sequence`.")
    )
)]
pub async fn step(State(app): Shared, body: RawBody) -> Result<Answer<wire::StepAnswer>, ApiError> {
    step_once::step(body, &app).await.map(Answer)
}

/// Lists the sessions.
///
/// The open sessions, the last called one first.
#[utoipa::path(
    get,
    path = "/v1/controllers",
    tag = "control",
    responses((status = 200, body = wire::SessionList, description = "The sessions."))
)]
pub async fn controllers(State(app): Shared) -> Answer<wire::SessionList> {
    Answer(app.sessions.list().await)
}

/// Opens a session.
///
/// A session is a controller whose memory stays on the service until the session is deleted or idle for too long.
#[utoipa::path(
    post,
    path = "/v1/controllers",
    tag = "control",
    request_body = wire::Controller,
    params(Ownership),
    responses(
        (
            status = 201,
            body = wire::CreatedController,
            description = "The session is open.",
            headers(("Location" = String, description = "Path of the new session."))
        )
    )
)]
pub async fn create_controller(
    State(app): Shared,
    ownership: Ownership,
    Body(request): Body<wire::Controller>,
) -> Result<impl IntoResponse, ApiError> {
    let shared = Arc::clone(&app);
    // Stability warnings take longer than a step.
    let created = app.new.run(move |_| open_session(request, ownership, &shared.robots, &shared.sessions)).await??;
    let location = [(header::LOCATION, format!("/v1/controllers/{}", created.id))];
    Ok((StatusCode::CREATED, location, Answer(created)))
}

/// Steps a session.
///
/// One control period. The same state sent again gets the same answer again, without another step.
#[utoipa::path(
    post,
    path = "/v1/controllers/{id}/step",
    tag = "control",
    request_body = wire::State,
    params(Owner),
    responses(
        (status = 200, body = wire::StepAnswer, description = "Joint velocities for one period."),
        (status = 409, description = "The sequence number is not greater than the last one: `sequence`.")
    )
)]
pub async fn step_controller(
    State(app): Shared,
    Segment(id): Segment,
    owner: Owner,
    body: RawBody,
) -> Result<Answer<SharedAnswer>, ApiError> {
    // Arms wait for steps.
    let state = if body.is_large() { app.large_steps.run(move |_| body.read()).await? } else { body.read() }?;
    app.sessions.step(&id, state, &owner, Source::Request, &app.large_steps).await.map(Answer)
}

/// Streams a session.
///
/// Upgrades to WebSocket: one state per message in, one answer per state out. The AsyncAPI document describes the messages.
#[utoipa::path(
    get,
    path = "/v1/controllers/{id}/stream",
    tag = "control",
    params(Owner),
    responses(
        (status = 101, description = "The connection is a WebSocket from now on."),
        (status = 426, description = "The request is not a WebSocket handshake: `upgrade-required`.")
    )
)]
pub async fn stream_controller(
    State(app): Shared,
    Segment(id): Segment,
    owner: Owner,
    extensions: Extensions,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Result<Response, ApiError> {
    app.sessions.check_owner(&id, &owner).await?;
    let upgrade = upgrade.map_err(|_| ApiError::upgrade_required())?;
    let task = extensions.get().cloned().unwrap_or_default();
    Ok(stream::accept(upgrade, task, app, id, owner))
}

/// Watches a session.
///
/// Server-sent events `step`, at most 30 a second, with states and their answers. The data of each is a `WatchedStep`.
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
pub async fn watch_controller(State(app): Shared, Segment(id): Segment) -> Result<impl IntoResponse, ApiError> {
    let steps = app.sessions.with(&id, |_, session| Ok(session.watch())).await?;
    Ok(latest(steps, app.drain.subscribe(), WATCH_PAUSE, |step| match step {
        Some(step) => {
            let last_command = step.last_command.as_ref();
            Shown::Event("step", convert::watched_step(&step.controller, &step.state, &step.answer, last_command))
        }
        None => Shown::Nothing,
    }))
}

/// Shows a session.
///
/// Controller, last sequence number and counters.
#[utoipa::path(
    get,
    path = "/v1/controllers/{id}",
    tag = "control",
    responses((status = 200, body = wire::SessionStatus, description = "The session."))
)]
pub async fn show_controller(
    State(app): Shared,
    Segment(id): Segment,
) -> Result<LargeAnswer<wire::SessionStatus>, ApiError> {
    app.sessions.with(&id, |id, session| Ok(session.status(id))).await.map(LargeAnswer)
}

/// Replaces the controller of a session.
///
/// Adds, removes, reorders and changes tasks while the arm moves. No joint changes its velocity by more than its acceleration
/// limit permits, until the arm moves as the new controller requests. Robot, period and drive must stay.
#[utoipa::path(
    put,
    path = "/v1/controllers/{id}",
    tag = "control",
    request_body = wire::Controller,
    params(Owner),
    responses((status = 200, body = wire::CreatedController, description = "The next state gets the new controller."))
)]
pub async fn replace_controller(
    State(app): Shared,
    Segment(id): Segment,
    owner: Owner,
    Body(request): Body<wire::Controller>,
) -> Result<Answer<wire::CreatedController>, ApiError> {
    app.sessions.check_owner(&id, &owner).await?;
    let shared = Arc::clone(&app);
    let controller = app.new.run(move |_| PreparedController::new(request, &shared.robots)).await??;
    Box::pin(app.sessions.replace(&id, controller, &owner)).await.map(Answer)
}

/// Tares a wrench sensor of a session.
///
/// Finds the bias of the sensor from readings of an arm that rests in one posture and touches nothing. The stated payload counts, so the
/// wrench stays right in every other posture. Refused while the arm moves or the wrench is noisy.
#[utoipa::path(
    post,
    path = "/v1/controllers/{id}/tare",
    tag = "control",
    request_body = wire::TareRequest,
    params(Owner),
    responses((status = 200, body = wire::TareAnswer, description = "The next state gets the bias."))
)]
pub async fn tare_controller(
    State(app): Shared,
    Segment(id): Segment,
    owner: Owner,
    Body(request): Body<wire::TareRequest>,
) -> Result<Answer<wire::TareAnswer>, ApiError> {
    app.sessions.tare(&id, &request, &owner).await.map(Answer)
}

/// Ends a session.
///
/// Deletes its memory. A stream of it ends at its next state, which is refused with 404.
#[utoipa::path(
    delete,
    path = "/v1/controllers/{id}",
    tag = "control",
    params(Owner),
    responses((status = 204, description = "The session has ended."))
)]
pub async fn delete_controller(State(app): Shared, Segment(id): Segment, owner: Owner) -> Result<StatusCode, ApiError> {
    app.sessions.delete(&id, &owner).map(|()| StatusCode::NO_CONTENT)
}
