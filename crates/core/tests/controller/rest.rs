//! Loops whose targets rest come to rest: random arms, tasks, methods, limits, drives and noise.

use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::controller::{Controller, ControllerConfig, Limits, NullSpaceMotion, Stepper, TaskConfig};
use revprio_core::law::{Law, MotionPath};
use revprio_core::limits::{Drive, LimitKind};
use revprio_core::resolution::Method;
use revprio_core::rows::{GazeRows, JointRows, JointTarget, TargetPose, TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_robot::kinematics::{Axis, Configuration, orientation_error};
use revprio_robot::{RobotModel, built_in};

use super::arms::{Random, constant, position, task, tool_rows, with_jerk};
use super::drives::LaggingArm;

/// Time of a loop, s.
const DURATION: f64 = 40.0;

/// Time over which a loop must be at rest, s.
const AT_REST: f64 = 2.0;

/// Time over which an arm that only converges slowly moves to one side, s.
const CREEP: f64 = 20.0;

/// Largest swing of a joint at rest, rad or m; 20 times the noise is added.
const SWING: f64 = 0.02;

/// Largest speed of a command that changes its sign in a quarter of the periods, rad/s or m/s.
const CHATTER: f64 = 0.05;

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
const ANGULAR: [Axis; 3] = [Axis::Rx, Axis::Ry, Axis::Rz];

/// A random loop.
struct Loop {
    config: ControllerConfig,
    start: Vec<f64>,
    /// The drive as it is.
    drive: Drive,
    noise: f64,
    seed: u64,
    target: IsometryMatrix3<f64>,
}

impl Loop {
    fn new(seed: u64) -> Self {
        let mut random = Random(0x5eed_0000 + seed);
        let robot = any_robot(&mut random);
        let start = any_posture(&robot, 0.95, &mut random);
        let target = any_target(&robot, &mut random);
        let period_s = random.pick(&[1e-3, 2e-3, 4e-3, 5e-3, 8e-3, 1e-2, 1e-2, 2e-2]);
        let tasks = any_tasks(&robot, target, &mut random);
        let lag = random.pick(&[0.0, 0.01, 0.02, 0.03]) * random.unit();
        let delay = random.below(4);
        let stated = Drive { lag_s: lag, delay_periods: delay };
        let drive = Drive { lag_s: lag * random.pick(&[0.5, 1.0, 1.0, 1.5]), delay_periods: delay };
        let mut config = ControllerConfig {
            method: any_method(&mut random),
            drive: stated,
            null_space: NullSpaceMotion::default_for(&robot, &tasks, stated, period_s),
            ..ControllerConfig::new(robot, period_s, tasks)
        };
        config.limits = Limits::Robot(random.pick(&[
            LimitKind::PositionVelocityAcceleration,
            LimitKind::PositionVelocityAcceleration,
            LimitKind::PositionVelocityAcceleration,
            LimitKind::PositionVelocity,
        ]));
        Self { config, start, drive, noise: random.pick(&[0.0, 0.0, 1e-4]), seed, target }
    }

    /// Returns the same loop with laws that look ahead on a path, or do not.
    fn looking_ahead(mut self, path: Option<MotionPath>) -> Self {
        for task in &mut self.config.tasks {
            if let (Law::Position(law), Some(path)) = (&task.law, path) {
                task.law = Law::Position(law.clone().along(path));
            }
        }
        self
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small positive numbers")]
    fn run(self) -> Finding {
        let period = self.config.period_s;
        let (robot, noise, target) = (Arc::clone(&self.config.robot), self.noise, self.target);
        let description = self.to_string();
        let mut arm = LaggingArm::at_rest(&self.start, self.drive, noise, self.seed);
        let mut stepper = Stepper::new(Controller::new(self.config).unwrap()).unwrap();
        let mut memory = None;
        let mut path = Path::new(&robot, target);
        let periods = (DURATION / period).round() as u32;
        for number in 0..periods {
            let measured = arm.measure(f64::from(number) * period);
            let command = stepper.step(&mut memory, &measured).unwrap().resolution.joint_velocity.as_slice().to_vec();
            arm.follow(&command, period);
            path.add(f64::from(number) * period, &arm.q, command);
        }
        path.finding(self.seed, description, noise)
    }
}

impl fmt::Display for Loop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ControllerConfig { robot, method, limits, period_s, drive, tasks, .. } = &self.config;
        let names: Vec<_> = tasks.iter().map(|task| task.name.as_str()).collect();
        write!(
            f,
            "{} {method:?} {limits:?} T {period_s} drive {drive:?} real {} noise {}",
            robot.name(),
            self.drive.lag_s,
            self.noise
        )?;
        write!(f, " tasks {names:?}")
    }
}

