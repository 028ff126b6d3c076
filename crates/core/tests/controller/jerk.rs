//! Joints with a jerk limit: it is kept, the arm stays calm at its limits, and it reaches the velocities of its tasks.

use std::sync::Arc;

use revprio_core::controller::{
    Controller, ControllerConfig, Limits, Measurement, Memory, MemoryError, Stepper, TaskConfig,
};
use revprio_core::limits::{Drive, LimitKind};
use revprio_core::linalg::Vector;
use revprio_core::streaming::{StreamedTarget, StreamedValue};
use revprio_robot::kinematics::Axis;
use revprio_robot::{RobotModel, built_in};

use super::arms::{Loop, Random, constant, position, ranged_arms, task, with_jerk};
use super::braking::periods;
use super::drives::{COMMAND, Calm, LaggingArm, NOISE, OVERSHOOT, SWING, drives, posture, run};
use super::hold::{mid_ranges, middle};
use super::transition::random_config;

/// Times in which the acceleration may rise from 0 to its limit, A/J, s.
const RISE_TIMES: [f64; 3] = [0.01, 0.05, 0.2];

const PERIODS: [f64; 3] = [0.001, 0.004, 0.01];

fn robot(number: usize) -> RobotModel {
    let arms = ranged_arms();
    with_jerk(&arms[number % arms.len()], RISE_TIMES[number % RISE_TIMES.len()])
}

#[test]
fn joints_approach_their_limits_and_rest_there_behind_every_drive() {
    let mut worst = [Calm::default(), Calm::default()];
    let mut runs = 0;
    for (drive, period) in drives().flat_map(|drive| PERIODS.map(|period| (drive, period))) {
        for stated in [drive, Drive::CONSERVATIVE] {
            for (worst, noise) in worst.iter_mut().zip([0.0, NOISE]) {
                runs += 1;
                let robot = Arc::new(robot(runs));
                let joint = runs / 7 % robot.joint_count();
                let [lowest, highest] = robot.joints()[joint].limits.resting_range();
                let (end, outwards) = if runs % 2 == 0 { (lowest, -1.0) } else { (highest, 1.0) };
                let kind = LimitKind::PositionVelocityAcceleration;
                let controller = posture(&robot, joint, end + outwards, kind, stated, period);
                let mut start = mid_ranges(&robot);
                start[joint] = end - 0.3 * outwards;
                let mut arm = LaggingArm::at_rest(&start, drive, noise, runs as u64);
                let calm = run(&controller, &mut arm, |q| (q[joint] - highest).max(lowest - q[joint]));
                let name = format!(
                    "{} {joint}, T {period}, noise {noise}, {drive:?} stated as {stated:?}: {calm:?}",
                    robot.name()
                );
                assert!(calm.distance.abs() < 1e-3, "{name}");
                assert!(calm.overshoot <= OVERSHOOT + 10.0 * noise, "{name}");
                assert!(calm.swing <= SWING + 10.0 * noise && calm.command <= COMMAND, "{name}");
                assert_eq!(calm.conflicts, 0, "{name}");
                worst.add(&calm);
            }
        }
    }
    println!("without and with noise: {worst:?}");
}

