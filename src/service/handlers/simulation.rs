//! Scenarios and their runs.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use revprio_api::wire;
use revprio_lab::simulator::{Scenario, ScenarioList, SimulationRequest};

use super::Shared;
use crate::service::body::{Answer, Body, LargeAnswer};
use crate::service::drain::Draining;
use crate::service::error::ApiError;
use crate::service::events::{Shown, latest};
use crate::service::segment::Segment;
use crate::service::simulations::RunControl;
use crate::service::{convert, simulations};

/// Between two events of a simulation's progress.
const PROGRESS_PAUSE: Duration = Duration::from_millis(100);

/// Between two frames of an interactive run.
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
/// All of it, ready to be changed and simulated.
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
) -> Result<impl IntoResponse, ApiError> {
    let interactive = request.interactive;
    convert::interactive(interactive.as_ref())?;
    let (scenario, robot) = convert::scenario(request, &app.robots)?;
    let run_control = interactive.map(|pace| {
        let request = scenario.controller.clone();
        let controller = convert::controller(&request, &app.robots)?;
        RunControl::new(pace, request, controller, &scenario.start_joint_position)
    });
    let status = app.simulations.create(scenario, robot, run_control.transpose()?)?.status();
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
pub async fn show_simulation(State(app): Shared, Segment(id): Segment) -> Result<Answer<wire::Simulation>, ApiError> {
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
) -> Result<impl IntoResponse, ApiError> {
    let job = app.simulations.get(&id)?;
    let progress = job.watch();
    Ok(latest(progress, draining, PROGRESS_PAUSE, move |progress| {
        let status = job.status_at(progress);
        if progress.has_ended() { Shown::Last("end", status) } else { Shown::Event("progress", status) }
    }))
}

/// Controls a simulation.
///
/// Pauses, steps, paces, pushes, changes or ends an interactive run; what is left out stays. Nothing jumps: a changed law
/// goes on from the present velocity, and a changed method or solver takes over within a tenth of a simulated second.
#[utoipa::path(
    post,
    path = "/v1/simulations/{id}/control",
    tag = "simulation",
    request_body = wire::SimulationControl,
    responses(
        (status = 200, body = wire::Simulation, description = "The run as it goes on."),
        (status = 409, description = "The run is not interactive or has ended: `not-live`.")
    )
)]
pub async fn control_simulation(
    State(app): Shared,
    Segment(id): Segment,
    Body(order): Body<wire::SimulationControl>,
) -> Result<Answer<wire::Simulation>, ApiError> {
    let job = app.simulations.get(&id)?;
    simulations::live_run_control(&job)?.order(&order, &app.robots)?;
    Ok(Answer(job.status()))
}

/// Looks at a simulation.
///
/// An interactive run as server-sent events `frame`, 20 a second at most, and `end` as the last one; the data of each is a
/// `LiveFrame`. The first one brings the latest seconds with it.
#[utoipa::path(
    get,
    path = "/v1/simulations/{id}/live",
    tag = "simulation",
    responses(
        (status = 200, body = String, content_type = "text/event-stream", description = "Events until the run ends."),
        (status = 409, description = "The run is not interactive or has ended: `not-live`.")
    )
)]
pub async fn simulation_live(
    State(app): Shared,
    Segment(id): Segment,
    draining: Draining,
) -> Result<impl IntoResponse, ApiError> {
    let job = app.simulations.get(&id)?;
    let run_control = Arc::clone(simulations::live_run_control(&job)?);
    let pictures = run_control.watch();
    let mut seen = 0;
    Ok(latest(pictures, draining, LIVE_PAUSE, move |picture| {
        let has_ended = job.has_ended();
        let frame = run_control.frame(picture, job.status(), &mut seen);
        if has_ended { Shown::Last("end", frame) } else { Shown::Event("frame", frame) }
    }))
}

/// Gets the latest cycle of a simulation.
///
/// The latest control period of an interactive run as `POST /v1/step` takes it, to be asked again elsewhere. While a changed
/// method takes over, the arm obeys a mixture of this command and that of the method before.
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
    simulations::run_control(&*app.simulations.get(&id)?)?.cycle().map(Answer)
}

/// Gets the trace of a simulation.
///
/// Every control period of a finished run: a table (CSV, Parquet), one object per line, one object, or a log for Foxglove,
/// Rerun and PlotJuggler (MCAP). `Accept` chooses.
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
        (status = 406, description = "The trace cannot be had in any type that `Accept` names: `not-acceptable`."),
        (status = 409, description = "The run is not finished: `no-trace`.")
    )
)]
pub async fn simulation_trace(
    State(app): Shared,
    Segment(id): Segment,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
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
pub async fn delete_simulation(State(app): Shared, Segment(id): Segment) -> Result<StatusCode, ApiError> {
    app.simulations.delete(&id).map(|()| StatusCode::NO_CONTENT)
}
