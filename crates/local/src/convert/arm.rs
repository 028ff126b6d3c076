//! The view of an arm for display.

use revprio_api::wire;
use revprio_core::controller::ControllerConfig;
use revprio_core::limits::JointMotion;
use revprio_robot::kinematics::{Configuration, link_frames};
use revprio_robot::{RobotModel, Tip};

use super::pose::pose_answer;

/// Returns the view of an arm at a posture, with the joint velocities that its limits allow. Returns `None` if the robot
/// has no such posture.
///
/// `position`: measured, n; `last_velocity`: command of the previous period, n, with which the joints have moved for long.
pub fn arm_view(config: &ControllerConfig, position: &[f64], last_velocity: &[f64]) -> Option<wire::ArmView> {
    let robot = &config.robot;
    let frames = link_frames(robot, position).ok()?;
    let distance_to_rest: Vec<f64> =
        last_velocity.iter().map(|v| config.drive.time_to_rest(config.period_s) * v).collect();
    let motion = JointMotion {
        position,
        distance_to_rest: &distance_to_rest,
        last_command: last_velocity,
        last_acceleration: &[],
    };
    let allowed = config.limits.at(robot, motion, config.period_s).velocity_box;
    let configuration = Configuration::new(robot, position).ok()?;
    let joint = |(i, frame): (usize, &nalgebra::IsometryMatrix3<f64>)| {
        let (origin, axis) = (frame.translation.vector, frame.rotation * nalgebra::Vector3::z());
        wire::JointView {
            origin: [origin.x, origin.y, origin.z].map(single),
            axis: [axis.x, axis.y, axis.z].map(single),
            lower: finite(allowed.lower()[i]),
            upper: finite(allowed.upper()[i]),
        }
    };
    Some(wire::ArmView {
        joints: frames.iter().enumerate().map(joint).collect(),
        tool: pose_answer(configuration.tool_pose()),
        chains: chains(robot, &configuration),
    })
}

/// Returns the chain to each tip; none if one chain has all joints.
fn chains(robot: &RobotModel, configuration: &Configuration) -> Vec<wire::ChainView> {
    let moving = robot.moving_joints();
    let chain = |tip: &Tip| {
        let up = std::iter::successors(robot.links()[tip.link.index()].joint, |&joint| moving[joint].parent);
        let own = up.map(|joint| &moving[joint]).filter(|joint| !joint.is_mimic);
        let mut joints: Vec<usize> = own.map(|joint| joint.coordinate).collect();
        joints.reverse();
        let position = configuration.tip_pose(tip).translation.vector;
        wire::ChainView { joints, tip: [position.x, position.y, position.z].map(single) }
    };
    let chains: Vec<_> = robot.tips().iter().map(chain).collect();
    let is_serial = matches!(chains.as_slice(), [only] if only.joints.len() == robot.joint_count());
    if is_serial { Vec::new() } else { chains }
}

/// Rounds to single precision, for display.
#[expect(clippy::cast_possible_truncation, reason = "a screen shows fewer digits")]
pub fn single(value: f64) -> f32 {
    value as f32
}

/// Rounds to single precision. Returns `None` for numbers that JSON cannot express.
pub fn finite(value: f64) -> Option<f32> {
    let value = single(value);
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::robot;

    #[test]
    fn a_robot_that_is_no_chain_is_drawn_by_its_chains() {
        let chains_of = |robot: &RobotModel| {
            let at_zero = Configuration::new(robot, &vec![0.0; robot.joint_count()]).unwrap();
            chains(robot, &at_zero).into_iter().map(|chain| chain.joints).collect::<Vec<_>>()
        };
        let text = include_str!("../../../../api/examples/robot_two_arms.json");
        let mut two: wire::RobotRegistration = serde_json::from_str(text).unwrap();
        assert_eq!(chains_of(&robot(&two).unwrap()), [vec![0, 1, 2, 3], vec![0, 4, 5, 6]]);
        two.tips.as_mut().unwrap().remove(0);
        assert_eq!(chains_of(&robot(&two).unwrap()), [vec![0, 4, 5, 6]]);
        assert!(chains_of(&revprio_robot::built_in()[0]).is_empty());
    }
}