/// Noise is no contradiction of limits: nothing is reported in 10 s, and each joint keeps its jerk.
#[test]
fn a_long_noisy_rest_on_a_limit_keeps_the_jerk_and_reports_no_conflict() {
    let drives = [Drive::IDEAL, Drive { lag_s: 0.01, delay_periods: 1 }, Drive::CONSERVATIVE];
    for (number, drive) in drives.into_iter().enumerate() {
        let (robot, period) = (Arc::new(robot(number + 1)), 0.001);
        for upper in [false, true] {
            let limits = robot.joints()[number].limits;
            let (end, outwards) = if upper { (limits.upper, 1.0) } else { (limits.lower, -1.0) };
            let kind = LimitKind::PositionVelocityAcceleration;
            let controller = posture(&robot, number, end + outwards, kind, drive, period);
            let mut start = middle(&robot);
            start[number] = end - 0.01 * outwards;
            let mut arm = LaggingArm::at_rest(&start, drive, NOISE, 1);
            // The limit must be reached.
            let mut found = Use { position: f64::NEG_INFINITY, ..Use::default() };
            let (mut stepper, mut memory) = (Stepper::new(controller).unwrap(), None);
            let (mut commands, mut shortest) = (vec![vec![0.0; start.len()]; 2], f64::INFINITY);
            for period_number in 0..10_000 {
                let measured = arm.measure(f64::from(period_number) * period);
                let command = stepper.step(&mut memory, &measured).unwrap();
                assert!(command.hold.too_fast.is_empty(), "{:?}", command.hold);
                shortest = shortest.min(command.hold.time_s);
                commands.insert(0, command.resolution.joint_velocity.as_slice().to_vec());
                arm.follow(&commands[0], period);
                found.add(&robot, &arm.q, [&commands[0], &commands[1], &commands[2]], &command.limit_conflicts, period);
                commands.truncate(2);
            }
            let name = format!("{} {number} {drive:?}", robot.name());
            assert!(found.position <= NOISE && found.position > -NOISE, "{name}: {found:?}");
            assert!(found.jerk > 0.99, "{name}: {found:?}");
            Use { position: 0.0, ..found }.assert_kept(&name);
            assert!(shortest >= 0.01 - 1e-9, "{name}: a command may be held for {shortest} s");
        }
    }
}

/// Largest excesses of a run over the limits, relative to them, and periods in which a joint is near its limits.
#[derive(Debug, Default, Clone, Copy)]
struct Use {
    position: f64,
    speed: f64,
    acceleration: f64,
    jerk: f64,
    conflicts: usize,
}

impl Use {
    /// Adds a period; `commands`: the last three, the newest first.
    fn add(&mut self, robot: &RobotModel, q: &[f64], commands: [&[f64]; 3], conflicts: &[usize], period: f64) {
        for (i, joint) in robot.joints().iter().enumerate() {
            let limits = &joint.limits;
            let [v, last, before] = commands.map(|command| command[i]);
            self.position = self.position.max((q[i] - limits.upper).max(limits.lower - q[i]));
            self.speed = self.speed.max(v.abs() / limits.velocity);
            self.acceleration = self.acceleration.max((v - last).abs() / (limits.acceleration * period));
            self.jerk = self.jerk.max((v - 2.0 * last + before).abs() / (limits.jerk * period * period));
        }
        self.conflicts += conflicts.len();
    }

    fn assert_kept(&self, name: &str) {
        let rounding = 1.0 + 1e-6;
        assert!(self.position <= 1e-9 && self.speed <= rounding && self.acceleration <= rounding, "{name}: {self:?}");
        assert!(self.jerk <= rounding && self.conflicts == 0, "{name}: {self:?}");
    }
}

/// Runs random tasks that change without notice every `interval` periods, on an arm with a drive.
fn random_run(robot: &Arc<RobotModel>, drive: Drive, period: f64, seed: u64) -> Use {
    let (random, interval, n) = (&mut Random(seed), 120, robot.joint_count());
    let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
    let mut config = || {
        let config = random_config(robot, &limits, random);
        Controller::new(ControllerConfig { drive, period_s: period, ..config }).unwrap()
    };
    let mut stepper = Stepper::new(config()).unwrap();
    let mut arm = LaggingArm::at_rest(&middle(robot), drive, 0.0, seed);
    let (mut memory, mut found) = (None::<Memory>, Use::default());
    let mut commands = vec![vec![0.0; n]; 2];
    for number in 0..8 * interval {
        let measured = arm.measure(f64::from(number) * period);
        if number % interval == 0
            && let Some(old) = &memory
        {
            let new = config();
            memory = Some(new.continue_from(stepper.controller(), old, &measured.joint_position).unwrap());
            stepper = Stepper::new(new).unwrap();
        }
        let command = stepper.step(&mut memory, &measured).unwrap();
        commands.insert(0, command.resolution.joint_velocity.as_slice().to_vec());
        arm.follow(&commands[0], period);
        found.add(robot, &arm.q, [&commands[0], &commands[1], &commands[2]], &command.limit_conflicts, period);
        commands.truncate(2);
    }
    found
}

