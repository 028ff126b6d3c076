//! Joints that do not follow their commands: brakes are found, and nothing else is taken for them.

use std::sync::Arc;

use revprio_core::controller::{
    Controller, ControllerConfig, Limits, Measurement, Memory, MemoryError, Stall, StalledJoint, StepError, Stepper,
    TaskConfig,
};
use revprio_core::law::{ForceLaw, Gains, Law};
use revprio_core::limits::{Drive, LimitKind};
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{Joint, RobotModel, built_in};

use super::arms::{
    NOMINAL, Random, config, constant, controller, joint_rows, measurement, position, sawyer, step, task,
};
use super::drives::{LaggingArm, NOISE};
use super::hold::middle;

/// Drives of the arm, and those that its controller states.
const DRIVES: [(Drive, Drive); 6] = [
    (Drive::IDEAL, Drive::IDEAL),
    (Drive::IDEAL, Drive::CONSERVATIVE),
    (Drive { lag_s: 0.02, delay_periods: 1 }, Drive { lag_s: 0.02, delay_periods: 1 }),
    (Drive::CONSERVATIVE, Drive::CONSERVATIVE),
    (Drive { lag_s: 0.1, delay_periods: 3 }, Drive::CONSERVATIVE),
    (Drive { lag_s: 0.1, delay_periods: 8 }, Drive { lag_s: 0.1, delay_periods: 8 }),
];

/// A run of an arm whose joints brakes can hold.
struct Run {
    arm: LaggingArm,
    stepper: Stepper,
    memory: Option<Memory>,
    period: f64,
    periods: u32,
}

impl Run {
    fn new(controller: Controller, start: &[f64], drive: Drive, noise: f64, seed: u64) -> Self {
        let period = controller.config().period_s;
        let arm = LaggingArm::at_rest(start, drive, noise, seed);
        Self { arm, stepper: Stepper::new(controller).unwrap(), memory: None, period, periods: 0 }
    }

    fn time_s(&self) -> f64 {
        f64::from(self.periods) * self.period
    }

    /// Makes a period with brakes at some joints and a wrench; returns the command and the joints that are said to stall.
    fn step(&mut self, brakes: &[usize], wrench: [f64; 6]) -> (Vec<f64>, Vec<StalledJoint>) {
        let measured = Measurement { wrench, ..self.arm.measure(self.time_s()) };
        let command = self.stepper.step(&mut self.memory, &measured).unwrap();
        let (velocity, stalled) = (command.resolution.joint_velocity.as_slice().to_vec(), command.stalled.clone());
        let before = self.arm.q.clone();
        self.arm.follow(&velocity, self.period);
        for &joint in brakes {
            self.arm.q[joint] = before[joint];
        }
        self.periods += 1;
        (velocity, stalled)
    }
}

/// Returns a controller that moves all joints to a posture.
fn posture(robot: &Arc<RobotModel>, target: &[f64], gain: f64, period: f64, stated: Drive) -> Controller {
    let tasks = vec![TaskConfig { rows: joint_rows(target), ..task(&[Axis::X], position(target.len(), gain)) }];
    let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
    controller(ControllerConfig { period_s: period, drive: stated, limits, ..config(robot, tasks) })
}

#[test]
fn joints_that_a_brake_holds_are_named_after_half_a_second_until_they_move() {
    let mut random = Random(5);
    let mut latest = 0.0_f64;
    for (case, (drive, stated)) in DRIVES.iter().cycle().enumerate().take(48) {
        let robot = &built_in()[case % built_in().len()];
        let (period, noise) = ([1e-3, 1e-2][case % 2], [0.0, NOISE][(case / 2) % 2]);
        let start = middle(robot);
        let target: Vec<f64> = start.iter().map(|q| q + 0.4).collect();
        let gain = 1.0 + 2.0 * random.signed().abs();
        let mut run = Run::new(posture(robot, &target, gain, period, *stated), &start, *drive, noise, case as u64);
        let all: Vec<usize> = (0..start.len()).collect();
        let braked = if case % 3 == 0 { vec![random.below(start.len())] } else { all };
        let context = || format!("case {case}, {}, {drive:?} stated as {stated:?}", robot.name());
        let patience = 0.5 + stated.time_to_rest(period);
        let mut found_at = None;
        while run.time_s() < 1.5 {
            let time_s = run.time_s();
            let (_, stalled) = run.step(&braked, [0.0; 6]);
            let joints: Vec<usize> = stalled.iter().map(|found| found.joint).collect();
            assert!(joints.iter().all(|joint| braked.contains(joint)), "{}: {joints:?}", context());
            assert!(joints.is_empty() || time_s >= patience - period, "{}, after {time_s} s", context());
            if joints == braked {
                found_at.get_or_insert(time_s);
                let Stall { commanded, moved, time_s } = stalled[0].stall;
                assert!(commanded > 0.05 * time_s && moved.abs() < 0.1 * commanded + 1e-3, "{:?}", stalled[0]);
            }
        }
        let found_at = found_at.unwrap_or_else(|| panic!("{}: brakes of {braked:?} are not found", context()));
        latest = latest.max(found_at - patience);
        // Without brakes the joints move at once.
        let released = run.time_s();
        while run.time_s() < released + 1.0 {
            let (time_s, (_, stalled)) = (run.time_s(), run.step(&[], [0.0; 6]));
            assert!(stalled.is_empty() || time_s < released + 0.3, "{}: {stalled:?} after {time_s} s", context());
        }
    }
    println!("found at most {latest:.3} s after the time that the joints have");
    assert!(latest < 0.2, "{latest} s");
}

