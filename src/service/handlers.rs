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

/// Resolves one problem.
///
/// Joint velocities for prioritised tasks at one posture, without any memory.
#[utoipa::path(
    post,
    path = "/v1/resolve",
    tag = "resolve",
    request_body = wire::ResolveRequest,
    responses(
        (status = 200, body = wire::ResolveAnswer, description = "Joint velocities and why they are what they are.")
    )
)]
pub async fn resolve(
    State(app): Shared,
    Body(request): Body<wire::ResolveRequest>,
) -> Result<Answer<wire::ResolveAnswer>, Problem> {
    resolve::one(&request, &app).map(Answer)
}

/// Resolves many problems.
///
/// Up to 10 000 problems that have nothing to do with each other; each is answered or refused for itself, in order.
#[utoipa::path(
    post,
    path = "/v1/resolve/batch",
    tag = "resolve",
    request_body = wire::BatchRequest,
    responses(
        (
            status = 200,
            body = wire::BatchAnswer,
            description = "One answer or problem for each item, in the order of the request."
        )
    )
)]
pub async fn resolve_batch(
    State(app): Shared,
    body: LargeBody<wire::BatchRequest>,
) -> Result<LargeAnswer<wire::BatchAnswer>, Problem> {
    resolve::batch(body, &app).await.map(LargeAnswer)
}

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
) -> Result<Answer<wire::StepAnswer>, Problem> {
    app.sessions.step(&id, &state).map(Answer)
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
    let steps = app.sessions.with(&id, |_, session| Ok(session.watch()))?;
    Ok(latest(steps, draining, WATCH_PAUSE, |step| match step {
        Some(step) => Shown::Event("step", (**step).clone()),
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

/// Tells how stable a contact is.
///
/// How much lag, delay and how little damping one axis in contact bears.
#[utoipa::path(
    post,
    path = "/v1/stability",
    tag = "analysis",
    request_body = wire::StabilityRequest,
    responses(
        (status = 200, body = wire::StabilityAnswer, description = "How stable the loop is, and how far it could go.")
    )
)]
pub async fn stability(
    State(app): Shared,
    Body(request): Body<wire::StabilityRequest>,
) -> Result<Answer<wire::StabilityAnswer>, Problem> {
    let contact = convert::contact_loop(&request)?;
    let margin = app.margins.run("stability margins", move |_| convert::margin(&contact)).await??;
    Ok(Answer(convert::margin_answer(&margin)))
}

/// Lists the robots.
///
/// Those that ship with the service, those given at its start and those registered.
#[utoipa::path(
    get,
    path = "/v1/robots",
    tag = "robots",
    responses((status = 200, body = wire::RobotList, description = "All robots that requests can name."))
)]
pub async fn robots(State(app): Shared) -> Answer<wire::RobotList> {
    Answer(wire::RobotList { robots: app.robots.all().iter().map(|robot| convert::robot_answer(robot)).collect() })
}

/// Shows a robot.
///
/// Joints in order, their limits with units, and how the robot was described.
#[utoipa::path(
    get,
    path = "/v1/robots/{name}",
    tag = "robots",
    responses((status = 200, body = wire::Robot, description = "The robot."))
)]
pub async fn robot(State(app): Shared, Segment(name): Segment) -> Result<Answer<wire::Robot>, Problem> {
    let robot = app.robots.get(&name).map_err(|error| convert::robots_problem(&error))?;
    Ok(Answer(convert::robot_answer(&robot)))
}

/// Registers a robot.
///
/// The chain of a URDF text from one link to another; kept until it is deleted or not used for long.
#[utoipa::path(
    post,
    path = "/v1/robots",
    tag = "robots",
    request_body = wire::RobotRegistration,
    responses(
        (
            status = 201,
            body = wire::Robot,
            description = "The robot is known.",
            headers(("Location" = String, description = "Address of what was made."))
        ),
        (status = 409, description = "The name belongs to another robot: `name-taken`.")
    )
)]
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

/// Deletes a registered robot.
///
/// Sessions that use it go on.
#[utoipa::path(
    delete,
    path = "/v1/robots/{name}",
    tag = "robots",
    responses(
        (status = 204, description = "The name is free."),
        (status = 403, description = "The robot belongs to the service: `permanent`.")
    )
)]
pub async fn delete_robot(State(app): Shared, Segment(name): Segment) -> Result<StatusCode, Problem> {
    app.robots.remove(&name).map_err(|error| convert::robots_problem(&error))?;
    Ok(StatusCode::NO_CONTENT)
}

/// Tells where an arm is.
///
/// Tool pose, Jacobian, singular values and link frames at a posture.
#[utoipa::path(
    post,
    path = "/v1/kinematics",
    tag = "analysis",
    request_body = wire::KinematicsRequest,
    responses((status = 200, body = wire::KinematicsAnswer, description = "Poses, Jacobian and its singular values."))
)]
pub async fn kinematics(
    State(app): Shared,
    Body(request): Body<wire::KinematicsRequest>,
) -> Result<Answer<wire::KinematicsAnswer>, Problem> {
    convert::kinematics(&request, &app.robots).map(Answer)
}

