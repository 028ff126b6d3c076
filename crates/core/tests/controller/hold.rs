//! No hold leaves the range: after any command, a watchdog that holds it and then brakes ends inside the position limits.

use std::iter;
use std::sync::Arc;

use revprio_core::controller::{Controller, ControllerConfig, Limits, TaskConfig};
use revprio_core::law::ContactSettings;
use revprio_core::limits::{Hold, LimitKind, ramp_deceleration, spare_time};
use revprio_core::rows::{JointRows, JointTarget, TaskRows};
use revprio_core::streaming::Streaming;
use revprio_robot::kinematics::Axis;
use revprio_robot::{Joint, JointLimits, RobotModel, built_in};

use super::arms::{
    Loop, Random, config, constant, contact, controller, measurement, missing_distance, position, sawyer, step,
    with_envelopes, with_jerk,
};

const KINDS: [LimitKind; 2] = [LimitKind::PositionVelocity, LimitKind::PositionVelocityAcceleration];

/// Longest hold, s, as the service states it.
const VALID: f64 = 0.1;

/// Largest distance outside the range that counts as inside, rad or m.
const TOLERANCE: f64 = 1e-6;

/// Returns the robots that ship, Sawyer without acceleration limits, with jerk limits, with envelopes, and with both.
fn robots() -> Vec<Arc<RobotModel>> {
    let unlimited =
        |joint: &Joint| Joint { limits: JointLimits { acceleration: f64::INFINITY, ..joint.limits }, ..joint.clone() };
    let sawyer = sawyer();
    let joints = sawyer.joints().iter().map(unlimited).collect();
    let without_acceleration = RobotModel::new("without acceleration", "", joints, *sawyer.tool()).unwrap();
    let soft = with_jerk(&sawyer, 0.05);
    let others = [without_acceleration, with_envelopes(&sawyer), with_envelopes(&soft), soft];
    built_in().iter().cloned().chain(others.map(Arc::new)).collect()
}

/// Returns the distance beyond the positions where a joint may rest, rad or m.
fn outside(limits: &JointLimits, q: f64) -> f64 {
    let [lowest, highest] = limits.resting_range();
    (q - highest).max(lowest - q)
}

/// Returns the time that an answer states, s: whole milliseconds, at most [`VALID`].
fn stated(hold: &Hold) -> f64 {
    (hold.time_s.min(VALID) * 1e3).floor() / 1e3
}

/// Returns the largest distance outside the range, or missing for a velocity envelope, if no answer follows a command.
///
/// The command reaches the joints `latency` after the measurement of `q`; until then they move at the velocity `last`.
/// The watchdog writes once per `interval` the ramp at the time of its next write.
fn furthest(
    robot: &RobotModel,
    q: &[f64],
    last: &[f64],
    (command, hold): (&[f64], &Hold),
    latency: f64,
    interval: f64,
) -> f64 {
    let valid = stated(hold);
    let mut furthest = f64::NEG_INFINITY;
    for (i, joint) in robot.joints().iter().enumerate() {
        let deceleration = ramp_deceleration(&joint.limits, command[i], hold.stop_time_s);
        let mut q = q[i] + last[i] * latency;
        for write in 0.. {
            let until = latency + f64::from(write + 1) * interval;
            let late = until - valid;
            let speed = if late > 1e-9 { (command[i].abs() - deceleration * late).max(0.0) } else { command[i].abs() };
            if speed == 0.0 {
                break;
            }
            q += interval * speed.copysign(command[i]);
            furthest = furthest.max(outside(&joint.limits, q));
            furthest = furthest.max(missing_distance(&joint.limits, q, speed.copysign(command[i])));
        }
    }
    furthest
}

