//! Kinematics of an arm and stability of a contact.

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
