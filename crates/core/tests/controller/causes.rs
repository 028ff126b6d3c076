//! Each active limit of a command names the limit of the robot that sets it.

use std::sync::Arc;

use revprio_core::controller::{Controller, ControllerConfig, Limits, TaskConfig};
use revprio_core::law::Law;
use revprio_core::limits::{BoundCause, LimitKind, VelocityBox};
use revprio_core::rows::{JointRows, JointTarget, TaskRows};
use revprio_core::streaming::Streaming;
use revprio_robot::RobotModel;

use super::arms::{Loop, NOMINAL, PERIOD, config, constant, controller, sawyer, with_jerk};

/// Moves the first joint of an arm at a velocity (rad/s).
fn turning(robot: &Arc<RobotModel>, limits: Limits, velocity: f64) -> Controller {
    let rows = TaskRows::Joints(JointRows { joints: vec![0], target: JointTarget::MidRange });
    let law = Law::Velocity(constant(&[velocity]));
    let turn = TaskConfig { name: "turn".to_owned(), rows, law, scaled: false, streaming: Streaming::default() };
    controller(ControllerConfig { limits, ..config(robot, vec![turn]) })
}

/// Returns the causes of a number of periods, each once, in the order in which they first act.
fn causes(controller: &Controller, arm: &mut Loop, periods: u32) -> Vec<BoundCause> {
    let mut seen = Vec::new();
    for _ in 0..periods {
        let command = arm.step(controller, [0.0; 6]);
        assert_eq!(command.limit_causes.len(), command.resolution.active_limits().count());
        for ((joint, _), cause) in command.resolution.active_limits().zip(command.limit_causes) {
            assert_eq!(joint, 0);
            if !seen.contains(&cause) {
                seen.push(cause);
            }
        }
    }
    seen
}

#[test]
fn an_active_limit_names_what_sets_it() {
    let robot = sawyer();
    let soft = Arc::new(with_jerk(&robot, 0.1));
    let slow = VelocityBox::new(&[-0.1; 7], &[0.1; 7]).unwrap();
    let from_rest = |robot: &Arc<RobotModel>, limits: Limits, velocity: f64, periods: u32| {
        causes(&turning(robot, limits, velocity), &mut Loop::at_rest(&NOMINAL), periods)
    };
    let limits = Limits::Robot;
    let all = LimitKind::PositionVelocityAcceleration;
    assert_eq!(from_rest(&robot, Limits::Fixed(slow), 1.0, 1), [BoundCause::Given]);
    assert_eq!(from_rest(&robot, limits(LimitKind::Velocity), 9.0, 1), [BoundCause::Velocity]);
    assert_eq!(from_rest(&robot, limits(all), -1.0, 1), [BoundCause::Acceleration]);
    assert_eq!(from_rest(&soft, limits(all), -1.0, 1), [BoundCause::Jerk]);
    assert_eq!(from_rest(&robot, limits(LimitKind::None), 9.0, 10), []);
    // It accelerates, moves at its top speed, and stops at the end of its range.
    let until_the_end = from_rest(&robot, limits(all), -9.0, 6000);
    assert_eq!(until_the_end, [BoundCause::Acceleration, BoundCause::Velocity, BoundCause::Position]);
    // Its acceleration rises, and falls before the velocity that the task wants.
    let until_the_velocity = from_rest(&soft, limits(all), -0.5, 1000);
    assert_eq!(until_the_velocity.first(), Some(&BoundCause::Jerk));
    assert_eq!(until_the_velocity.last(), Some(&BoundCause::LevellingOff));
}

#[test]
fn a_transition_names_itself() {
    let robot = sawyer();
    let limits = || Limits::Robot(LimitKind::Velocity);
    let (before, after) = (turning(&robot, limits(), 0.5), turning(&robot, limits(), -0.5));
    let mut arm = Loop::at_rest(&NOMINAL);
    assert_eq!(causes(&before, &mut arm, 10), []);
    arm.memory = Some(after.continue_from(&before, arm.memory.as_ref().unwrap(), &arm.q).unwrap());
    // It turns back, which takes 1 rad/s / A, and then no limit is active.
    assert!(1.0 < 200.0 * PERIOD * robot.joints()[0].limits.acceleration);
    assert_eq!(causes(&after, &mut arm, 200), [BoundCause::Transition]);
    assert_eq!(causes(&after, &mut arm, 10), []);
}