/// Returns a controller that drives joints to positions at the speed limits; `touches`: below it is a task that may touch.
fn posture(
    robot: &Arc<RobotModel>,
    joints: Vec<usize>,
    target: &[f64],
    (kind, period): (LimitKind, f64),
    touches: bool,
) -> Controller {
    let gain = 0.5 / period;
    let rows = TaskRows::Joints(JointRows { target: JointTarget::Position(constant(target)), joints });
    let task = TaskConfig {
        name: "posture".to_owned(),
        law: position(target.len(), gain),
        rows,
        scaled: false,
        streaming: Streaming::default(),
    };
    let yields = touches.then(|| super::arms::task(&[Axis::Z], contact(&[-5.0], ContactSettings::default())));
    let tasks = iter::once(task).chain(yields).collect();
    controller(ControllerConfig { limits: Limits::Robot(kind), period_s: period, ..config(robot, tasks) })
}

/// Returns a start posture: the middle of each range.
pub fn middle(robot: &RobotModel) -> Vec<f64> {
    let middle = |joint: &Joint| 0.5 * (joint.limits.lower.max(-3.0) + joint.limits.upper.min(3.0));
    robot.joints().iter().map(middle).collect()
}

/// Returns the middle of each range, for robots whose joints all have one. The box of a joint there is symmetric, so it rests while another
/// joint is at its limit.
pub fn mid_ranges(robot: &RobotModel) -> Vec<f64> {
    robot.joints().iter().map(|joint| f64::midpoint(joint.limits.lower, joint.limits.upper)).collect()
}

#[test]
fn a_service_killed_at_any_20th_period_of_a_run_into_a_limit_leaves_no_joint_outside() {
    let [mut kills, mut at_a_limit, mut shortened, mut together] = [0; 4];
    for robot in robots() {
        for kind in KINDS {
            let joints = (0..robot.joint_count()).flat_map(|joint| [(joint, false), (joint, true)]);
            for ((joint, upper), touches) in joints.flat_map(|end| [(end, false), (end, true)]) {
                let limits = robot.joints()[joint].limits;
                let end = limits.resting_range()[usize::from(upper)];
                if !end.is_finite() {
                    continue;
                }
                let (period, periods) = [(1e-3, 4000), (4e-3, 1000), (1e-2, 400)][(joint + usize::from(upper)) % 3];
                let target = [if upper { end + 1.0 } else { end - 1.0 }];
                let controller = posture(&robot, vec![joint], &target, (kind, period), touches);
                let mut arm = Loop::at_rest(&middle(&robot));
                for number in 0..periods {
                    let (q, last) = (arm.q.clone(), last_command(&arm, &robot));
                    let command = arm.step(&controller, [0.0; 6]);
                    assert!(command.hold.too_fast.is_empty(), "{} {kind:?} {joint}", robot.name());
                    assert!(outside(&limits, arm.q[joint]) <= TOLERANCE);
                    if number % 20 != 0 {
                        continue;
                    }
                    let valid = stated(&command.hold);
                    // Enough for the next answer to come, at any time of its period.
                    assert!(valid >= spare_time(period) - 1e-3 && valid <= VALID, "{valid} s of {period} s");
                    for latency in [0.0, 0.4 * period, period, spare_time(period)] {
                        let velocity = command.resolution.joint_velocity.as_slice();
                        let found = furthest(&robot, &q, &last, (velocity, &command.hold), latency, period);
                        assert!(found <= TOLERANCE, "{} {kind:?} {joint} {number}: {found} rad", robot.name());
                    }
                    kills += 1;
                    together += usize::from(command.hold.stop_time_s.is_some());
                    shortened += usize::from(valid < VALID);
                    at_a_limit += usize::from(outside(&limits, arm.q[joint]) > -1e-3);
                }
            }
        }
    }
    assert!(kills > 20_000 && at_a_limit > 2000 && shortened > 600, "{kills} {at_a_limit} {shortened}");
    assert!(together > 5000, "{together} stops of all joints");
}

fn last_command(arm: &Loop, robot: &RobotModel) -> Vec<f64> {
    arm.memory.as_ref().map_or_else(|| vec![0.0; robot.joint_count()], |memory| memory.last_command.as_slice().to_vec())
}