pub(super) fn any_robot(random: &mut Random) -> Arc<RobotModel> {
    let robot = random.pick(arms());
    if random.one_in(6) { Arc::new(with_jerk(&robot, random.pick(&[0.02, 0.05, 0.1]))) } else { robot }
}

pub(super) fn any_posture(robot: &RobotModel, share: f64, random: &mut Random) -> Vec<f64> {
    let limits = robot.joints().iter().map(|joint| joint.limits);
    let range = |l: revprio_robot::JointLimits| (l.lower.max(-3.0), l.upper.min(3.0));
    limits.map(range).map(|(l, u)| f64::midpoint(l, u) + 0.5 * share * (u - l) * random.signed()).collect()
}

/// Returns the pose of a random posture, half of the time moved away from the base.
pub(super) fn any_target(robot: &RobotModel, random: &mut Random) -> IsometryMatrix3<f64> {
    let mut pose = *Configuration::new(robot, &any_posture(robot, 0.9, random)).unwrap().tool_pose();
    pose.translation.vector *= random.pick(&[1.0, 1.0, 1.3, 1.8]);
    pose
}

pub(super) fn any_method(random: &mut Random) -> Method {
    random.pick(&[
        Method::ReversePriority,
        Method::ReversePriority,
        Method::StrictReversePriority,
        Method::StrictReversePriority,
        Method::TaskPriority,
        Method::SingularityRobust,
        Method::Pseudoinverse,
        Method::DampedLeastSquares,
    ])
}

/// Returns one to five tasks that follow positions.
pub(super) fn any_tasks(robot: &RobotModel, target: IsometryMatrix3<f64>, random: &mut Random) -> Vec<TaskConfig> {
    let is_planar = robot.joint_count() < 6;
    let towards = |axes: &[Axis], random: &mut Random| {
        let rows = TaskRows::Tool(ToolRows { target_pose: TargetPose::Fixed(target), ..tool_rows(axes) });
        TaskConfig { rows, ..task(axes, position(axes.len(), 1.0 + 5.0 * random.unit())) }
    };
    let mut tasks = if is_planar {
        vec![towards(&[Axis::X, Axis::Y], random), towards(&[Axis::Rz], random)]
    } else {
        let all = [LINEAR, ANGULAR].concat();
        match random.below(5) {
            0 => vec![towards(&all, random)],
            1 | 2 => vec![towards(&LINEAR, random), towards(&ANGULAR, random)],
            3 => vec![towards(&ANGULAR, random), towards(&LINEAR, random)],
            _ => vec![
                towards(&[Axis::Z], random),
                towards(&[Axis::X, Axis::Y], random),
                towards(&[Axis::Rx, Axis::Ry], random),
                towards(&[Axis::Rz], random),
            ],
        }
    };
    if tasks.len() == 1 || random.one_in(2) {
        let n = robot.joint_count();
        let posture = any_posture(robot, 0.5, random);
        let rows =
            TaskRows::Joints(JointRows { joints: (0..n).collect(), target: JointTarget::Position(constant(&posture)) });
        let law = position(n, 0.5 + random.unit());
        tasks.push(TaskConfig { name: "posture".into(), rows, law, scaled: false, streaming: Streaming::default() });
    }
    tasks
}

/// What a loop does, as it goes on.
struct Path<'a> {
    robot: &'a RobotModel,
    target: IsometryMatrix3<f64>,
    /// Time and errors of position (m) and orientation (rad), every 50 ms.
    errors: Vec<(f64, [f64; 2])>,
    /// Positions of the last [`CREEP`] seconds.
    positions: VecDeque<(f64, Vec<f64>)>,
    /// Commands of the last [`AT_REST`] seconds.
    commands: VecDeque<(f64, Vec<f64>)>,
    next_error: f64,
}

impl<'a> Path<'a> {
    fn new(robot: &'a RobotModel, target: IsometryMatrix3<f64>) -> Self {
        Self { robot, target, errors: vec![], positions: VecDeque::new(), commands: VecDeque::new(), next_error: 0.0 }
    }