#[test]
fn no_limit_is_exceeded_while_random_tasks_change() {
    let mut all = Use::default();
    for (number, drive) in drives().enumerate().filter(|(number, _)| number % 2 == 0) {
        for (which, period) in PERIODS.into_iter().enumerate() {
            let robot = Arc::new(robot(number / 2 + which));
            let found = random_run(&robot, drive, period, 1 + number as u64);
            found.assert_kept(&format!("{} {drive:?} T {period}", robot.name()));
            all.speed = all.speed.max(found.speed);
            all.acceleration = all.acceleration.max(found.acceleration);
            all.jerk = all.jerk.max(found.jerk);
        }
    }
    assert!(all.speed > 0.95 && all.acceleration > 0.99 && all.jerk > 0.99, "the tasks are too slow: {all:?}");
}

#[test]
fn no_limit_is_exceeded_by_targets_that_jump_across_a_joint_limit() {
    for (number, drive) in drives().enumerate() {
        for period in [0.001, 0.01] {
            let robot = Arc::new(robot(number));
            let (joint, n) = (number % robot.joint_count(), robot.joint_count());
            let upper = robot.joints()[joint].limits.upper;
            let kind = LimitKind::PositionVelocityAcceleration;
            let mut steppers = [upper + 1.0, upper - 0.2]
                .map(|target| Stepper::new(posture(&robot, joint, target, kind, drive, period)).unwrap());
            let mut start = middle(&robot);
            start[joint] = upper - 0.1;
            let mut arm = LaggingArm::at_rest(&start, drive, 0.0, 1);
            let (mut random, mut memory, mut found) = (Random(number as u64), None, Use::default());
            let (mut commands, mut current) = (vec![vec![0.0; n]; 2], 0);
            for number in 0..2000 {
                current = if random.below(if number < 700 { 7 } else { 40 }) == 0 { 1 - current } else { current };
                let measured = arm.measure(f64::from(number) * period);
                let command = steppers[current].step(&mut memory, &measured).unwrap();
                commands.insert(0, command.resolution.joint_velocity.as_slice().to_vec());
                arm.follow(&commands[0], period);
                found.add(&robot, &arm.q, [&commands[0], &commands[1], &commands[2]], &command.limit_conflicts, period);
                commands.truncate(2);
            }
            found.assert_kept(&format!("{} {joint} {drive:?} T {period}", robot.name()));
        }
    }
}

#[test]
fn no_limit_is_exceeded_by_streamed_targets_with_drop_outs() {
    let mut jerk = 0.0_f64;
    for (number, period) in PERIODS.into_iter().enumerate() {
        let robot = Arc::new(robot(3 + 5 * number));
        let (n, q) = (robot.joint_count(), middle(&robot));
        let mut posture_task = TaskConfig { name: "hand".to_owned(), ..task(&[Axis::X], position(n, 5.0)) };
        posture_task.rows = super::arms::joint_rows(&q);
        let drive = Drive { lag_s: 0.01, delay_periods: 1 };
        let config = ControllerConfig::new(Arc::clone(&robot), period, vec![posture_task]);
        let mut stepper = Stepper::new(Controller::new(ControllerConfig { drive, ..config }).unwrap()).unwrap();
        let mut arm = LaggingArm::at_rest(&q, drive, 0.0, 1);
        let (mut random, mut memory, mut found, mut next) = (Random(3), None, Use::default(), 0.0);
        let mut commands = vec![vec![0.0; n]; 2];
        for number in 0..3000 {
            let time_s = f64::from(number) * period;
            let mut measured = arm.measure(time_s);
            if time_s >= next {
                next += (1.0 + 0.4 * random.signed()) / 45.0;
                let target = q.iter().map(|q| q + 0.8 * random.signed()).collect();
                let value = StreamedValue::JointPosition(target);
                let target = StreamedTarget { task: 0, time_s, value, velocity: None, ahead: Vec::new() };
                measured.targets.extend((time_s % 1.6 < 1.0).then_some(target));
            }
            let command = stepper.step(&mut memory, &measured).unwrap();
            commands.insert(0, command.resolution.joint_velocity.as_slice().to_vec());
            arm.follow(&commands[0], period);
            found.add(&robot, &arm.q, [&commands[0], &commands[1], &commands[2]], &command.limit_conflicts, period);
            commands.truncate(2);
        }
        found.assert_kept(&format!("{} T {period}", robot.name()));
        jerk = jerk.max(found.jerk);
    }
    assert!(jerk > 0.99, "the targets are too slow: {jerk}");
}

