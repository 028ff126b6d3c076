//! Position, velocity and acceleration limits in closed loop, with tasks that act against them.

use std::sync::Arc;

use revprio_core::controller::{Command, Controller, ControllerConfig, Limits, Measurement, Memory, TaskConfig};
use revprio_core::limits::{Drive, DriveState, JointMotion, LimitKind, robot_box};
use revprio_core::linalg::{Damping, Vector};
use revprio_core::resolution::{Method, Path, Solver, Status};
use revprio_core::rows::TaskRows;
use revprio_robot::kinematics::Axis;
use revprio_robot::{Joint, JointLimits, RobotModel};

use super::arms::{
    Loop, NOMINAL, PERIOD, Random, config, controller, force, impedance, measurement, sawyer, step, task,
};

const ALL_LIMITS: Limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);

/// Returns a hostile controller: random axes in random order, one or two tasks, forces up to 10 kN.
fn adversary(robot: &Arc<RobotModel>, random: &mut Random, solver: Solver) -> Controller {
    let mut axes = Axis::ALL.to_vec();
    (1..6).for_each(|i| axes.swap(i, random.below(i + 1)));
    axes.truncate(1 + random.below(6));
    let split = random.below(axes.len());
    let tasks = [&axes[..split], &axes[split..]].into_iter().filter(|axes| !axes.is_empty());
    let mut law = |axes: &[Axis]| match random.below(3) {
        0 => impedance(axes, 10f64.powf(3.0 + random.signed())),
        _ => force(axes, &axes.iter().map(|_| 1e4 * random.signed()).collect::<Vec<_>>()),
    };
    let tasks = tasks.map(|axes| task(axes, law(axes))).collect();
    let method = [Method::ReversePriority, Method::StrictReversePriority, Method::DampedLeastSquares][random.below(3)];
    controller(ControllerConfig {
        method,
        damping: (random.below(4) > 0).then_some(Damping::STANDARD),
        period_s: [1e-3, 2e-3, 1e-2][random.below(3)],
        limits: ALL_LIMITS,
        solver,
        ..config(robot, tasks)
    })
}

/// Returns Sawyer with very different limits: ranges down to 3 %, speeds and accelerations from 1 % to 1000 %.
fn arm_with_random_limits(random: &mut Random) -> Arc<RobotModel> {
    let sawyer = sawyer();
    let mut factor = |from: f64, to: f64| 10_f64.powf(from + (to - from) * 0.5 * (1.0 + random.signed()));
    let mut joints = sawyer.joints().to_vec();
    for joint in &mut joints {
        let middle = 0.5 * (joint.limits.lower + joint.limits.upper);
        let half = 0.5 * (joint.limits.upper - joint.limits.lower) * factor(-1.5, 0.0);
        joint.limits = JointLimits {
            lower: middle - half,
            upper: middle + half,
            velocity: joint.limits.velocity * factor(-2.0, 1.0),
            acceleration: joint.limits.acceleration * factor(-2.0, 1.0),
            ..JointLimits::NONE
        };
    }
    Arc::new(RobotModel::new("random", "", joints, *sawyer.tool()).unwrap())
}

/// Returns a start posture: each joint inside its range, exactly at a limit or, if `outside`, beyond a limit.
fn start(robot: &RobotModel, random: &mut Random, outside: bool) -> Vec<f64> {
    let mut position = |limits: &JointLimits| match random.below(if outside { 5 } else { 4 }) {
        0 => limits.lower,
        1 => limits.upper,
        2 | 3 => 0.5 * (limits.lower + limits.upper + random.signed() * (limits.upper - limits.lower)),
        _ if random.signed() < 0.0 => limits.lower - 0.3 * random.signed().abs(),
        _ => limits.upper + 0.3 * random.signed().abs(),
    };
    robot.joints().iter().map(|joint| position(&joint.limits)).collect()
}

/// Returns the distance of each joint outside its range, rad; 0 inside.
fn outside(robot: &RobotModel, q: &[f64]) -> Vec<f64> {
    let beyond = |(joint, q): (&Joint, &f64)| (q - joint.limits.upper).max(joint.limits.lower - q).max(0.0);
    robot.joints().iter().zip(q).map(beyond).collect()
}

/// Returns a new memory for a controller that takes over a moving arm.
fn takeover_memory(arm: &Loop, controller: &Controller) -> Memory {
    let robot = &controller.config().robot;
    let (configuration, twist) = (arm.configuration(robot), arm.twist(robot));
    let moving = |task: &TaskConfig| match &task.rows {
        TaskRows::Tool(rows) => {
            Vector::from_iterator(rows.axes.len(), rows.axes.axes().iter().map(|axis| twist[axis.index()]))
        }
        TaskRows::Joints(_) | TaskRows::Raw(_) | TaskRows::Gaze(_) => {
            unreachable!("the hostile controller has tasks of the tool only")
        }
    };
    let last_command = arm.memory.as_ref().map_or(Vector::zeros(7), |memory| memory.last_command.clone());
    Memory {
        channels: Vec::new(),
        start_time_s: 0.0,
        task_velocities: controller.config().tasks.iter().map(moving).collect(),
        initial_pose: *configuration.tool_pose(),
        drive: DriveState::moving(Drive::IDEAL, &last_command),
        answered: None,
        jerk: None,
        last_command,
        active_set: Vec::new(),
        initial_position: None,
        progress: Vec::new(),
        stalls: Vec::new(),
        rest: None,
        virtual_arm: None,
        wrench_sensors: Vec::new(),
        contacts: Vec::new(),
        in_transition: false,
        target_streams: Vec::new(),
    }
}