    fn add(&mut self, time: f64, q: &[f64], command: Vec<f64>) {
        if time >= self.next_error {
            self.next_error += 0.05;
            let tool = *Configuration::new(self.robot, q).unwrap().tool_pose();
            let position = (tool.translation.vector - self.target.translation.vector).norm();
            let orientation = orientation_error(&self.target.rotation, &tool.rotation).norm();
            self.errors.push((time, [position, orientation]));
        }
        if time >= DURATION - CREEP {
            self.positions.push_back((time, q.to_vec()));
        }
        if time >= DURATION - AT_REST {
            self.commands.push_back((time, command));
        }
    }

    /// Returns whether a joint turns back again and again, by more than `allowed`, and no less in the end.
    fn swings(&self, allowed: f64) -> bool {
        let joints = self.positions[0].1.len();
        (0..joints).any(|joint| {
            let turns = turns(self.positions.iter().map(|(time, q)| (*time, q[joint])), allowed);
            let [first, .., last] = turns.as_slice() else { return false };
            let between = (last.0 - first.0) / (turns.len() - 1) as f64;
            turns.len() >= 3 && last.1 > 0.5 * first.1 && DURATION - last.0 < (1.5 * between).max(AT_REST)
        })
    }

    /// Returns the largest range of a joint at rest, rad or m.
    fn range(&self) -> f64 {
        let at_rest = || self.positions.iter().filter(|(time, _)| *time >= DURATION - AT_REST).map(|(_, q)| q);
        let joints = self.positions[0].1.len();
        let range = |joint: usize| {
            let [least, greatest] =
                at_rest().fold([f64::MAX, f64::MIN], |[a, b], q| [a.min(q[joint]), b.max(q[joint])]);
            greatest - least
        };
        (0..joints).map(range).fold(0.0, f64::max)
    }

    /// Returns the largest speed of a command that changes its sign in a quarter of the periods at rest, rad/s or m/s.
    fn chatter(&self) -> f64 {
        let commands: Vec<&[f64]> = self.commands.iter().map(|(_, command)| command.as_slice()).collect();
        let chatters = |joint: &usize| {
            let turns = commands.windows(2).filter(|pair| pair[0][*joint] * pair[1][*joint] < 0.0).count();
            4 * turns >= commands.len()
        };
        let speed = |joint: usize| commands.iter().map(|command| command[joint].abs()).fold(0.0, f64::max);
        (0..commands[0].len()).filter(chatters).map(speed).fold(0.0, f64::max)
    }

    fn finding(&self, seed: u64, description: String, noise: f64) -> Finding {
        let allowed = SWING + 20.0 * noise;
        let (swing, chatter) = (self.range(), self.chatter());
        let kind = if chatter > CHATTER {
            Kind::Chatters
        } else if self.swings(allowed) {
            Kind::Swings
        } else if swing > allowed {
            Kind::Moves
        } else {
            Kind::Rests
        };
        let end = self.errors.last().unwrap().1;
        let settled = |k: usize| {
            let (first, last) = (self.errors[0].1[k], end[k]);
            let near = 0.02 * (first - last).abs() + 2e-3;
            self.errors.iter().rev().find(|(_, e)| (e[k] - last).abs() > near).map_or(0.0, |(time, _)| *time)
        };
        Finding { seed, description, kind, swing, chatter, end, settled: [settled(0), settled(1)] }
    }
}

/// Returns the time of each turn of a joint that goes back by more than `least`, and the way since the turn before, rad or m.
fn turns(path: impl Iterator<Item = (f64, f64)>, least: f64) -> Vec<(f64, f64)> {
    let mut path = path.peekable();
    let (mut turns, (mut time, first)) = (Vec::new(), *path.peek().unwrap());
    let (mut extreme, mut last, mut rises) = (first, first, None);
    for (now, q) in path {
        match rises {
            None if (q - first).abs() > least => (rises, extreme, time) = (Some(q > first), q, now),
            Some(up) if (q > extreme) == up => (extreme, time) = (q, now),
            Some(up) if (q - extreme).abs() > least => {
                turns.push((time, (extreme - last).abs()));
                (last, extreme, time, rises) = (extreme, q, now, Some(!up));
            }
            _ => {}
        }
    }
    turns
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Rests,
    Moves,
    Swings,
    Chatters,
}