/// Joints that start outside their ranges return inside all limits, behind every drive, and go no further out.
#[test]
fn joints_outside_their_ranges_return_inside_all_limits() {
    let mut all = Use::default();
    for (number, drive) in drives().enumerate() {
        for (which, (period, noise)) in
            PERIODS.into_iter().flat_map(|period| [(period, 0.0), (period, NOISE)]).enumerate()
        {
            let (robot, mut random) = (Arc::new(robot(number + which)), Random(1 + number as u64));
            let centre = middle(&robot);
            let sides: Vec<f64> = centre.iter().map(|_| random.signed().signum()).collect();
            let beyond: Vec<f64> = sides.iter().map(|side| side * 10_f64.powf(1.5 * random.signed() - 1.5)).collect();
            let limits = |i: usize| robot.joints()[i].limits;
            let end = |i: usize| if sides[i] > 0.0 { limits(i).upper } else { limits(i).lower };
            let start: Vec<f64> = (0..centre.len()).map(|i| end(i) + beyond[i]).collect();
            let mut homing = TaskConfig { name: "home".to_owned(), ..task(&[Axis::X], position(centre.len(), 2.0)) };
            homing.rows = super::arms::joint_rows(&centre);
            let config = ControllerConfig::new(Arc::clone(&robot), period, vec![homing]);
            let mut stepper = Stepper::new(Controller::new(ControllerConfig { drive, ..config }).unwrap()).unwrap();
            let mut arm = LaggingArm::at_rest(&start, drive, noise, number as u64);
            let (mut memory, mut found) = (None, Use::default());
            let mut commands = vec![vec![0.0; centre.len()]; 2];
            let name = format!("{} {drive:?} T {period}, noise {noise}, beyond {beyond:?}", robot.name());
            for period_number in 0..periods(4.0, period) {
                let command = stepper.step(&mut memory, &arm.measure(f64::from(period_number) * period)).unwrap();
                commands.insert(0, command.resolution.joint_velocity.as_slice().to_vec());
                arm.follow(&commands[0], period);
                found.add(&robot, &arm.q, [&commands[0], &commands[1], &commands[2]], &command.limit_conflicts, period);
                commands.truncate(2);
                let further = (0..centre.len()).map(|i| sides[i] * (arm.q[i] - start[i])).fold(0.0, f64::max);
                assert!(further <= 1e-12, "{name}: {further} further out at {period_number}");
            }
            Use { position: 0.0, ..found }.assert_kept(&name);
            let outside = (0..centre.len()).map(|i| sides[i] * (arm.q[i] - end(i))).fold(f64::NEG_INFINITY, f64::max);
            assert!(outside < 0.0, "{name}: {outside} outside");
            all.speed = all.speed.max(found.speed);
            all.jerk = all.jerk.max(found.jerk);
        }
    }
    assert!(all.speed > 0.99 && all.jerk > 0.99, "the returns are too slow: {all:?}");
}

