//! Scenarios and simulations.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use revprio_api::wire;
use revprio_lab::simulator::{Scenario, ScenarioList, SimulationRequest};
use revprio_local::simulation::RunControl;
use revprio_robot::RobotModel;

use super::{Segment, Shared};
use crate::service::body::{Answer, Body, LargeAnswer};
use crate::service::convert;
use crate::service::error::ApiError;
use crate::service::events::{Shown, latest};
use crate::service::simulations::trace_answer;
use crate::service::state::AppState;

/// Time between two events with the progress of a simulation.
const PROGRESS_PAUSE: Duration = Duration::from_millis(100);

/// Time between two frames of an interactive run.
const LIVE_PAUSE: Duration = Duration::from_millis(50);

/// Lists the scenarios.
///
/// The experiments that ship with the service.
#[utoipa::path(
    get,
    path = "/v1/scenarios",
    tag = "simulation",
    responses((status = 200, body = ScenarioList, description = "All scenarios."))
)]
pub async fn scenarios() -> Result<LargeAnswer<ScenarioList>, ApiError> {
    ScenarioList::built_in().map(LargeAnswer).map_err(|_| ApiError::internal())
}

/// Shows a scenario.
///
/// The whole scenario, ready to be changed and simulated.
#[utoipa::path(
    get,
    path = "/v1/scenarios/{name}",
    tag = "simulation",
    responses((status = 200, body = Scenario, description = "The scenario."))
)]
pub async fn scenario(Segment(name): Segment) -> Result<Answer<Scenario>, ApiError> {
    match Scenario::built_in(&name) {
        Some(scenario) => scenario.map(Answer).map_err(|_| ApiError::internal()),
        None => Err(ApiError::not_found(format!("there is no scenario `{name}`; known: {}", Scenario::names()))),
    }
}

/// Starts a simulation.
///
/// Runs a scenario with the built-in simulator and this service as the controller, after the earlier simulations.
#[utoipa::path(
    post,
    path = "/v1/simulations",
    tag = "simulation",
    request_body = SimulationRequest,
    responses(
        (
            status = 202,
            body = wire::Simulation,
            description = "The simulation is accepted.",
            headers(("Location" = String, description = "Path of the new simulation."))
        )
    )
)]
pub async fn create_simulation(
    State(app): Shared,
    Body(request): Body<SimulationRequest>,
) -> Result<impl IntoResponse, ApiError> {
    let interactive = request.interactive;
    convert::check_interactive(interactive.as_ref())?;
    let shared = Arc::clone(&app);
    let read = move |_: &_| read(request, interactive, &shared);
    let (scenario, robot, run_control) = app.new.run(read).await??;
    let status = app.simulations.create(scenario, robot, run_control)?.status();
    let location = [(header::LOCATION, format!("/v1/simulations/{}", status.id))];
    Ok((StatusCode::ACCEPTED, location, Answer(status)))
}

/// Reads a request for a simulation.
fn read(
    request: SimulationRequest,
    interactive: Option<wire::Interactive>,
    app: &AppState,
) -> Result<(Scenario, Arc<RobotModel>, Option<RunControl>), ApiError> {
    let (scenario, robot) = convert::scenario(request, &app.robots)?;
    let run_control = interactive.map(|pace| {
        let request = scenario.controller.clone();
        let controller = convert::controller(&request, &app.robots)?;
        RunControl::new(pace, request, controller, &scenario.start_joint_position)
    });
    Ok((scenario, robot, run_control.transpose()?))
}

/// Shows a simulation.
///
/// Its progress, and its measures once it is finished.
#[utoipa::path(
    get,
    path = "/v1/simulations/{id}",
    tag = "simulation",
    responses((status = 200, body = wire::Simulation, description = "The run."))
)]
pub async fn show_simulation(State(app): Shared, Segment(id): Segment) -> Result<Answer<wire::Simulation>, ApiError> {
    app.simulations.get(&id).map(|job| Answer(job.status()))
}

/// Follows a simulation.
///
/// Server-sent events `progress`, at most ten a second, and `end` as the last one. The data of each is a `Simulation`.
#[utoipa::path(
    get,
    path = "/v1/simulations/{id}/events",
    tag = "simulation",
    responses(
        (status = 200, body = String, content_type = "text/event-stream", description = "Events until the run ends.")
    )
)]
pub async fn simulation_events(State(app): Shared, Segment(id): Segment) -> Result<impl IntoResponse, ApiError> {
    let job = app.simulations.get(&id)?;
    let progress = job.watch();
    Ok(latest(progress, app.drain.subscribe(), PROGRESS_PAUSE, move |progress| {
        let status = job.status_at(progress);
        if progress.has_ended() { Shown::Last("end", status) } else { Shown::Event("progress", status) }
    }))
}

