//! Kinematics of an arm and stability of a contact.

use std::sync::Arc;

use axum::extract::State;
use revprio_api::wire;

use super::Shared;
use crate::service::body::{Answer, Body};
use crate::service::convert;
use crate::service::error::ApiError;

/// Computes the stability margins of one axis in contact.
///
/// Maximum lag, maximum delay, minimum and maximum damping.
#[utoipa::path(
    post,
    path = "/v1/stability",
    tag = "analysis",
    request_body = wire::StabilityRequest,
    responses(
        (status = 200, body = wire::StabilityAnswer, description = "Spectral radius and margins of the loop.")
    )
)]
pub async fn stability(
    State(app): Shared,
    Body(request): Body<wire::StabilityRequest>,
) -> Result<Answer<wire::StabilityAnswer>, ApiError> {
    let contact = convert::contact_loop(&request)?;
    let margin = app.margins.run(move |abandoned| convert::margin(&contact, || abandoned.is_set())).await??;
    Ok(Answer(convert::margin_answer(&margin)))
}

/// Identifies bias and payload of a wrench sensor.
///
/// From readings at rest in six postures or more: bias, mass and centre of mass, with residual, uncertainty and condition. Similar postures
/// are refused with the posture to add, and a wrong sign or exchanged axes by their names.
#[utoipa::path(
    post,
    path = "/v1/payload",
    tag = "analysis",
    request_body = wire::PayloadRequest,
    responses((status = 200, body = wire::PayloadAnswer, description = "Bias and payload, as `wrench_sensor` has them."))
)]
pub async fn payload(
    State(app): Shared,
    Body(request): Body<wire::PayloadRequest>,
) -> Result<Answer<wire::PayloadAnswer>, ApiError> {
    let shared = Arc::clone(&app);
    app.new.run(move |_| convert::payload(&request, &shared.robots)).await?.map(Answer)
}

/// Computes the kinematics of an arm.
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
) -> Result<Answer<wire::KinematicsAnswer>, ApiError> {
    convert::kinematics(&request, &app.robots).map(Answer)
}
