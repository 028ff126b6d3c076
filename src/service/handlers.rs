//! One function per route: extract, call, convert.

use std::sync::Arc;
use std::time::Instant;

use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::IntoResponse;

use super::app::App;
use super::body::Body;
use super::convert;
use super::problem::Problem;
use super::segment::Segment;
use crate::wire;

type Shared = State<Arc<App>>;

/// `POST /v1/resolve`
pub async fn resolve(
    State(app): Shared,
    Body(request): Body<wire::ResolveRequest>,
) -> Result<Json<wire::ResolveAnswer>, Problem> {
    let start = Instant::now();
    let question = convert::question(&request, &app.robots)?;
    let resolution = crate::resolution::resolve(&question.problem, &[]).map_err(convert::resolution_problem)?;
    let answer = convert::resolve_answer(&question, &resolution, start);
    app.metrics.solved(&answer.solver);
    Ok(Json(answer))
}

/// `POST /v1/step`
pub async fn step(
    State(app): Shared,
    Body(request): Body<wire::StepRequest>,
) -> Result<Json<wire::StepAnswer>, Problem> {
    let start = Instant::now();
    let controller = convert::controller(&request.controller, &app.robots).map_err(|p| p.inside("/controller"))?;
    let measurement = convert::measurement(&request.state, &controller).map_err(|p| p.inside("/state"))?;
    let mut memory = convert::memory(&request, &controller)?;
    let command = controller.step(&mut memory, &measurement).map_err(|e| convert::step_problem(&e, "/state"))?;
    let mut answer = convert::step_answer(&controller, request.state.sequence, &command, start);
    app.metrics.solved(&answer.solver);
    answer.memory = memory.map(|memory| convert::memory_answer(&controller, request.state.sequence, &memory));
    Ok(Json(answer))
}

/// `POST /v1/controllers`
pub async fn create_controller(
    State(app): Shared,
    Body(request): Body<wire::Controller>,
) -> Result<impl IntoResponse, Problem> {
    let controller = convert::controller(&request, &app.robots)?;
    let joints = controller.config().robot.joints().iter().map(|joint| joint.name.clone()).collect();
    let id = app.sessions.create(request, controller)?.to_string();
    let location = [(header::LOCATION, format!("/v1/controllers/{id}"))];
    let created = wire::CreatedController { id, joints, idle_timeout_s: app.config.session_idle.as_secs() };
    Ok((StatusCode::CREATED, location, Json(created)))
}

/// `POST /v1/controllers/{id}/step`
pub async fn step_controller(
    State(app): Shared,
    Segment(id): Segment,
    Body(state): Body<wire::State>,
) -> Result<Json<wire::StepAnswer>, Problem> {
    let start = Instant::now();
    app.sessions
        .with(&id, |_, session| {
            let measurement = convert::measurement(&state, &session.controller)?;
            session.answer(&state, &measurement, |controller, command| {
                let answer = convert::step_answer(controller, state.sequence, command, start);
                app.metrics.solved(&answer.solver);
                answer
            })
        })
        .map(Json)
}

/// `GET /v1/controllers/{id}`
pub async fn show_controller(State(app): Shared, Segment(id): Segment) -> Result<Json<wire::SessionStatus>, Problem> {
    app.sessions.with(&id, |id, session| Ok(session.status(id))).map(Json)
}

/// `DELETE /v1/controllers/{id}`
pub async fn delete_controller(State(app): Shared, Segment(id): Segment) -> Result<StatusCode, Problem> {
    app.sessions.delete(&id).map(|()| StatusCode::NO_CONTENT)
}

/// `POST /v1/stability`
pub async fn stability(Body(request): Body<wire::StabilityRequest>) -> Result<Json<wire::StabilityAnswer>, Problem> {
    let margin = convert::contact_loop(&request)?.margin().map_err(|_| Problem::internal())?;
    Ok(Json(convert::margin_answer(&margin)))
}

/// `GET /v1/robots`
pub async fn robots(State(app): Shared) -> Json<wire::RobotList> {
    Json(wire::RobotList { robots: app.robots.iter().map(|robot| convert::robot_answer(robot)).collect() })
}

/// `GET /v1/robots/{name}`
pub async fn robot(State(app): Shared, Segment(name): Segment) -> Result<Json<wire::Robot>, Problem> {
    match app.robots.get(&name) {
        Some(robot) => Ok(Json(convert::robot_answer(robot))),
        None => Err(Problem::not_found(format!("there is no robot `{name}`; known: {}", app.robots.names()))),
    }
}

/// `GET /readyz`
pub async fn ready(State(app): Shared) -> Result<&'static str, Problem> {
    if app.is_draining() { Err(Problem::draining()) } else { Ok("ready") }
}

/// `GET /metrics`
pub async fn metrics(State(app): Shared) -> impl IntoResponse {
    let media_type = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    ([(header::CONTENT_TYPE, media_type)], app.metrics.text(app.sessions.count(), app.connections.count()))
}
