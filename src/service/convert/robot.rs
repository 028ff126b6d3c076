//! Robots as answers.

use super::terms;
use crate::robot::{Joint, JointKind, RobotModel};
use crate::wire;

/// What the interface says of a robot.
pub fn robot_answer(robot: &RobotModel) -> wire::Robot {
    wire::Robot {
        name: robot.name().to_owned(),
        description: robot.description().to_owned(),
        joints: robot.joints().iter().map(joint_answer).collect(),
    }
}

fn joint_answer(joint: &Joint) -> wire::RobotJoint {
    let limits = &joint.limits;
    let finite = |value: f64| value.is_finite().then_some(value);
    wire::RobotJoint {
        name: joint.name.clone(),
        kind: terms::joint_kind_answer(joint.kind),
        unit: if joint.kind == JointKind::Revolute { "rad" } else { "m" }.to_owned(),
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