#[test]
fn free_joints_are_never_said_to_stall_at_targets_that_jump_beyond_limits() {
    let mut random = Random(11);
    let mut fast = 0;
    for case in 0..120 {
        let robot = &built_in()[case % built_in().len()];
        let (drive, stated) = DRIVES[case / 2 % DRIVES.len()];
        let (period, noise) = ([1e-3, 4e-3, 1e-2][case % 3], [0.0, NOISE][case % 2]);
        let start = middle(robot);
        let mut next = |interval: f64| {
            let mut reach = |joint: &Joint| {
                let half = 0.5 * (joint.limits.upper.min(3.0) - joint.limits.lower.max(-3.0));
                1.3 * half * random.signed()
            };
            let target: Vec<f64> = robot.joints().iter().zip(&start).map(|(joint, q)| q + reach(joint)).collect();
            let gain = 1.0 + 9.0 * random.signed().abs();
            (Stepper::new(posture(robot, &target, gain, period, stated)).unwrap(), interval * random.signed().abs())
        };
        let (stepper, mut until) = next(1.5);
        let mut run = Run::new(stepper.controller().as_ref().clone(), &start, drive, noise, case as u64);
        while run.time_s() < 4.0 {
            if run.time_s() > until {
                let (stepper, interval) = next(1.5);
                run.stepper = stepper;
                until += interval;
            }
            let (velocity, stalled) = run.step(&[], [0.0; 6]);
            fast += u32::from(velocity.iter().any(|speed| speed.abs() > 0.05));
            assert!(stalled.is_empty(), "case {case}, {drive:?} stated as {stated:?}: {stalled:?}");
        }
    }
    assert!(fast > 50_000, "too few periods with a joint that has to move: {fast}");
}

#[test]
fn an_arm_that_presses_on_a_wall_is_not_said_to_stall() {
    let robot = sawyer();
    let drive = Drive { lag_s: 0.005, delay_periods: 0 };
    for (seed, (stiffness, damping)) in [(1e4, 400.0), (1e5, 1200.0), (1e5, 2000.0)].into_iter().enumerate() {
        let gains = Gains::new(1, &[15.0], &[damping], &[0.0]).unwrap();
        let push = task(&[Axis::X], Law::Force(ForceLaw::new(gains, constant(&[30.0])).unwrap()));
        let others = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
        let tasks = vec![push, task(&others, position(5, 5.0))];
        let config =
            ControllerConfig { period_s: 1e-3, drive, ..ControllerConfig::new(Arc::clone(&robot), 1e-3, tasks) };
        let mut run = Run::new(controller(config), &NOMINAL, drive, 0.0, seed as u64);
        let place = |q: &[f64]| Configuration::new(&robot, q).unwrap().tool_pose().translation.x;
        let (wall, mut force) = (place(&NOMINAL) + 2e-3, 0.0);
        while run.time_s() < 3.0 {
            force = stiffness * (place(&run.arm.q) - wall).max(0.0);
            let (_, stalled) = run.step(&[], [force, 0.0, 0.0, 0.0, 0.0, 0.0]);
            assert!(stalled.is_empty(), "{stiffness} N/m: {stalled:?}");
        }
        assert!((force - 30.0).abs() < 1.0, "not in contact: {force} N");
    }
}

#[test]
fn a_joint_at_rest_with_friction_or_a_small_error_does_not_stall() {
    let robot = sawyer();
    // Commands of 0.04 rad/s, which friction holds.
    let target = NOMINAL.map(|q| q + 0.008);
    let held = posture(&robot, &target, 5.0, 1e-3, Drive::CONSERVATIVE);
    let mut run = Run::new(held, &NOMINAL, Drive::IDEAL, NOISE, 1);
    while run.time_s() < 3.0 {
        let (_, stalled) = run.step(&[0, 1, 2, 3, 4, 5, 6], [0.0; 6]);
        assert!(stalled.is_empty(), "{stalled:?}");
    }
}

#[test]
fn a_late_state_and_a_damaged_memory_do_not_count_on() {
    let robot = sawyer();
    let held = posture(&robot, &NOMINAL.map(|q| q + 0.5), 2.0, 1e-3, Drive::IDEAL);
    let mut run = Run::new(held.clone(), &NOMINAL, Drive::IDEAL, 0.0, 1);
    while run.time_s() < 0.8 {
        run.step(&[0, 1, 2, 3, 4, 5, 6], [0.0; 6]);
    }
    let memory = run.memory.clone().unwrap();
    let stalled = |memory: &Memory| memory.stalls.iter().filter(|stall| stall.time_s >= 0.5).count();
    assert_eq!(stalled(&memory), 7);
    // The brakes are released, and ten periods pass without a state.
    let mut late = Some(memory.clone());
    let q: Vec<f64> = run.arm.q.iter().zip(&memory.last_command).map(|(q, speed)| q + 0.01 * speed).collect();
    let state = Measurement { time_s: run.time_s() + 0.009, ..measurement(&q) };
    assert!(step(&held, &mut late, &state).unwrap().stalled.is_empty());
    assert_eq!(stalled(&late.unwrap()), 0);
    for stalls in [
        vec![Stall::NONE; 6],
        vec![Stall { moved: f64::NAN, ..Stall::NONE }; 7],
        vec![Stall { time_s: -1.0, ..Stall::NONE }; 7],
    ] {
        let mut damaged = Some(Memory { stalls, ..memory.clone() });
        let refused = step(&held, &mut damaged, &Measurement { time_s: run.time_s(), ..measurement(&run.arm.q) });
        assert_eq!(refused.unwrap_err(), StepError::Memory(MemoryError::Stalls));
    }
}
