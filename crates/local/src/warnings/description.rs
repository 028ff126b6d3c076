//! Warnings about a robot description that is probably in millimetres or degrees.

use revprio_lab::number::significant;
use revprio_robot::{Joint, RobotModel};

/// The largest reach that is not reported, m. Cranes reach further than arms.
const LONGEST_REACH_M: f64 = 50.0;

/// The largest turn of a joint from zero that is not reported, rad: eight turns.
const MOST_TURNED: f64 = 50.0;

/// Returns whether an arm reaches so far that its description must be in another unit than metres.
pub fn reaches_too_far(robot: &RobotModel) -> bool {
    robot.reach() > LONGEST_REACH_M
}

/// Returns the warnings.
pub fn warnings(robot: &RobotModel) -> Vec<String> {
    let reach = significant(robot.reach(), 3);
    let far = || format!("`{}` reaches {reach} m; is its description in millimetres?", robot.name());
    let length = reaches_too_far(robot).then(far);
    length.into_iter().chain(robot.joints().iter().find_map(in_degrees)).collect()
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
