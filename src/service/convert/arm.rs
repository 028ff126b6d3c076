//! An arm as it is drawn.

use revprio_api::wire;
use revprio_core::controller::ControllerConfig;
use revprio_robot::kinematics::link_frames;

use super::pose::pose_answer;

/// The arm at a posture, with the velocities that its limits allow there; `None` where there is no such posture.
///
/// `position`, `last_velocity`: n, as measured and as commanded one period earlier.
pub fn arm_view(config: &ControllerConfig, position: &[f64], last_velocity: &[f64]) -> Option<wire::ArmView> {
    let robot = &config.robot;
    let frames = link_frames(robot, position).ok()?;
    let allowed = config.limits.at(robot, position, last_velocity, config.period_s).velocity_box;
    let tool = frames.last().map_or(*robot.tool(), |frame| frame * robot.tool());
    let joint = |(i, frame): (usize, &nalgebra::IsometryMatrix3<f64>)| {
        let (origin, axis) = (frame.translation.vector, frame.rotation * nalgebra::Vector3::z());
        wire::JointView {
            origin: single([origin.x, origin.y, origin.z]),
            axis: single([axis.x, axis.y, axis.z]),
            lower: finite(allowed.lower()[i]),
            upper: finite(allowed.upper()[i]),
        }
    };
    Some(wire::ArmView { joints: frames.iter().enumerate().map(joint).collect(), tool: pose_answer(&tool) })
}

/// To single precision, for display.
#[expect(clippy::cast_possible_truncation, reason = "more digits than a screen shows")]
pub fn single<const N: usize>(values: [f64; N]) -> [f32; N] {
    values.map(|value| value as f32)
}

/// To single precision, `None` where the number has no place in JSON.
pub fn finite(value: f64) -> Option<f32> {
    let [value] = single([value]);
    value.is_finite().then_some(value)
}
