//! Robots.

use revprio_api::wire;
use revprio_robot::{
    ChainSelection, EndEffector, Joint, LeftOut, LimitOverride, ModelError, Overrides, RobotModel, Tip, UrdfError,
    UrdfOptions, UrdfTip, UrdfTreeOptions, VelocityEnvelope,
};

use super::checks::{Inside, Result, check, check_name, each};
use super::collisions::{shapes_answer, srdf, with_shapes};
use super::numbers::{check_numbers, number};
use super::pose::pose;
use super::terms;
use crate::error::{ApiError, escape_pointer};
use crate::robots::{RobotsError, check_joints};

/// Maximum number of tips of a robot.
pub const MAX_TIPS: usize = 32;

/// Reads a robot to be registered.
pub fn robot(request: &wire::RobotRegistration) -> Result<RobotModel> {
    let overrides = overrides(request)?;
    let (name, base) = (Some(&*request.name), request.base.as_deref());
    let with_frames = frames_of_srdf(request)?;
    let request = with_frames.as_ref().unwrap_or(request);
    let robot = if let Some(tips) = &request.tips {
        check(request.tip.is_none(), "/tip", "give either `tip` or `tips`")?;
        let tips = registered_tips(tips)?;
        let options = UrdfTreeOptions { name, description: None, base, tips: &tips, overrides: Some(&overrides) };
        RobotModel::from_urdf_tree(&request.urdf, &options)
    } else {
        let tip = request.tip.as_deref();
        let options = UrdfOptions { name, description: None, base, tip, overrides: Some(&overrides) };
        RobotModel::from_urdf(&request.urdf, &options)
    };
    let named = |error: ApiError| if with_frames.is_some() { error_of_srdf(error) } else { error };
    let robot = robot.map_err(|error| named(urdf_error(request, &error)))?;
    if request.tips.is_some() {
        check_tip_names(&robot).map_err(named)?;
    }
    check_joints(&robot).map_err(|error| robots_error(&error))?;
    with_shapes(robot, request, None)
}

/// Returns an error about a tip as one about the end effectors of the SRDF text, which named the tip.
fn error_of_srdf(error: ApiError) -> ApiError {
    let wire = error.into_wire();
    let pointer = wire.pointer.clone().unwrap_or_default();
    let (pointer, hint) = match pointer.strip_prefix("/tip") {
        Some(_) => ("/srdf", "; the tips are the links of its end effectors; state `tips` to name them otherwise"),
        None => (pointer.as_str(), ""),
    };
    ApiError::invalid(pointer, format!("{}{hint}", wire.detail)).with_candidates(&wire.candidates)
}

/// Returns the registration with the links of the end effectors of its SRDF text as tip or tips; `None` if it names some, or the text has
/// none.
pub fn frames_of_srdf(request: &wire::RobotRegistration) -> Result<Option<wire::RobotRegistration>> {
    if request.tip.is_some() || request.tips.is_some() {
        return Ok(None);
    }
    let mut links: Vec<String> = Vec::new();
    for EndEffector { name, parent_link } in srdf(request)?.end_effectors {
        let detail = format_args!("the end effector `{name}` names no `parent_link`");
        check(!parent_link.is_empty(), "/srdf", detail)?;
        // More than the robot may have are refused later.
        if links.len() <= MAX_TIPS && !links.contains(&parent_link) {
            links.push(parent_link);
        }
    }
    let tip = |link: &String| wire::RegisteredTip { name: link.clone(), link: link.clone(), offset: None };
    Ok(match links.as_slice() {
        [] => None,
        [only] => Some(wire::RobotRegistration { tip: Some(only.clone()), ..request.clone() }),
        several => Some(wire::RobotRegistration { tips: Some(several.iter().map(tip).collect()), ..request.clone() }),
    })
}

/// Checks that each name of a tip is a word, and that it names nothing else: tasks and planes would mean different things by it.
pub fn check_tip_names(robot: &RobotModel) -> Result<()> {
    for (k, tip) in robot.tips().iter().enumerate() {
        let (name, pointer) = (tip.name.as_str(), format!("/tips/{k}/name"));
        check_name(name, &pointer)?;
        let is_joint = robot.moving_joints().iter().any(|joint| joint.name == name);
        let is_other_link = robot.link(name).is_some_and(|link| link != tip.link);
        let is_taken = is_joint || is_other_link || ["tool", "base"].contains(&name);
        check(
            !is_taken,
            &pointer,
            format_args!("`{name}` is the name of a joint, of another link, or of a frame; give another"),
        )?;
    }
    Ok(())
}

/// Reads the tips of a registration.
pub fn registered_tips(tips: &[wire::RegisteredTip]) -> Result<Vec<UrdfTip<'_>>> {
    check((1..=MAX_TIPS).contains(&tips.len()), "/tips", format_args!("give 1 to {MAX_TIPS} tips"))?;
    each("/tips", tips, |_, tip| registered_tip(tip))
}

fn registered_tip(tip: &wire::RegisteredTip) -> Result<UrdfTip<'_>> {
    let offset = tip.offset.as_ref().map(pose).transpose().inside("/offset")?.unwrap_or_default();
    Ok(UrdfTip { name: &tip.name, link: &tip.link, offset })
}