#[test]
fn no_hold_of_a_random_run_leaves_the_range() {
    let mut random = Random(23);
    let (mut worst, mut shortened, mut together, mut alone) = (f64::NEG_INFINITY, 0, 0, 0);
    for run in 0..120 {
        let robot = &robots()[run % robots().len()];
        let kind = KINDS[random.below(2)];
        let touches = run >= 60;
        let period = [5e-4, 1e-3, 5e-3, 2e-2, 5e-2][random.below(5)];
        let within = |random: &mut Random, joint: &Joint| {
            let [lower, upper] = joint.limits.resting_range().map(|end| end.clamp(-3.0, 3.0));
            0.5 * (lower + upper + random.signed() * (upper - lower))
        };
        let mut arm = Loop::at_rest(&robot.joints().iter().map(|joint| within(&mut random, joint)).collect::<Vec<_>>());
        for _ in 0..6 {
            // Targets on both sides of the limits; a new one every 50 periods.
            let target: Vec<f64> =
                robot.joints().iter().map(|joint| 1.5 * within(&mut random, joint) + 0.5 * random.signed()).collect();
            let controller = posture(robot, (0..robot.joint_count()).collect(), &target, (kind, period), touches);
            if let Some(memory) = &mut arm.memory {
                memory.active_set.clear();
            }
            for _ in 0..50 {
                let (q, last) = (arm.q.clone(), last_command(&arm, robot));
                let command = arm.step(&controller, [0.0; 6]);
                let (valid, velocity) = (stated(&command.hold), command.resolution.joint_velocity.as_slice());
                assert!(valid >= spare_time(period) - 1e-3, "{valid}");
                let latency = 0.5 * (1.0 + random.signed()) * spare_time(period);
                let interval = period * [0.3, 1.0, 2.0][random.below(3)];
                worst = worst.max(furthest(robot, &q, &last, (velocity, &command.hold), latency, interval));
                shortened += usize::from(valid < VALID);
                together += usize::from(command.hold.stop_time_s.is_some());
                alone += usize::from(touches && command.hold.stop_time_s.is_none());
            }
        }
    }
    println!("{worst} {shortened} {together} {alone}");
    assert!(worst <= TOLERANCE, "{worst} rad outside");
    assert!(together > 800 && alone > 300, "{together} stops of all joints, {alone} of each");
    assert!(worst > -1e-3 && shortened > 300, "no run comes near a limit: {worst} rad, {shortened}");
}

#[test]
fn an_arm_that_moves_too_fast_to_stop_is_reported() {
    let robot = sawyer();
    let limits = robot.joints()[0].limits;
    let controller = posture(&robot, vec![0], &[0.0], (LimitKind::PositionVelocity, 1e-3), false);
    let mut state = measurement(&middle(&robot));
    state.joint_position[0] = limits.upper - 0.1;
    let too_fast = |speed: f64| {
        let mut velocity = vec![0.0; 7];
        velocity[0] = speed;
        let measured = revprio_core::controller::Measurement { joint_velocity: Some(velocity), ..state.clone() };
        step(&controller, &mut None, &measured).unwrap().hold.too_fast
    };
    let threshold = (2.0 * limits.acceleration * 0.101_f64).sqrt();
    assert_eq!(too_fast(0.999 * threshold), [0_usize; 0]);
    assert_eq!(too_fast(1.001 * threshold), [0]);
    assert_eq!(too_fast(-1.5), [0_usize; 0]);
}

#[test]
fn limits_without_positions_do_not_shorten_the_hold() {
    let robot = sawyer();
    for kind in [LimitKind::None, LimitKind::Velocity] {
        let controller = posture(&robot, vec![0], &[10.0], (kind, 1e-3), false);
        let mut arm = Loop::at_rest(&middle(&robot));
        (0..20).for_each(|_| assert_eq!(arm.step(&controller, [0.0; 6]).hold.time_s, f64::INFINITY));
    }
}