/// Largest excess over each kind of limit, and how often limits were active.
#[derive(Debug, Default)]
struct Findings {
    position: f64,
    velocity: f64,
    acceleration: f64,
    cycles: usize,
    with_active_limits: usize,
    at_position_limit: usize,
    clarabel: usize,
    not_certified: usize,
}

impl Findings {
    /// Adds one command. `outside`: distance of each joint outside its range at the start.
    fn add(&mut self, robot: &RobotModel, outside: &[f64], last: &[f64], command: &Command, arm: &Loop, period: f64) {
        let mut near = false;
        for (i, joint) in robot.joints().iter().enumerate() {
            let (q, qdot, limits) = (arm.q[i], command.resolution.joint_velocity[i], joint.limits);
            self.position = self.position.max((q - limits.upper).max(limits.lower - q) - outside[i]);
            self.velocity = self.velocity.max(qdot.abs() - limits.velocity);
            self.acceleration = self.acceleration.max((qdot - last[i]).abs() / period - limits.acceleration);
            near |= (limits.upper - q).min(q - limits.lower) < 1e-3;
        }
        self.cycles += 1;
        self.with_active_limits += usize::from(command.resolution.active_limits().next().is_some());
        self.at_position_limit += usize::from(near);
        self.clarabel += usize::from(command.resolution.solver.path == Path::Qp);
        self.not_certified += usize::from(command.resolution.solver.status != Status::Optimal);
        assert!(command.limit_conflicts.is_empty(), "cycle {}: {:?}", self.cycles, command.limit_conflicts);
        assert!(command.resolution.broken_limits().next().is_none(), "cycle {}", self.cycles);
    }

    fn assert_limits_held(&self) {
        println!("{self:?}");
        assert!(self.position <= 1e-9 && self.velocity <= 1e-9 && self.acceleration <= 1e-9, "{self:?}");
        assert!(
            self.with_active_limits > self.cycles / 2 && self.at_position_limit > self.cycles / 20,
            "too few active limits: {self:?}"
        );
    }
}

fn assert_box_not_empty(controller: &Controller, arm: &Loop, last: &[f64]) {
    let kind = LimitKind::PositionVelocityAcceleration;
    let motion = JointMotion { position: &arm.q, distance_to_rest: &[], last_command: last, last_acceleration: &[] };
    let limited = robot_box(&controller.config().robot, kind, motion, controller.config().period_s);
    let (lower, upper) = (limited.velocity_box.lower(), limited.velocity_box.upper());
    assert!(lower.iter().zip(upper).all(|(lower, upper)| lower <= upper), "{limited:?}");
}

/// Runs `cycles` of hostile tasks under random wrenches, with a new arm and a new start every 2500 cycles.
fn run_hostile_cycles(seed: u64, cycles: usize, from_outside: bool, solver: Solver) -> Findings {
    let (mut random, mut findings) = (Random(seed), Findings::default());
    while findings.cycles < cycles {
        let robot = if random.below(2) == 0 { sawyer() } else { arm_with_random_limits(&mut random) };
        let mut arm = Loop::at_rest(&start(&robot, &mut random, from_outside));
        let outside_at_start = outside(&robot, &arm.q);
        for _ in 0..5 {
            let controller = adversary(&robot, &mut random, solver);
            arm.memory = Some(takeover_memory(&arm, &controller));
            let period = controller.config().period_s;
            for _ in 0..500 {
                let last = arm.memory.as_ref().unwrap().last_command.as_slice().to_vec();
                assert_box_not_empty(&controller, &arm, &last);
                let push = [0.0; 6].map(|_: f64| 3e3 * random.signed());
                let command = arm.step(&controller, push);
                findings.add(&robot, &outside_at_start, &last, &command, &arm, period);
            }
        }
        let outside_at_end = outside(&robot, &arm.q);
        for (i, (start, end)) in outside_at_start.iter().zip(&outside_at_end).enumerate() {
            assert!(*end <= 1e-9 || end < start, "joint {i} does not return: {start} rad outside, then {end}");
        }
    }
    findings
}

/// Runs a quarter of the 10⁶ cycles, so that the test harness can run the quarters in parallel.
fn quarter(seed: u64) {
    let findings = run_hostile_cycles(seed, 250_000, false, Solver::Auto);
    findings.assert_limits_held();
    assert_eq!(findings.not_certified, 0, "{findings:?}");
}

