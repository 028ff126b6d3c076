//! One function per route: extract, call, convert.

use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::extract::State;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};

use super::app::App;
use super::body::{Answer, Body, LargeAnswer, LargeBody};
use super::convert;
use super::drain::Draining;
use super::events::{Shown, latest};
use super::problem::Problem;
use super::segment::Segment;
use super::{resolve, simulations, stream};
use crate::simulator::{Scenario, ScenarioList, SimulationRequest};
use crate::wire;

type Shared = State<Arc<App>>;

/// Between two periods that are shown to a watcher: 30 a second, as often as an eye needs.
const WATCH_PAUSE: Duration = Duration::from_millis(33);

/// Between two events of a simulation's progress.
const PROGRESS_PAUSE: Duration = Duration::from_millis(100);

/// `POST /v1/resolve`
pub async fn resolve(
    State(app): Shared,
    Body(request): Body<wire::ResolveRequest>,
) -> Result<Answer<wire::ResolveAnswer>, Problem> {
    resolve::one(&request, &app).map(Answer)
}

/// `POST /v1/resolve/batch`
pub async fn resolve_batch(
    State(app): Shared,
    body: LargeBody<wire::BatchRequest>,
) -> Result<LargeAnswer<wire::BatchAnswer>, Problem> {
    resolve::batch(body, &app).await.map(LargeAnswer)
}

/// `POST /v1/step`
pub async fn step(
    State(app): Shared,
    Body(request): Body<wire::StepRequest>,
) -> Result<Answer<wire::StepAnswer>, Problem> {
    let start = Instant::now();
    let controller = convert::controller(&request.controller, &app.robots).map_err(|p| p.inside("/controller"))?;
    let measurement = convert::measurement(&request.state, &controller).map_err(|p| p.inside("/state"))?;
    let mut memory = convert::memory(&request, &controller)?;
    let command = controller.step(&mut memory, &measurement).map_err(|e| convert::step_problem(&e, "/state"))?;
    let mut answer = convert::step_answer(&controller, request.state.sequence, &command, start);
    app.metrics.solved(&answer.solver);
    answer.memory = memory.map(|memory| convert::memory_answer(&controller, request.state.sequence, &memory));
    Ok(Answer(answer))
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
    let created = wire::CreatedController { id, joints, idle_timeout_s: app.config.session_idle.as_secs(), warnings };
    Ok((StatusCode::CREATED, location, Answer(created)))
}

/// `POST /v1/controllers/{id}/step`
pub async fn step_controller(
    State(app): Shared,
    Segment(id): Segment,
    Body(state): Body<wire::State>,
) -> Result<Answer<wire::StepAnswer>, Problem> {
    app.sessions.step(&id, &state).map(Answer)
}

/// `GET /v1/controllers/{id}/stream`
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

/// `GET /v1/controllers/{id}/watch`
pub async fn watch_controller(
    State(app): Shared,
    Segment(id): Segment,
    draining: Draining,
) -> Result<impl IntoResponse, Problem> {
    let steps = app.sessions.with(&id, |_, session| Ok(session.watch()))?;
    Ok(latest(steps, draining, WATCH_PAUSE, |step| match step {
        Some(step) => Shown::Event("step", (**step).clone()),
        None => Shown::Nothing,
    }))
}

/// `GET /v1/controllers/{id}`
pub async fn show_controller(State(app): Shared, Segment(id): Segment) -> Result<Answer<wire::SessionStatus>, Problem> {
    app.sessions.with(&id, |id, session| Ok(session.status(id))).map(Answer)
}

/// `DELETE /v1/controllers/{id}`
pub async fn delete_controller(State(app): Shared, Segment(id): Segment) -> Result<StatusCode, Problem> {
    app.sessions.delete(&id).map(|()| StatusCode::NO_CONTENT)
}

/// `POST /v1/stability`
pub async fn stability(
    State(app): Shared,
    Body(request): Body<wire::StabilityRequest>,
) -> Result<Answer<wire::StabilityAnswer>, Problem> {
    let contact = convert::contact_loop(&request)?;
    let margin = app.margins.run("stability margins", move |_| contact.margin()).await?;
    Ok(Answer(convert::margin_answer(&margin.map_err(|_| Problem::internal())?)))
}

/// `GET /v1/robots`
pub async fn robots(State(app): Shared) -> Answer<wire::RobotList> {
    Answer(wire::RobotList { robots: app.robots.all().iter().map(|robot| convert::robot_answer(robot)).collect() })
}