/// Controls a simulation.
///
/// Pauses, steps, paces, pushes, changes or ends an interactive run. Omitted fields stay as they are. The joint velocities
/// do not jump: a changed law continues from the current velocity, and a changed method or solver takes over within 0.1
/// simulated seconds.
#[utoipa::path(
    post,
    path = "/v1/simulations/{id}/control",
    tag = "simulation",
    request_body = wire::SimulationControl,
    responses(
        (status = 200, body = wire::Simulation, description = "The run after the command."),
        (status = 409, description = "The run is not interactive or has ended: `not-live`.")
    )
)]
pub async fn control_simulation(
    State(app): Shared,
    Segment(id): Segment,
    Body(command): Body<wire::SimulationControl>,
) -> Result<Answer<wire::Simulation>, ApiError> {
    let job = app.simulations.get(&id)?;
    let (shared, controlled) = (Arc::clone(&app), Arc::clone(&job));
    app.new.run(move |_| controlled.live_run_control()?.apply(&command, &shared.robots)).await??;
    Ok(Answer(job.status()))
}

/// Watches an interactive simulation.
///
/// Server-sent events `frame`, at most 20 a second, and `end` as the last one. The data of each is a `LiveFrame`. The first
/// frame includes the samples of the last seconds.
#[utoipa::path(
    get,
    path = "/v1/simulations/{id}/live",
    tag = "simulation",
    responses(
        (status = 200, body = String, content_type = "text/event-stream", description = "Events until the run ends."),
        (status = 409, description = "The run is not interactive or has ended: `not-live`.")
    )
)]
pub async fn simulation_live(State(app): Shared, Segment(id): Segment) -> Result<impl IntoResponse, ApiError> {
    let job = app.simulations.get(&id)?;
    let run_control = Arc::clone(job.live_run_control()?);
    let pictures = run_control.watch();
    let mut seen = 0;
    Ok(latest(pictures, app.drain.subscribe(), LIVE_PAUSE, move |picture| {
        let has_ended = job.has_ended();
        let frame = run_control.frame(picture, job.status(), &mut seen);
        if has_ended { Shown::Last("end", frame) } else { Shown::Event("frame", frame) }
    }))
}

/// Returns the last control period of an interactive simulation.
///
/// The body is a request for `POST /v1/step`, to compute the same period elsewhere. While a changed method takes over, the
/// arm follows a mixture of this command and the command of the previous method.
#[utoipa::path(
    get,
    path = "/v1/simulations/{id}/cycle",
    tag = "simulation",
    responses(
        (status = 200, body = wire::StepRequest, description = "Controller, state and memory."),
        (status = 409, description = "The run is not interactive, or has not begun: `not-live`.")
    )
)]
pub async fn simulation_cycle(State(app): Shared, Segment(id): Segment) -> Result<Answer<wire::StepRequest>, ApiError> {
    app.simulations.get(&id)?.run_control()?.cycle().map(Answer)
}

/// Returns the trace of a simulation.
///
/// Every control period of a finished run. `Accept` selects the format: a table (CSV, Parquet), one object per line, one
/// object, or a log for Foxglove, Rerun and PlotJuggler (MCAP).
#[utoipa::path(
    get,
    path = "/v1/simulations/{id}/trace",
    tag = "simulation",
    responses(
        (
            status = 200,
            content(
                (String = "text/csv"),
                (String = "application/x-ndjson"),
                (Object = "application/json"),
                (Vec<u8> = "application/vnd.apache.parquet"),
                (Vec<u8> = "application/vnd.mcap")
            ),
            description = "The trace."
        ),
        (status = 406, description = "The trace is not available in any media type that `Accept` lists: `not-acceptable`."),
        (status = 409, description = "The run is not finished: `no-trace`.")
    )
)]
pub async fn simulation_trace(
    State(app): Shared,
    Segment(id): Segment,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    trace_answer(&app.simulations.get(&id)?.recording()?, &headers)
}

/// Cancels or deletes a simulation.
///
/// A run that has not ended is cancelled. An ended run is deleted.
#[utoipa::path(
    delete,
    path = "/v1/simulations/{id}",
    tag = "simulation",
    responses((status = 204, description = "The run is cancelled or deleted."))
)]
pub async fn delete_simulation(State(app): Shared, Segment(id): Segment) -> Result<StatusCode, ApiError> {
    app.simulations.delete(&id).map(|()| StatusCode::NO_CONTENT)
}
