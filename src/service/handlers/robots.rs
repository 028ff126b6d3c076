//! The registry of the arms that requests can name.

use std::sync::Arc;

use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::IntoResponse;
use revprio_api::wire;

use super::{Segment, Shared};
use crate::service::background::background;
use crate::service::body::{Body, LargeAnswer};
use crate::service::convert;
use crate::service::error::ApiError;
use crate::service::state::AppState;

/// Lists the robots.
///
/// The robots that ship with the service, those given at its start, and registered ones.
#[utoipa::path(
    get,
    path = "/v1/robots",
    tag = "robots",
    responses((status = 200, body = wire::RobotList, description = "All robots that requests can name."))
)]
pub async fn robots(State(app): Shared) -> Result<LargeAnswer<wire::RobotList>, ApiError> {
    let list = move |_: &_| app.robots.all().iter().map(|robot| convert::robot_answer(robot)).collect();
    background(list).await.map(|robots| LargeAnswer(wire::RobotList { robots }))
}

/// Shows a robot.
///
/// The joints in order, their limits with units, and the source of the description.
#[utoipa::path(
    get,
    path = "/v1/robots/{name}",
    tag = "robots",
    responses((status = 200, body = wire::Robot, description = "The robot."))
)]
pub async fn robot(State(app): Shared, Segment(name): Segment) -> Result<LargeAnswer<wire::Robot>, ApiError> {
    let robot = app.robots.get(&name).map_err(|error| convert::robots_error(&error))?;
    background(move |_: &_| convert::robot_answer(&robot)).await.map(LargeAnswer)
}

/// Registers a robot.
///
/// The chain of a URDF text from one link to another. The robot stays until it is deleted or unused for too long.
#[utoipa::path(
    post,
    path = "/v1/robots",
    tag = "robots",
    request_body = wire::RobotRegistration,
    responses(
        (
            status = 201,
            body = wire::Robot,
            description = "The robot is registered.",
            headers(("Location" = String, description = "Path of the new robot."))
        ),
        (status = 409, description = "Another robot has the name: `name-taken`.")
    )
)]
pub async fn register_robot(
    State(app): Shared,
    Body(request): Body<wire::RobotRegistration>,
) -> Result<impl IntoResponse, ApiError> {
    let shared = Arc::clone(&app);
    let answer = app.new.run(move |_| register(&request, &shared)).await??;
    let location = [(header::LOCATION, format!("/v1/robots/{}", answer.name))];
    Ok((StatusCode::CREATED, location, LargeAnswer(answer)))
}

fn register(request: &wire::RobotRegistration, app: &AppState) -> Result<wire::Robot, ApiError> {
    let robot = Arc::new(convert::robot(request)?);
    let answer = convert::robot_answer(&robot);
    // Ended sessions no longer use their robots, which can then end too.
    app.sessions.end_idle();
    app.robots.register(robot).map_err(|error| convert::robots_error(&error))?;
    Ok(answer)
}

/// Deletes a registered robot.
///
/// Sessions that use the robot continue.
#[utoipa::path(
    delete,
    path = "/v1/robots/{name}",
    tag = "robots",
    responses(
        (status = 204, description = "The name is free."),
        (status = 403, description = "The robot belongs to the service: `permanent`.")
    )
)]
pub async fn delete_robot(State(app): Shared, Segment(name): Segment) -> Result<StatusCode, ApiError> {
    app.robots.remove(&name).map_err(|error| convert::robots_error(&error))?;
    Ok(StatusCode::NO_CONTENT)
}