/// What a loop showed.
struct Finding {
    seed: u64,
    description: String,
    kind: Kind,
    swing: f64,
    chatter: f64,
    end: [f64; 2],
    settled: [f64; 2],
}

/// Returns the arms of the loops: the first five, for which the tests name seeds, or the others.
fn arms() -> &'static [Arc<RobotModel>] {
    let are_others = std::env::var("ARMS").is_ok_and(|value| value == "other");
    if are_others { &built_in()[5..] } else { &built_in()[..5] }
}

fn run_all(seeds: &[u64], path: Option<MotionPath>) -> Vec<Finding> {
    let mut all: Vec<Finding> = std::thread::scope(|scope| {
        let run = |part: usize| -> Vec<Finding> {
            seeds.iter().skip(part).step_by(2).map(|seed| Loop::new(*seed).looking_ahead(path).run()).collect()
        };
        let threads = [0, 1].map(|part| scope.spawn(move || run(part)));
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    all.sort_by_key(|finding| finding.seed);
    all
}

fn number_of(kind: Kind, all: &[Finding]) -> usize {
    all.iter().filter(|finding| finding.kind == kind).count()
}

/// `FROM` and `LOOPS` choose the loops, `ARMS=other` the arms that no seed in a test names, `LAW_PATH` a path on which the laws look ahead. The lines that begin with `csv` have the seed, what the loop does, swing, largest command that
/// chatters, last errors of position and orientation, and the times after which they stay near the last ones.
#[test]
#[ignore = "ten minutes"]
fn random_loops_come_to_rest() {
    let variable = |name: &str, default: u64| std::env::var(name).map_or(default, |value| value.parse().unwrap());
    let (from, count) = (variable("FROM", 0), variable("LOOPS", 1000));
    let path = match std::env::var("LAW_PATH").as_deref() {
        Ok("joint") => Some(MotionPath::Joint),
        Ok("straight") => Some(MotionPath::Straight),
        _ => None,
    };
    let all = run_all(&(from..from + count).collect::<Vec<_>>(), path);
    for Finding { seed, kind, swing, chatter, end, settled, description } in &all {
        let [position, orientation] = end;
        let [early, late] = settled;
        println!("csv {seed},{kind:?},{swing:.4},{chatter:.4},{position:.4},{orientation:.4},{early:.2},{late:.2}");
        if *kind != Kind::Rests {
            println!("{kind:?} seed {seed}: swing {swing:.3}, chatter {chatter:.3}, {description}");
        }
    }
    for kind in [Kind::Rests, Kind::Moves, Kind::Swings, Kind::Chatters] {
        println!("{kind:?}: {}", number_of(kind, &all));
    }
    let restless = number_of(Kind::Swings, &all) + number_of(Kind::Chatters, &all);
    assert!(restless <= all.len() / 250, "{restless} of {} loops never rest", all.len());
}

/// They swung or chattered before requests faded.
#[test]
fn loops_that_never_rested_come_to_rest() {
    let all =
        run_all(&[65, 113, 134, 254, 304, 387, 411, 460, 510, 627, 645, 807, 836, 1009, 1313, 1350, 1399, 1404], None);
    for found in &all {
        assert!(matches!(found.kind, Kind::Rests | Kind::Moves), "seed {}: {}", found.seed, found.description);
    }
}

/// The virtual arm comes to rest by itself. A line that leads out of reach is given up.
#[test]
fn loops_that_look_ahead_come_to_rest() {
    for path in [MotionPath::Joint, MotionPath::Straight] {
        for found in &run_all(&[3, 11, 62, 65, 70, 91, 97, 102, 113, 115, 254, 304], Some(path)) {
            assert_eq!(found.kind, Kind::Rests, "{path:?}, seed {}: {}", found.seed, found.description);
        }
    }
}

/// Joints of a Panda that is stretched towards a target out of reach, without acceleration limits and with a drive that is stated as
/// ideal: once ±2.175 rad/s in almost each period.
#[test]
fn a_stretched_panda_with_a_drive_stated_as_ideal_rests_and_says_so() {
    let robot = built_in().iter().find(|robot| robot.name() == "panda").cloned().unwrap();
    let start = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
    let target = IsometryMatrix3::translation(1.5, 0.3, 0.5);
    for drive in [Drive::IDEAL, Drive { lag_s: 0.02, delay_periods: 2 }] {
        let rows = TaskRows::Tool(ToolRows { target_pose: TargetPose::Fixed(target), ..tool_rows(&LINEAR) });
        let tasks = vec![TaskConfig { rows, ..task(&LINEAR, position(3, 5.0)) }];
        let config = ControllerConfig {
            method: Method::StrictReversePriority,
            drive: Drive::IDEAL,
            limits: Limits::Robot(LimitKind::PositionVelocity),
            ..ControllerConfig::new(Arc::clone(&robot), 0.02, tasks)
        };
        let mut arm = LaggingArm::at_rest(&start, drive, 0.0, 1);
        let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
        let (mut memory, mut fastest) = (None, 0.0_f64);
        for number in 0..1500_u32 {
            let measured = arm.measure(f64::from(number) * 0.02);
            let command = stepper.step(&mut memory, &measured).unwrap();
            arm.follow(command.resolution.joint_velocity.as_slice(), 0.02);
            if number >= 1400 {
                fastest = fastest.max(command.resolution.joint_velocity.amax());
                assert_eq!(command.fading_since_s.is_some(), command.request_share < 1.0);
                assert!(command.stuck.iter().any(|stuck| stuck.task == 0), "the task is said to be stuck");
            }
        }
        assert!(fastest < CHATTER, "{drive:?}: {fastest} rad/s");
    }
}

/// A Panda that reaches for a point out of reach and looks at another one swings, and its requests fade to nothing.
#[test]
fn an_arm_whose_requests_have_faded_says_which_tasks_are_short_of_their_targets() {
    let (period, drive) = (0.02, Drive { lag_s: 0.03, delay_periods: 2 });
    let panda = built_in().iter().find(|robot| robot.name() == "panda").cloned().unwrap();
    let target = IsometryMatrix3::translation(1.0, 0.6, 0.2);
    let reach = TaskRows::Tool(ToolRows { target_pose: TargetPose::Fixed(target), ..tool_rows(&LINEAR) });
    let look = GazeRows::new(None, Vector3::zeros(), Vector3::z(), constant(&[0.0, 0.0, 0.1])).unwrap();
    let tasks = vec![
        TaskConfig { rows: reach, ..task(&LINEAR, position(3, 5.0)) },
        TaskConfig { name: "look".to_owned(), rows: TaskRows::Gaze(look), ..task(&LINEAR, position(2, 3.0)) },
    ];
    let config = ControllerConfig { drive, ..ControllerConfig::new(panda, period, tasks) };
    let mut arm = LaggingArm::at_rest(&[0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], drive, 0.0, 1);
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let (mut memory, mut faded) = (None, 0);
    for number in 0..1000_u32 {
        let measured = arm.measure(f64::from(number) * period);
        let command = stepper.step(&mut memory, &measured).unwrap();
        arm.follow(command.resolution.joint_velocity.as_slice(), period);
        if command.request_share == 0.0 {
            faded += 1;
            let stuck: Vec<usize> = command.stuck.iter().map(|stuck| stuck.task).collect();
            assert_eq!(stuck, [0, 1], "period {number}");
        }
    }
    assert!(faded > 100, "{faded} periods");
}

/// Somebody may guide the arm while its loop pauses. Where it is then, its target may be within reach.
#[test]
fn an_arm_that_was_moved_in_a_pause_starts_anew() {
    let robot = built_in().iter().find(|robot| robot.name() == "panda").unwrap();
    let config = ControllerConfig::new(Arc::clone(robot), 0.004, vec![task(&LINEAR, position(3, 2.0))]);
    let q = vec![0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8];
    let spent_after = |moved: f64| {
        let mut stepper = Stepper::new(Controller::new(config.clone()).unwrap()).unwrap();
        let (mut arm, mut memory) = (LaggingArm::at_rest(&q, config.drive, 0.0, 1), None);
        for period in 0..20 {
            stepper.step(&mut memory, &arm.measure(0.004 * f64::from(period))).unwrap();
        }
        memory.as_mut().unwrap().rest.as_mut().unwrap().spent = 1.0;
        arm.q[3] += moved;
        stepper.step(&mut memory, &arm.measure(10.0)).unwrap();
        memory.unwrap().rest.unwrap().spent
    };
    assert!(spent_after(0.0) > 0.9);
    assert!(spent_after(0.5) < 0.1);
}