/// `GET /v1/robots/{name}`
pub async fn robot(State(app): Shared, Segment(name): Segment) -> Result<Answer<wire::Robot>, Problem> {
    let robot = app.robots.get(&name).map_err(|error| convert::robots_problem(&error))?;
    Ok(Answer(convert::robot_answer(&robot)))
}

/// `POST /v1/robots`
pub async fn register_robot(
    State(app): Shared,
    Body(request): Body<wire::RobotRegistration>,
) -> Result<impl IntoResponse, Problem> {
    let robot = Arc::new(convert::robot(&request)?);
    let location = [(header::LOCATION, format!("/v1/robots/{}", robot.name()))];
    let answer = convert::robot_answer(&robot);
    app.sessions.let_go();
    app.robots.register(robot).map_err(|error| convert::robots_problem(&error))?;
    Ok((StatusCode::CREATED, location, Answer(answer)))
}

/// `DELETE /v1/robots/{name}`
pub async fn delete_robot(State(app): Shared, Segment(name): Segment) -> Result<StatusCode, Problem> {
    app.robots.remove(&name).map_err(|error| convert::robots_problem(&error))?;
    Ok(StatusCode::NO_CONTENT)
}

/// `POST /v1/kinematics`
pub async fn kinematics(
    State(app): Shared,
    Body(request): Body<wire::KinematicsRequest>,
) -> Result<Answer<wire::KinematicsAnswer>, Problem> {
    convert::kinematics(&request, &app.robots).map(Answer)
}

/// `GET /v1/scenarios`
pub async fn scenarios() -> Result<LargeAnswer<ScenarioList>, Problem> {
    ScenarioList::built_in().map(LargeAnswer).map_err(|_| Problem::internal())
}

/// `GET /v1/scenarios/{name}`
pub async fn scenario(Segment(name): Segment) -> Result<Answer<Scenario>, Problem> {
    match Scenario::built_in(&name) {
        Some(scenario) => scenario.map(Answer).map_err(|_| Problem::internal()),
        None => Err(Problem::not_found(format!("there is no scenario `{name}`; known: {}", Scenario::names()))),
    }
}

/// `POST /v1/simulations`
pub async fn create_simulation(
    State(app): Shared,
    Body(request): Body<SimulationRequest>,
) -> Result<impl IntoResponse, Problem> {
    let (scenario, robot) = convert::scenario(request, &app.robots)?;
    let status = app.simulations.create(scenario, robot)?.status();
    let location = [(header::LOCATION, format!("/v1/simulations/{}", status.id))];
    Ok((StatusCode::ACCEPTED, location, Answer(status)))
}

/// `GET /v1/simulations/{id}`
pub async fn show_simulation(State(app): Shared, Segment(id): Segment) -> Result<Answer<wire::Simulation>, Problem> {
    app.simulations.get(&id).map(|job| Answer(job.status()))
}

/// `GET /v1/simulations/{id}/events`
pub async fn simulation_events(
    State(app): Shared,
    Segment(id): Segment,
    draining: Draining,
) -> Result<impl IntoResponse, Problem> {
    let job = app.simulations.get(&id)?;
    let progress = job.watch();
    Ok(latest(progress, draining, PROGRESS_PAUSE, move |progress| {
        let status = job.status_at(progress);
        if progress.has_ended() { Shown::Last("end", status) } else { Shown::Event("progress", status) }
    }))
}

/// `GET /v1/simulations/{id}/trace`
pub async fn simulation_trace(
    State(app): Shared,
    Segment(id): Segment,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    simulations::trace(&app.simulations.get(&id)?.recording()?, &headers)
}

/// `DELETE /v1/simulations/{id}`
pub async fn delete_simulation(State(app): Shared, Segment(id): Segment) -> Result<StatusCode, Problem> {
    app.simulations.delete(&id).map(|()| StatusCode::NO_CONTENT)
}

/// `GET /readyz`
pub async fn ready(State(app): Shared) -> Result<&'static str, Problem> {
    if app.drain.is_announced() { Err(Problem::draining()) } else { Ok("ready") }
}

/// `GET /metrics`
pub async fn metrics(State(app): Shared) -> impl IntoResponse {
    let media_type = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    ([(header::CONTENT_TYPE, media_type)], app.metrics.text(app.sessions.count(), app.connections.count()))
}