/// Lists the scenarios.
///
/// The experiments that ship with the service.
#[utoipa::path(
    get,
    path = "/v1/scenarios",
    tag = "simulation",
    responses((status = 200, body = ScenarioList, description = "All scenarios."))
)]
pub async fn scenarios() -> Result<LargeAnswer<ScenarioList>, Problem> {
    ScenarioList::built_in().map(LargeAnswer).map_err(|_| Problem::internal())
}

/// Shows a scenario.
///
/// All of it, ready to be changed and simulated.
#[utoipa::path(
    get,
    path = "/v1/scenarios/{name}",
    tag = "simulation",
    responses((status = 200, body = Scenario, description = "The scenario."))
)]
pub async fn scenario(Segment(name): Segment) -> Result<Answer<Scenario>, Problem> {
    match Scenario::built_in(&name) {
        Some(scenario) => scenario.map(Answer).map_err(|_| Problem::internal()),
        None => Err(Problem::not_found(format!("there is no scenario `{name}`; known: {}", Scenario::names()))),
    }
}

/// Starts a simulation.
///
/// Runs a scenario with the built-in simulator against this service, when its turn comes.
#[utoipa::path(
    post,
    path = "/v1/simulations",
    tag = "simulation",
    request_body = SimulationRequest,
    responses(
        (
            status = 202,
            body = wire::Simulation,
            description = "The run is taken in.",
            headers(("Location" = String, description = "Address of what was made."))
        )
    )
)]
pub async fn create_simulation(
    State(app): Shared,
    Body(request): Body<SimulationRequest>,
) -> Result<impl IntoResponse, Problem> {
    let (scenario, robot) = convert::scenario(request, &app.robots)?;
    let status = app.simulations.create(scenario, robot)?.status();
    let location = [(header::LOCATION, format!("/v1/simulations/{}", status.id))];
    Ok((StatusCode::ACCEPTED, location, Answer(status)))
}

/// Shows a simulation.
///
/// How far it is, and its measures once it is finished.
#[utoipa::path(
    get,
    path = "/v1/simulations/{id}",
    tag = "simulation",
    responses((status = 200, body = wire::Simulation, description = "The run."))
)]
pub async fn show_simulation(State(app): Shared, Segment(id): Segment) -> Result<Answer<wire::Simulation>, Problem> {
    app.simulations.get(&id).map(|job| Answer(job.status()))
}

/// Follows a simulation.
///
/// Server-sent events `progress`, ten a second at most, and `end` as the last one; the data of each is a `Simulation`.
#[utoipa::path(
    get,
    path = "/v1/simulations/{id}/events",
    tag = "simulation",
    responses(
        (status = 200, body = String, content_type = "text/event-stream", description = "Events until the run ends.")
    )
)]
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

/// Gets the trace of a simulation.
///
/// Every control period of a finished run: a table (CSV), one object per line, or one object. `Accept` chooses.
#[utoipa::path(
    get,
    path = "/v1/simulations/{id}/trace",
    tag = "simulation",
    responses(
        (
            status = 200,
            content((String = "text/csv"), (String = "application/x-ndjson"), (Object = "application/json")),
            description = "The trace."
        ),
        (status = 406, description = "The trace cannot be had in any type that `Accept` names: `not-acceptable`."),
        (status = 409, description = "The run is not finished: `no-trace`.")
    )
)]
pub async fn simulation_trace(
    State(app): Shared,
    Segment(id): Segment,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    simulations::trace(&app.simulations.get(&id)?.recording()?, &headers)
}

/// Cancels or forgets a simulation.
///
/// A run that has not ended is cancelled, one that has is forgotten.
#[utoipa::path(
    delete,
    path = "/v1/simulations/{id}",
    tag = "simulation",
    responses((status = 204, description = "The run is cancelled or forgotten."))
)]
pub async fn delete_simulation(State(app): Shared, Segment(id): Segment) -> Result<StatusCode, Problem> {
    app.simulations.delete(&id).map(|()| StatusCode::NO_CONTENT)
}

/// Says that the service lives.
///
/// For supervisors that start it again when it does not; always answered, without a token.
#[utoipa::path(
    get,
    path = "/healthz",
    tag = "operation",
    responses((status = 200, body = String, content_type = "text/plain", description = "`ok`."))
)]
pub async fn alive() -> &'static str {
    "ok"
}

/// Says that the service takes requests.
///
/// For load balancers; always answered, without a token. Not ready once the service is about to end.
#[utoipa::path(
    get,
    path = "/readyz",
    tag = "operation",
    responses((status = 200, body = String, content_type = "text/plain", description = "`ready`."))
)]
pub async fn ready(State(app): Shared) -> Result<&'static str, Problem> {
    if app.drain.is_announced() { Err(Problem::draining()) } else { Ok("ready") }
}

/// Shows the metrics.
///
/// For Prometheus: requests, refusals, solver paths, sessions, connections.
#[utoipa::path(
    get,
    path = "/metrics",
    tag = "operation",
    responses((status = 200, body = String, content_type = "application/openmetrics-text", description = "OpenMetrics."))
)]
pub async fn metrics(State(app): Shared) -> impl IntoResponse {
    let media_type = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    ([(header::CONTENT_TYPE, media_type)], app.metrics.text(app.sessions.count(), app.connections.count()))
}