/// Reads the values of a registration that replace those of its text.
pub fn overrides(request: &wire::RobotRegistration) -> Result<Overrides> {
    let limit = |(joint, stated): (&String, &wire::StatedLimits)| {
        check_limits(stated).map_err(|error| error.inside(&format!("/limits/{}", escape_pointer(joint))))?;
        let wire::StatedLimits { position, velocity, acceleration, jerk, velocity_envelope } = *stated;
        let envelope = velocity_envelope
            .map(|wire| VelocityEnvelope { deceleration: wire.deceleration_limit, offset: wire.velocity_offset });
        Ok((joint.clone(), LimitOverride { position, velocity, acceleration, jerk, envelope }))
    };
    Ok(Overrides {
        limits: request.limits.iter().flatten().map(limit).collect::<Result<_>>()?,
        joint_names: request.joint_names.clone().unwrap_or_default(),
        tool_offset: request.tool_offset.as_ref().map(pose).transpose().inside("/tool_offset")?,
    })
}

fn check_limits(stated: &wire::StatedLimits) -> Result<()> {
    if let Some(position) = &stated.position {
        check_numbers(position, "/position")?;
    }
    let (deceleration, offset) =
        stated.velocity_envelope.map(|envelope| (envelope.deceleration_limit, envelope.velocity_offset)).unzip();
    let places = [
        (stated.velocity, "/velocity"),
        (stated.acceleration, "/acceleration"),
        (stated.jerk, "/jerk"),
        (deceleration, "/velocity_envelope/deceleration_limit"),
        (offset, "/velocity_envelope/velocity_offset"),
    ];
    let given = places.into_iter().filter_map(|(value, place)| Some((value?, place)));
    given.into_iter().try_for_each(|(value, place)| number(value, place).map(drop))
}

fn urdf_error(request: &wire::RobotRegistration, error: &UrdfError) -> ApiError {
    let pointer = match error {
        UrdfError::Base { .. } | UrdfError::UnknownBase { .. } => "/base",
        UrdfError::Tip { .. } | UrdfError::Arms { .. } | UrdfError::UnknownTip { .. } => "/tip",
        UrdfError::Model(
            ModelError::DuplicateTip { .. }
            | ModelError::UnknownTip { .. }
            | ModelError::FixedTip { .. }
            | ModelError::TipNotFinite { .. },
        ) => "/tips",
        UrdfError::UnknownJoint { field: "limits", .. } => "/limits",
        UrdfError::UnknownJoint { .. } | UrdfError::JointName { .. } => "/joint_names",
        UrdfError::Model(ModelError::DuplicateJoint { .. }) if request.joint_names.is_some() => "/joint_names",
        UrdfError::Limit { joints, .. } if request.limits.iter().flatten().any(|(name, _)| joints.contains(name)) => {
            "/limits"
        }
        _ => "/urdf",
    };
    ApiError::invalid(pointer, error).with_candidates(error.candidates())
}

/// Converts the error of the registry of robots.
pub fn robots_error(error: &RobotsError) -> ApiError {
    match error {
        RobotsError::Name(_) => ApiError::invalid("/name", error),
        RobotsError::Joints(_) | RobotsError::MovingJoints(_) => ApiError::invalid("/urdf", error),
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
        tips: robot.tips().iter().map(|tip| tip_answer(robot, tip)).collect(),
        links: robot.links().iter().map(|link| link.name.clone()).collect(),
        shapes: shapes_answer(robot),
        chain: robot.selection().map(|selection| chain_answer(robot, selection)),
    }
}

fn tip_answer(robot: &RobotModel, tip: &Tip) -> wire::RobotTip {
    wire::RobotTip { name: tip.name.clone(), link: robot.links()[tip.link.index()].name.clone() }
}

fn chain_answer(robot: &RobotModel, selection: &ChainSelection) -> wire::RobotChain {
    let left_out = |joint: &LeftOut| wire::LeftOutJoint {
        joint: joint.joint.clone(),
        reason: terms::left_out_answer(joint.reason),
    };
    wire::RobotChain {
        base: selection.base.clone(),
        tip: selection.tip.clone(),
        reason: terms::tip_reason_answer(selection.reason),
        joints: robot.joints().iter().map(|joint| joint.name.clone()).collect(),
        left_out: selection.left_out.iter().map(left_out).collect(),
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
        jerk_limit: finite(limits.jerk),
        velocity_envelope: limits.envelope.is_finite().then_some(wire::VelocityEnvelope {
            deceleration_limit: limits.envelope.deceleration,
            velocity_offset: limits.envelope.offset,
        }),
        published_range: joint.published_range,
        denavit_hartenberg: joint.denavit_hartenberg.map(|row| wire::DenavitHartenberg {
            d_m: row.d,
            a_m: row.a,
            alpha_rad: row.alpha,
            theta_rad: row.theta,
        }),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::overrides;

    #[test]
    fn a_limit_that_is_too_large_is_refused_at_its_field() {
        for (limits, field) in [
            (json!({"position": [-1, 1e300]}), "position/1"),
            (json!({"velocity": 1e300}), "velocity"),
            (json!({"position": [-1, 1], "acceleration": 1e300}), "acceleration"),
            (json!({"jerk": -1e300}), "jerk"),
            (
                json!({"velocity_envelope": {"deceleration_limit": 1e300, "velocity_offset": 0}}),
                "velocity_envelope/deceleration_limit",
            ),
            (
                json!({"velocity_envelope": {"deceleration_limit": 1, "velocity_offset": 1e300}}),
                "velocity_envelope/velocity_offset",
            ),
        ] {
            let registration = json!({"name": "a", "urdf": "", "limits": {"elbow": limits}});
            let error = overrides(&serde_json::from_value(registration).unwrap()).unwrap_err().to_string();
            assert!(error.starts_with(&format!("/limits/elbow/{field}: ")), "{error}");
        }
    }
}