/// Without the approach to the velocity of the task, the joints would swing for ever.
#[test]
fn joints_reach_a_posture_and_rest_there_for_any_gain() {
    let mut worst = 0.0_f64;
    for (number, rise) in RISE_TIMES.into_iter().enumerate() {
        let robot = Arc::new(with_jerk(&built_in()[[1, 2, 3][number]], rise));
        for (drive, period) in [Drive::IDEAL, Drive { lag_s: 0.02, delay_periods: 1 }]
            .into_iter()
            .flat_map(|drive| [0.001, 0.01].map(|period| (drive, period)))
        {
            for gain in [2.0, 5.0, 20.0] {
                let start: Vec<f64> = middle(&robot).iter().map(|q| q - 0.5).collect();
                let target: Vec<f64> = start.iter().map(|q| q + 1.0).collect();
                let mut posture = TaskConfig { ..task(&[Axis::X], position(start.len(), gain)) };
                posture.rows = super::arms::joint_rows(&target);
                let config = ControllerConfig::new(Arc::clone(&robot), period, vec![posture]);
                let mut stepper = Stepper::new(Controller::new(ControllerConfig { drive, ..config }).unwrap()).unwrap();
                let (mut arm, mut memory) = (LaggingArm::at_rest(&start, drive, 0.0, 1), None);
                for i in 0..periods(7.0, period) {
                    let command = stepper.step(&mut memory, &arm.measure(f64::from(i) * period)).unwrap();
                    arm.follow(command.resolution.joint_velocity.as_slice(), period);
                    let beyond = arm.q.iter().zip(&target).map(|(q, goal)| q - goal).fold(f64::MIN, f64::max);
                    worst = worst.max(beyond);
                    assert!(beyond <= 0.01, "{} {drive:?}, period {period} s, gain {gain}: {beyond}", robot.name());
                }
                let speed = memory.unwrap().last_command.amax();
                let left = arm.q.iter().zip(&target).map(|(q, goal)| (q - goal).abs()).fold(0.0, f64::max);
                let name = format!("{} {drive:?}, period {period} s, gain {gain}", robot.name());
                assert!(left < 1e-3 && speed < 1e-2, "{name}: {left} rad, {speed} rad/s");
            }
        }
    }
    println!("largest overshoot: {worst} rad");
}

fn one_task(robot: RobotModel) -> Controller {
    let velocity = revprio_core::law::Law::Velocity(constant(&[0.3]));
    Controller::new(ControllerConfig::new(Arc::new(robot), 0.001, vec![task(&[Axis::X], velocity)])).unwrap()
}

#[test]
fn the_memory_keeps_the_acceleration_and_may_omit_it() {
    let controller = one_task(robot(3));
    let mut arm = Loop::at_rest(&middle(&controller.config().robot));
    (0..5).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
    let memory = arm.memory.clone().unwrap();
    let state = memory.jerk.clone().unwrap();
    assert!(state.acceleration.amax() > 0.0 && state.requested.amax() > memory.last_command.amax());
    let (mut unknown, mut known) = (arm.clone(), arm.clone());
    unknown.memory = Some(Memory { jerk: None, ..memory.clone() });
    let change = |arm: &mut Loop| {
        let velocity = arm.step(&controller, [0.0; 6]).resolution.joint_velocity.clone();
        (velocity - &memory.last_command).amax()
    };
    // From rest the acceleration begins anew.
    assert!(change(&mut known) > 4.0 * change(&mut unknown));
    let mut damaged = Some(Memory {
        jerk: Some(revprio_core::controller::JerkState { acceleration: Vector::zeros(2), ..state }),
        ..memory
    });
    let measured: Measurement = arm.measurement(0.001, [0.0; 6]);
    let error = Stepper::new(controller).unwrap().step(&mut damaged, &measured).unwrap_err();
    assert_eq!(error, revprio_core::controller::StepError::Memory(MemoryError::Jerk));
}

#[test]
fn a_robot_without_jerk_limit_remembers_none() {
    let controller = one_task((*built_in()[1]).clone());
    let mut arm = Loop::at_rest(&middle(&controller.config().robot));
    arm.step(&controller, [0.0; 6]);
    assert_eq!(arm.memory.unwrap().jerk, None);
}