#[test]
fn no_limit_is_exceeded_in_the_first_quarter_of_1e6_adversarial_cycles() {
    quarter(2);
}

#[test]
fn no_limit_is_exceeded_in_the_second_quarter_of_1e6_adversarial_cycles() {
    quarter(3);
}

#[test]
fn no_limit_is_exceeded_in_the_third_quarter_of_1e6_adversarial_cycles() {
    quarter(5);
}

#[test]
fn no_limit_is_exceeded_in_the_last_quarter_of_1e6_adversarial_cycles() {
    quarter(7);
}

#[test]
fn joints_outside_return_within_velocity_and_acceleration_limits_under_hostile_tasks() {
    let findings = run_hostile_cycles(11, 100_000, true, Solver::Auto);
    findings.assert_limits_held();
    assert_eq!(findings.not_certified, 0, "{findings:?}");
}

/// One answer of `qp` in a hundred may say that it is not sure. It keeps the limits all the same.
#[test]
fn no_limit_is_exceeded_by_clarabels_answers_in_adversarial_cycles() {
    for from_outside in [false, true] {
        let findings = run_hostile_cycles(13, 20_000, from_outside, Solver::Qp);
        findings.assert_limits_held();
        assert_eq!(findings.clarabel, findings.cycles);
        assert!(100 * findings.not_certified <= findings.cycles, "{findings:?}");
    }
}

/// Returns an arm that moves under a constant push along x.
fn moving_arm(controller: &Controller) -> Loop {
    let mut arm = Loop::at_rest(&NOMINAL);
    (0..200).for_each(|_| drop(arm.step(controller, [0.0; 6])));
    arm
}

#[test]
fn after_a_jump_of_the_measured_position_the_position_limit_holds_and_a_conflict_is_reported() {
    let robot = sawyer();
    let limited =
        ControllerConfig { limits: ALL_LIMITS, ..config(&robot, vec![task(&[Axis::X], force(&[Axis::X], &[300.0]))]) };
    let controller = controller(limited);
    let arm = moving_arm(&controller);
    let last = arm.memory.as_ref().unwrap().last_command.clone();
    let joint = last.iamax();
    let limits = robot.joints()[joint].limits;
    assert!(last[joint].abs() > 2.0 * limits.acceleration * PERIOD, "the joint must be too fast to stop in one period");

    let mut jumped = arm.clone();
    jumped.q[joint] = if last[joint] > 0.0 { limits.upper } else { limits.lower };
    let at_limit = jumped.step(&controller, [0.0; 6]);
    assert_eq!(at_limit.limit_conflicts, [joint]);
    let qdot = at_limit.resolution.joint_velocity[joint];
    assert!(qdot * last[joint].signum() <= 0.0, "the joint moves outwards: {qdot} rad/s");
    assert!(at_limit.resolution.broken_limits().next().is_none());

    let mut undisturbed = arm;
    assert!(undisturbed.step(&controller, [0.0; 6]).limit_conflicts.is_empty());
}

#[test]
fn an_arm_outside_its_limits_returns_and_stays_inside() {
    let robot = sawyer();
    let outwards = vec![task(&Axis::ALL, force(&Axis::ALL, &[300.0; 6]))];
    let controller = controller(ControllerConfig { limits: ALL_LIMITS, ..config(&robot, outwards) });
    let mut arm = Loop::at_rest(&NOMINAL);
    let limits = robot.joints()[3].limits;
    arm.q[3] = limits.upper + 0.1;
    let outside = |arm: &Loop| arm.q[3] - limits.upper;
    let mut last = 0.0;
    for _ in 0..1000 {
        let command = arm.step(&controller, [0.0; 6]);
        let qdot = command.resolution.joint_velocity[3];
        assert!((qdot - last).abs() <= limits.acceleration * PERIOD + 1e-9 && qdot.abs() <= limits.velocity + 1e-9);
        assert!(command.limit_conflicts.is_empty());
        last = qdot;
    }
    assert!(outside(&arm) <= 1e-4, "still {} rad outside", outside(&arm));
}

#[test]
fn the_first_command_keeps_the_acceleration_limit_relative_to_the_measured_velocity() {
    let robot = sawyer();
    let tasks = vec![task(&Axis::ALL, force(&Axis::ALL, &[-1e4; 6]))];
    let controller = controller(ControllerConfig { limits: ALL_LIMITS, ..config(&robot, tasks) });
    let moving = [0.1, -0.2, 0.05, 0.3, -0.1, 0.2, 0.4];
    let measured = Measurement { joint_velocity: Some(moving.to_vec()), ..measurement(&NOMINAL) };
    let command = step(&controller, &mut None, &measured).unwrap();
    assert!(command.resolution.active_limits().next().is_some());
    for (i, joint) in robot.joints().iter().enumerate() {
        let change = (command.resolution.joint_velocity[i] - moving[i]).abs();
        assert!(change <= joint.limits.acceleration * PERIOD + 1e-12, "joint {}", joint.name);
    }
}
