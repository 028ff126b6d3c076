//! Position laws that brake before their target, on arms with drives that follow exactly or with lag and delay.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::controller::{
    BRAKING_SHARE, Controller, ControllerConfig, Limits, Measurement, Memory, NullSpaceMotion, Stepper, TaskConfig,
};
use revprio_core::law::{Braking, Law, PositionLaw};
use revprio_core::limits::{Drive, LimitKind};
use revprio_core::linalg::Vector;
use revprio_core::rows::{JointRows, JointTarget, TargetPose, TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{Joint, JointLimits, RobotModel, built_in};

use super::arms::{Random, constant, gantry, position, task, tool_rows, with_jerk};
use super::drives::LaggingArm;

const DRIVES: [Drive; 3] =
    [Drive::IDEAL, Drive { lag_s: 0.02, delay_periods: 1 }, Drive { lag_s: 0.03, delay_periods: 2 }];
const ROBOTS: [&str; 3] = ["panda", "ur5e", "sawyer"];

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
const ANGULAR: [Axis; 3] = [Axis::Rx, Axis::Ry, Axis::Rz];

/// Length of a step, m.
const STEP: f64 = 0.3;

/// Largest error of a measured position, rad.
const NOISE: f64 = 1e-4;

/// Returns the number of periods in a duration, both in s.
pub(super) fn periods(duration: f64, period: f64) -> u32 {
    (0..1_000_000_u32).find(|i| f64::from(*i) * period >= duration).unwrap()
}

/// The greatest excess over the target along the step, and the distance at the end, m.
#[derive(Debug, Clone, Copy)]
struct Approach {
    overshoot: f64,
    left: f64,
    /// RMS of the fastest joint's command in the last 0.2 s, rad/s.
    command: f64,
}

/// One step of the tool along a line that the arm can follow.
struct ToolStep {
    robot: Arc<RobotModel>,
    start: Vec<f64>,
    direction: Vector3<f64>,
}

fn pose(robot: &RobotModel, q: &[f64]) -> IsometryMatrix3<f64> {
    *Configuration::new(robot, q).unwrap().tool_pose()
}

impl ToolStep {
    fn goal(&self) -> IsometryMatrix3<f64> {
        let mut goal = pose(&self.robot, &self.start);
        goal.translation.vector += self.direction * STEP;
        goal
    }

    /// Returns the distance that is left, m.
    fn left(&self, arm: &LaggingArm) -> f64 {
        (pose(&self.robot, &arm.q).translation.vector - self.goal().translation.vector).norm()
    }

    /// Returns the tasks of the step: one of six rows, or position above orientation.
    fn tasks(&self, gain: f64, split: bool, braking: &Braking) -> Vec<TaskConfig> {
        let rows: &[&[Axis]] = if split { &[&LINEAR, &ANGULAR] } else { &[&Axis::ALL] };
        let to_goal = |axes: &&[Axis]| {
            let law = PositionLaw::with_braking(vec![gain; axes.len()], braking.clone()).unwrap();
            let rows = ToolRows { target_pose: TargetPose::Fixed(self.goal()), ..tool_rows(axes) };
            TaskConfig { rows: TaskRows::Tool(rows), ..task(axes, Law::Position(law)) }
        };
        rows.iter().map(to_goal).collect()
    }

    fn controller(&self, tasks: Vec<TaskConfig>, period: f64, stated: Drive) -> Controller {
        let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
        let config = ControllerConfig::new(Arc::clone(&self.robot), period, tasks);
        Controller::new(ControllerConfig { limits, drive: stated, ..config }).unwrap()
    }

    fn run(&self, controller: Controller, duration: f64, drive: Drive, noise: f64) -> Approach {
        let period = controller.config().period_s;
        let mut stepper = Stepper::new(controller).unwrap();
        let mut arm = LaggingArm::at_rest(&self.start, drive, noise, 1);
        let mut memory = None;
        let goal = self.goal().translation.vector;
        let mut found = Approach { overshoot: f64::NEG_INFINITY, left: 0.0, command: 0.0 };
        let (mut squares, mut resting) = (0.0, 0.0);
        for i in 0..periods(duration, period) {
            let command = step_arm(&mut stepper, &mut memory, &mut arm, f64::from(i) * period);
            if f64::from(i) * period > duration - 0.2 {
                squares += command.iter().fold(0.0_f64, |largest, speed| largest.max(speed.abs())).powi(2);
                resting += 1.0;
            }
            let beyond = pose(&self.robot, &arm.q).translation.vector - goal;
            found.overshoot = found.overshoot.max(beyond.dot(&self.direction));
            found.left = self.left(&arm);
        }
        Approach { command: (squares / resting).sqrt(), ..found }
    }
}

/// Moves the arm for one period and returns the command.
fn step_arm(stepper: &mut Stepper, memory: &mut Option<Memory>, arm: &mut LaggingArm, time_s: f64) -> Vec<f64> {
    let period = stepper.controller().config().period_s;
    let measurement = arm.measure(time_s);
    let command = stepper.step(memory, &measurement).unwrap().resolution.joint_velocity.as_slice().to_vec();
    arm.follow(&command, period);
    command
}

/// Returns whether the arm can follow the line far from singularities and from its position limits.
fn is_free(step: &ToolStep) -> bool {
    let period = 0.01;
    let mut stepper =
        Stepper::new(step.controller(step.tasks(3.0, false, &Braking::Joints), period, Drive::IDEAL)).unwrap();
    let (mut arm, mut memory) = (LaggingArm::at_rest(&step.start, Drive::IDEAL, 0.0, 1), None);
    for i in 0..400 {
        step_arm(&mut stepper, &mut memory, &mut arm, f64::from(i) * period);
        let command = stepper.step(
            &mut memory.clone(),
            &Measurement {
                channels: Vec::new(),
                chunks: Vec::new(),
                wrenches: Vec::new(),
                obstacles: Vec::new(),
                time_s: 0.0,
                joint_position: arm.q.clone(),
                joint_velocity: None,
                wrench: [0.0; 6],
                targets: Vec::new(),
            },
        );
        let smallest = command.unwrap().resolution.singularity.smallest_singular_value();
        let inside = |(joint, q): (&Joint, &f64)| (joint.limits.upper - q).min(q - joint.limits.lower) > 0.3;
        if smallest < 0.08 || !step.robot.joints().iter().zip(&arm.q).all(inside) {
            return false;
        }
    }
    step.left(&arm) < 1e-3
}

fn robot(name: &str) -> Arc<RobotModel> {
    Arc::clone(built_in().iter().find(|robot| robot.name() == name).unwrap())
}

/// Returns steps of a robot from random postures in random directions.
fn steps(name: &str, count: usize) -> Vec<ToolStep> {
    let mut random = Random(17);
    let mut found = Vec::new();
    while found.len() < count {
        let robot = robot(name);
        let start = |joint: &Joint| {
            let (lower, upper) = (joint.limits.lower.max(-3.0), joint.limits.upper.min(3.0));
            0.5 * (lower + upper + random.signed() * (upper - lower))
        };
        let start = robot.joints().iter().map(start).collect();
        let direction = Vector3::from_fn(|_, _| random.signed()).normalize();
        let step = ToolStep { robot, start, direction };
        if is_free(&step) {
            found.push(step);
        }
    }
    found
}

fn assert_steps_end_without_overshoot(name: &str) {
    for (i, step) in steps(name, 4).iter().enumerate() {
        for drive in DRIVES {
            for (period, gains) in [(1e-3, &[2.0, 10.0, 50.0][..]), (4e-3, &[5.0, 20.0, 50.0]), (1e-2, &GAINS)] {
                for (&gain, stated) in gains.iter().flat_map(|gain| [(gain, drive), (gain, Drive::CONSERVATIVE)]) {
                    let controller = step.controller(step.tasks(gain, i % 2 == 0, &Braking::Joints), period, stated);
                    let found = step.run(controller, 1.5 + 10.0 / gain, drive, 0.0);
                    let context = || format!("{name} {i}, {drive:?} stated as {stated:?}, T {period} s, gain {gain}");
                    assert!(found.overshoot <= 0.01 * STEP && found.left <= 1e-3, "{}: {found:?}", context());
                }
            }
        }
    }
}

/// Random gains, periods and drives: with noise too, no step overshoots, and the arm is calm at its end.
#[test]
fn steps_end_calmly_behind_every_drive() {
    let mut random = Random(3);
    let [mut overshoot, mut command] = [[0.0_f64; 2]; 2];
    for name in ROBOTS {
        let steps = steps(name, 4);
        for case in 0..120 {
            let step = &steps[random.below(steps.len())];
            let period = 1e-3 * 10_f64.powf(random.signed().abs());
            let gain = 2.0 * 25_f64.powf(random.signed().abs());
            let lag_s = if random.below(5) == 0 { 0.0 } else { 0.03 * random.signed().abs() };
            let drive = Drive { lag_s, delay_periods: random.below(3) };
            let stated = [drive, Drive::CONSERVATIVE][case % 2];
            let noisy = usize::from(case % 4 < 2);
            let noise = [0.0, NOISE][noisy];
            let controller = step.controller(step.tasks(gain, random.below(2) == 0, &Braking::Joints), period, stated);
            let found = step.run(controller, 3.0 + 12.0 / gain, drive, noise);
            let context =
                || format!("{name}, {drive:?} stated as {stated:?}, T {period} s, gain {gain}, noise {noise}");
            assert!(found.overshoot <= 0.01 * STEP + 10.0 * noise, "{}: {found:?}", context());
            assert!(found.left <= 1e-3 + 10.0 * noise, "{}: {found:?}", context());
            assert!(found.command <= 0.01 + 20.0 * gain * noise, "{}: {found:?}", context());
            overshoot[noisy] = overshoot[noisy].max(found.overshoot);
            command[noisy] = command[noisy].max(found.command / gain);
        }
    }
    println!("without and with noise: overshoot {overshoot:?} m, command at rest over gain {command:?} rad");
}

const GAINS: [f64; 5] = [2.0, 5.0, 10.0, 20.0, 50.0];

#[test]
fn steps_of_panda_end_without_overshoot_for_any_gain() {
    assert_steps_end_without_overshoot("panda");
}

#[test]
fn steps_of_ur5e_end_without_overshoot_for_any_gain() {
    assert_steps_end_without_overshoot("ur5e");
}

#[test]
fn steps_of_sawyer_end_without_overshoot_for_any_gain() {
    assert_steps_end_without_overshoot("sawyer");
}

#[test]
fn steps_of_arms_with_jerk_limits_end_without_overshoot() {
    for (name, rise) in [("panda", 0.02), ("ur5e", 0.1), ("sawyer", 0.05)] {
        for (i, step) in steps(name, 2).into_iter().enumerate() {
            let step = ToolStep { robot: Arc::new(with_jerk(&step.robot, rise)), ..step };
            for drive in DRIVES {
                for (period, gain) in
                    [1e-3, 1e-2].into_iter().flat_map(|period| [2.0, 10.0, 50.0].map(|gain| (period, gain)))
                {
                    let controller = step.controller(step.tasks(gain, i % 2 == 0, &Braking::Joints), period, drive);
                    let found = step.run(controller, 2.5 + 10.0 / gain, drive, 0.0);
                    let context = format!("{name}, step {i}, {drive:?}, period {period} s, gain {gain}: {found:?}");
                    println!("{context}");
                    assert!(found.overshoot <= 0.01 * STEP && found.left <= 1e-3, "{context}");
                }
            }
        }
    }
}

#[test]
fn the_bare_gain_overshoots() {
    for name in ROBOTS {
        let overshoot = |step: &ToolStep| {
            let controller = step.controller(step.tasks(20.0, false, &Braking::None), 4e-3, Drive::IDEAL);
            step.run(controller, 2.0, Drive::IDEAL, 0.0).overshoot
        };
        let largest = steps(name, 4).iter().map(overshoot).fold(0.0, f64::max);
        assert!(largest > 0.05 * STEP, "{name}: {largest} m");
    }
}

/// Prints the table of docs/guides/choose-gains.md.
#[test]
#[ignore = "asserts nothing; prints the table of docs/guides/choose-gains.md"]
fn overshoot_table() {
    for drive in DRIVES {
        for period in [1e-3, 1e-2] {
            for gain in GAINS {
                let largest = |stated: Drive, braking: &Braking| {
                    let overshoot = |(i, step): (usize, &ToolStep)| {
                        let controller = step.controller(step.tasks(gain, i % 2 == 0, braking), period, stated);
                        step.run(controller, 1.5 + 10.0 / gain, drive, 0.0).overshoot
                    };
                    let steps = ROBOTS.iter().map(|name| steps(name, 4));
                    let each = steps.flat_map(|steps| steps.iter().enumerate().map(overshoot).collect::<Vec<_>>());
                    100.0 / STEP * each.fold(0.0, f64::max)
                };
                let exact = largest(drive, &Braking::Joints);
                let default = largest(Drive::CONSERVATIVE, &Braking::Joints);
                let bare = largest(drive, &Braking::None);
                println!(
                    "{drive:?}, period {period} s, gain {gain}: {exact:.2} %, by default {default:.2} %, bare {bare:.1} %"
                );
            }
        }
    }
}

#[test]
fn without_the_acceleration_box_no_joint_brakes_harder_than_the_share_of_two_tasks() {
    for name in ROBOTS {
        for step in steps(name, 2) {
            for split in [false, true] {
                let controller = step.controller(step.tasks(20.0, split, &Braking::Joints), 1e-3, Drive::IDEAL);
                let limits = Limits::Robot(LimitKind::PositionVelocity);
                let config = ControllerConfig { limits, ..controller.config().clone() };
                let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
                let (mut arm, mut memory) = (LaggingArm::at_rest(&step.start, Drive::IDEAL, 0.0, 1), None);
                let mut before: Option<Vec<f64>> = None;
                for i in 0..3000 {
                    let velocity = step_arm(&mut stepper, &mut memory, &mut arm, f64::from(i) * 1e-3);
                    for (joint, (now, last)) in velocity.iter().zip(before.iter().flatten()).enumerate() {
                        let deceleration = (last.abs() - now.abs()) / 1e-3;
                        let limit = step.robot.joints()[joint].limits.acceleration;
                        // Farther away, at full speed, curved joint paths demand more, whatever the law does.
                        let is_braking = step.left(&arm) < 0.1;
                        let context = || format!("{name}, period {i}, joint {joint}: {deceleration} rad/s²");
                        assert!(!is_braking || deceleration <= 0.8 * limit, "{}", context());
                    }
                    before = Some(velocity);
                }
            }
        }
    }
}

fn posture(joints: &[usize], target: &[f64], law: PositionLaw) -> TaskConfig {
    let rows = JointRows { joints: joints.to_vec(), target: JointTarget::Position(constant(target)) };
    TaskConfig {
        name: "posture".to_owned(),
        rows: TaskRows::Joints(rows),
        law: Law::Position(law),
        scaled: false,
        streaming: Streaming::default(),
    }
}

fn with_limits(robot: &Arc<RobotModel>, period: f64, limits: LimitKind, drive: Drive, task: TaskConfig) -> Stepper {
    let config = ControllerConfig::new(Arc::clone(robot), period, vec![task]);
    let config = ControllerConfig { limits: Limits::Robot(limits), drive, ..config };
    Stepper::new(Controller::new(config).unwrap()).unwrap()
}

#[test]
fn postures_are_reached_without_overshoot_for_any_gain() {
    let limits = LimitKind::PositionVelocityAcceleration;
    for name in ROBOTS {
        let robot = robot(name);
        let middle = |joint: &Joint| 0.5 * (joint.limits.lower + joint.limits.upper);
        let start: Vec<f64> = robot.joints().iter().map(|joint| middle(joint) - 0.5).collect();
        let target: Vec<f64> = start.iter().map(|q| q + 1.0).collect();
        let joints: Vec<usize> = (0..start.len()).collect();
        for (drive, stated) in DRIVES.into_iter().flat_map(|drive| [(drive, drive), (drive, Drive::CONSERVATIVE)]) {
            for (period, gain) in [1e-3, 1e-2].into_iter().flat_map(|period| GAINS.map(|gain| (period, gain))) {
                let law = PositionLaw::new(vec![gain; start.len()]).unwrap();
                let mut stepper = with_limits(&robot, period, limits, stated, posture(&joints, &target, law));
                let (mut arm, mut memory) = (LaggingArm::at_rest(&start, drive, 0.0, 1), None);
                let duration = 2.0 + 12.0 / gain;
                for i in 0..periods(duration, period) {
                    step_arm(&mut stepper, &mut memory, &mut arm, f64::from(i) * period);
                    let beyond = arm.q.iter().zip(&target).map(|(q, goal)| q - goal).fold(f64::MIN, f64::max);
                    assert!(beyond <= 0.01, "{name}, {drive:?}, period {period} s, gain {gain}: {beyond} rad");
                }
                assert!(arm.q.iter().zip(&target).all(|(q, goal)| (q - goal).abs() < 1e-3), "{name}: {:?}", arm.q);
            }
        }
    }
}

#[test]
fn postures_in_the_null_space_are_reached_without_overshoot() {
    for (name, drive) in ROBOTS.into_iter().flat_map(|name| DRIVES.map(|drive| (name, drive))) {
        for (stated, gain) in [(drive, 5.0), (drive, 50.0), (Drive::CONSERVATIVE, 20.0)] {
            let robot = robot(name);
            let start: Vec<f64> =
                robot.joints().iter().map(|joint| 0.5 * (joint.limits.lower + joint.limits.upper) - 0.5).collect();
            let hold = posture(&[0], &start[..1], PositionLaw::new(vec![5.0]).unwrap());
            let target: Vec<f64> = start.iter().map(|q| q + 1.0).collect();
            let null_space = Some(NullSpaceMotion::Posture { joint_position: target.clone(), gain });
            let config = ControllerConfig::new(Arc::clone(&robot), 1e-2, vec![hold]);
            let controller = Controller::new(ControllerConfig { drive: stated, null_space, ..config }).unwrap();
            let mut stepper = Stepper::new(controller).unwrap();
            let (mut arm, mut memory) = (LaggingArm::at_rest(&start, drive, 0.0, 1), None);
            for i in 0..600_u32 {
                step_arm(&mut stepper, &mut memory, &mut arm, f64::from(i) * 1e-2);
                let beyond = arm.q.iter().zip(&target).map(|(q, goal)| q - goal).fold(f64::MIN, f64::max);
                assert!(beyond <= 0.01, "{name}, {drive:?} stated as {stated:?}, gain {gain}: {beyond} rad");
            }
            let left = arm.q.iter().zip(&target).skip(1).map(|(q, goal)| (q - goal).abs()).fold(0.0, f64::max);
            assert!(left < 1e-3, "{name}, {drive:?} stated as {stated:?}, gain {gain}: {left} rad left");
        }
    }
}

#[test]
fn small_errors_are_corrected_by_the_bare_gain_to_the_last_bit() {
    for step in steps("sawyer", 2) {
        for gain in [2.0, 20.0] {
            let near = ToolStep {
                robot: Arc::clone(&step.robot),
                start: step.start.clone(),
                direction: step.direction * 3e-3,
            };
            let command = |braking| {
                let mut stepper =
                    Stepper::new(near.controller(near.tasks(gain, true, &braking), 1e-3, Drive::IDEAL)).unwrap();
                let mut arm = LaggingArm::at_rest(&near.start, Drive::IDEAL, 0.0, 1);
                step_arm(&mut stepper, &mut None, &mut arm, 0.0)
            };
            assert_eq!(command(Braking::Joints), command(Braking::None));
        }
    }
}

/// Returns the distances and speeds of a gantry joint with a step of 1 m and the gain 10.
fn approach(limits: JointLimits, braking: Braking) -> Vec<(f64, f64)> {
    let law = PositionLaw::with_braking(vec![10.0], braking).unwrap();
    let task = posture(&[0], &[1.0], law);
    let mut stepper = with_limits(&gantry(limits), 1e-3, LimitKind::PositionVelocity, Drive::IDEAL, task);
    let (mut arm, mut memory) = (LaggingArm::at_rest(&[0.0; 3], Drive::IDEAL, 0.0, 1), None);
    (0..4000)
        .map(|i| {
            let distance = 1.0 - arm.q[0];
            (distance, step_arm(&mut stepper, &mut memory, &mut arm, f64::from(i) * 1e-3)[0])
        })
        .collect()
}

fn largest_deceleration(approach: &[(f64, f64)]) -> f64 {
    approach.windows(2).map(|pair| (pair[0].1 - pair[1].1) / 1e-3).fold(0.0, f64::max)
}

#[test]
fn the_law_can_state_its_own_acceleration() {
    for limits in [JointLimits::NONE, JointLimits { acceleration: 8.0, velocity: 2.0, ..JointLimits::NONE }] {
        let own = approach(limits, Braking::AtMost(Vector::from_element(1, 0.5)));
        let found = largest_deceleration(&own);
        assert!(found > 0.4 && found <= 0.5, "{found} m/s²");
        assert!(own.last().unwrap().0.abs() < 1e-3, "{:?}", own.last());
    }
}

#[test]
fn joints_without_acceleration_limit_brake_with_the_default_and_those_without_limits_have_the_bare_gain() {
    let slow = JointLimits { velocity: 0.5, ..JointLimits::NONE };
    let found = largest_deceleration(&approach(slow, Braking::Joints));
    // 0.5 m/s in 0.25 s, of which the law uses its share.
    assert!(found > 0.9 * BRAKING_SHARE * 2.0 && found <= BRAKING_SHARE * 2.0, "{found} m/s²");
    for (distance, speed) in approach(JointLimits::NONE, Braking::Joints) {
        assert_eq!(speed, 0.0 - 10.0 * -distance);
    }
}

#[test]
fn gains_above_the_ratio_of_acceleration_and_speed_are_found() {
    let robot = robot("panda");
    // A/V of the joints: 6.9, 3.4, 4.6, 5.7, 5.7, 7.7, 7.7 1/s.
    let found = |task: TaskConfig| {
        let config = ControllerConfig::new(Arc::clone(&robot), 1e-3, vec![task]);
        config.steep_gains().map(|found| (found.joint.to_owned(), found.gain, found.brakes)).collect::<Vec<_>>()
    };
    let law = |gain: f64| PositionLaw::new(vec![gain; 3]).unwrap();
    assert_eq!(found(task(&LINEAR, position(3, 3.4))), []);
    assert_eq!(found(task(&LINEAR, position(3, 5.0))), [("panda_joint2".to_owned(), 5.0, true)]);
    assert_eq!(found(posture(&[0, 5, 6], &[0.0; 3], law(6.5))), []);
    assert_eq!(found(posture(&[0, 5, 6], &[0.0; 3], law(7.0))), [("panda_joint1".to_owned(), 7.0, true)]);
    let bare = PositionLaw::with_braking(vec![7.0], Braking::None).unwrap();
    assert_eq!(found(posture(&[0], &[0.0], bare)), [("panda_joint1".to_owned(), 7.0, false)]);
}
