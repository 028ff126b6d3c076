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
use super::sessions::IDLE_TIMEOUT;
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
    Ok(Json(convert::resolve_answer(&question, &resolution, start)))
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
    let warnings = convert::warnings(&request).map_err(|_| Problem::internal())?;
    let id = app.sessions.create(request, controller)?.to_string();
    let location = [(header::LOCATION, format!("/v1/controllers/{id}"))];
    let created = wire::CreatedController { id, joints, idle_timeout_s: IDLE_TIMEOUT.as_secs(), warnings };
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
                convert::step_answer(controller, state.sequence, command, start)
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
    Json(wire::RobotList { robots: app.robots.all().iter().map(|robot| convert::robot_answer(robot)).collect() })
}

/// `GET /v1/robots/{name}`
pub async fn robot(State(app): Shared, Segment(name): Segment) -> Result<Json<wire::Robot>, Problem> {
    let robot = app.robots.get(&name).map_err(|error| convert::robots_problem(&error))?;
    Ok(Json(convert::robot_answer(&robot)))
}

/// `POST /v1/robots`
pub async fn register_robot(
    State(app): Shared,
    Body(request): Body<wire::RobotRegistration>,
) -> Result<impl IntoResponse, Problem> {
    let robot = Arc::new(convert::robot(&request)?);
    let location = [(header::LOCATION, format!("/v1/robots/{}", robot.name()))];
    let answer = convert::robot_answer(&robot);
    app.sessions.end_idle();
    app.robots.register(robot).map_err(|error| convert::robots_problem(&error))?;
    Ok((StatusCode::CREATED, location, Json(answer)))
}

/// `DELETE /v1/robots/{name}`
pub async fn delete_robot(State(app): Shared, Segment(name): Segment) -> Result<StatusCode, Problem> {
    app.robots.remove(&name).map_err(|error| convert::robots_problem(&error))?;
    Ok(StatusCode::NO_CONTENT)
}
