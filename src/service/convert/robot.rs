//! Robots.

use revprio_api::wire;
use revprio_robot::{Joint, RobotModel, UrdfError, UrdfOptions};

use super::resolve::MAX_JOINTS;
use super::terms;
use crate::service::error::ApiError;
use crate::service::robots::RobotsError;

/// Reads a robot to be registered.
pub fn robot(request: &wire::RobotRegistration) -> Result<RobotModel, ApiError> {
    let options = UrdfOptions {
        name: Some(&request.name),
        description: None,
        base: request.base.as_deref(),
        tip: request.tip.as_deref(),
    };
    let robot = RobotModel::from_urdf(&request.urdf, &options).map_err(|error| {
        let pointer = match error {
            UrdfError::Base { .. } | UrdfError::UnknownBase { .. } => "/base",
            UrdfError::Tip { .. } | UrdfError::UnknownTip { .. } => "/tip",
            _ => "/urdf",
        };
        ApiError::invalid(pointer, error)
    })?;
    match robot.joint_count() {
        0..=MAX_JOINTS => Ok(robot),
        joints => {
            let detail = format!("{joints} joints in the chain; a robot has at most {MAX_JOINTS}");
            Err(ApiError::invalid("/urdf", detail))
        }
    }
}

/// Converts the error of the registry of robots.
pub fn robots_error(error: &RobotsError) -> ApiError {
    match error {
        RobotsError::Name(_) => ApiError::invalid("/name", error),
        RobotsError::Taken(_) => ApiError::name_taken(error.to_string()),
        RobotsError::Full => ApiError::too_many_robots(error.to_string()),
        RobotsError::Permanent(_) => ApiError::permanent(error.to_string()),
        RobotsError::Unknown { .. } => ApiError::not_found(error.to_string()),
    }
}

/// Returns the body of an answer about a robot.
pub fn robot_answer(robot: &RobotModel) -> wire::Robot {
    wire::Robot {
        name: robot.name().to_owned(),
        description: robot.description().to_owned(),
        source: source(robot),
        joints: robot.joints().iter().map(joint_answer).collect(),
    }
}

fn source(robot: &RobotModel) -> wire::RobotSource {
    if robot.joints().iter().all(|joint| joint.denavit_hartenberg.is_some()) {
        wire::RobotSource::DenavitHartenberg
    } else {
        wire::RobotSource::Urdf
    }
}

fn joint_answer(joint: &Joint) -> wire::RobotJoint {
    let limits = &joint.limits;
    let finite = |value: f64| value.is_finite().then_some(value);
    wire::RobotJoint {
        name: joint.name.clone(),
        kind: terms::joint_kind_answer(joint.kind),
        unit: joint.kind.unit().to_owned(),
        position_limit: (limits.lower.is_finite() && limits.upper.is_finite()).then_some([limits.lower, limits.upper]),
        velocity_limit: finite(limits.velocity),
        acceleration_limit: finite(limits.acceleration),
        published_range: joint.published_range,
        denavit_hartenberg: joint.denavit_hartenberg.map(|row| wire::DenavitHartenberg {
            d_m: row.d,
            a_m: row.a,
            alpha_rad: row.alpha,
            theta_rad: row.theta,
        }),
    }
}
