//! Warnings about a robot description that is probably in millimetres or degrees.

use revprio_lab::number::significant;
use revprio_robot::{Joint, JointLimits, RobotModel};

/// The largest reach that is not reported, m. Cranes reach further than arms.
const LONGEST_REACH_M: f64 = 50.0;

/// The largest turn of a joint from zero that is not reported, rad: eight turns.
const MOST_TURNED: f64 = 50.0;

/// The largest speed of a turning joint that is not reported, rad/s: eight turns per second.
const FASTEST_TURN: f64 = 50.0;

/// The largest way and speed of a sliding joint that are not reported, m and m/s.
const FARTHEST_SLIDE: f64 = 20.0;

/// Returns whether an arm reaches so far that its description must be in another unit than metres.
pub fn reaches_too_far(robot: &RobotModel) -> bool {
    robot.reach() > LONGEST_REACH_M
}

/// Returns the warnings.
pub fn warnings(robot: &RobotModel) -> Vec<String> {
    let reach = significant(robot.reach(), 3);
    let far = || format!("`{}` reaches {reach} m; is its description in millimetres?", robot.name());
    let length = reaches_too_far(robot).then(far);
    let joints = robot.joints();
    let others =
        [joints.iter().find_map(in_degrees), joints.iter().find_map(too_fast), joints.iter().find_map(slides_too_far)];
    length.into_iter().chain(others.into_iter().flatten()).collect()
}

fn too_fast(joint: &Joint) -> Option<String> {
    let speed = joint.limits.velocity;
    let is_fast = speed.is_finite() && speed > FASTEST_TURN && !joint.kind.is_translation();
    is_fast.then(|| format!("the speed limit of joint `{}` is {speed} rad/s; is it in degrees per second?", joint.name))
}

fn slides_too_far(joint: &Joint) -> Option<String> {
    let JointLimits { lower, upper, velocity, .. } = joint.limits;
    let is_far = [lower, upper, velocity].iter().any(|value| value.is_finite() && value.abs() > FARTHEST_SLIDE);
    (is_far && joint.kind.is_translation()).then(|| {
        format!(
            "joint `{}` slides from {lower} to {upper} m with {velocity} m/s at most; is its description in millimetres?",
            joint.name
        )
    })
}

fn in_degrees(joint: &Joint) -> Option<String> {
    let ends = [joint.limits.lower, joint.limits.upper];
    let turns = |end: &f64| end.is_finite() && end.abs() > MOST_TURNED && !joint.kind.is_translation();
    ends.iter().any(turns).then(|| {
        format!(
            "the range of joint `{}` is {} to {} rad; is it in degrees?",
            joint.name, joint.limits.lower, joint.limits.upper
        )
    })
}
