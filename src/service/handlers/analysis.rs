//! Kinematics and stability.

use axum::extract::State;
use revprio_api::wire;

use super::Shared;
use crate::service::body::{Answer, Body};
use crate::service::convert;
use crate::service::error::ApiError;

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
) -> Result<Answer<wire::StabilityAnswer>, ApiError> {
    let contact = convert::contact_loop(&request)?;
    let margin = app.margins.run("stability margins", move |_| convert::margin(&contact)).await??;
    Ok(Answer(convert::margin_answer(&margin)))
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
) -> Result<Answer<wire::KinematicsAnswer>, ApiError> {
    convert::kinematics(&request, &app.robots).map(Answer)
}
