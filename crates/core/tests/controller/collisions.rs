//! Arms keep clear of obstacles and of themselves behind drives with lag and dead time, whatever their tasks want.

mod deaths;
mod parallel;

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::collision::{CollisionAvoidance, CollisionAvoidanceError, Obstacle, ObstacleShape, ObstacleState};
use revprio_core::constraint::{APPROACH_RATE, Constraint, PlanePoint, VirtualPlane};
use revprio_core::controller::{
    ConfigError, Controller, ControllerConfig, Limits, Measurement, StepError, Stepper, TaskConfig,
};
use revprio_core::limits::{Drive, LimitKind};
use revprio_core::resolution::BoundId;
use revprio_core::rows::TaskRows;
use revprio_core::streaming::{StreamedTarget, StreamedValue, Streaming};
use revprio_robot::collision::{LinkCapsule, OrientedBox, PlacedBody, Segment, StatedPair};
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{Joint, JointLimits, RobotModel, built_in};

use super::arms::{Random, gantry, joint_rows, position, tool_rows};
use super::drives::LaggingArm;
use super::two_arms::two_pandas;

/// d_min, m.
const NEAREST: f64 = 0.01;

const HOME: [f64; 7] = [0.0, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8];

/// Ends and radius of capsules of a Panda, by the joint that carries them (from 1; 0 is the base), m.
const CAPSULES: [(usize, [f64; 3], [f64; 3], f64); 9] = [
    (0, [0.0, 0.0, 0.05], [-0.055, 0.0, 0.015], 0.105),
    (1, [0.0, 0.0, -0.14], [0.0, -0.055, 0.0], 0.077),
    (2, [0.0, -0.14, 0.0], [0.0, 0.0, 0.055], 0.077),
    (3, [0.083, 0.043, 0.0], [0.0, 0.0, -0.08], 0.07),
    (4, [0.0, 0.0, 0.043], [-0.081, 0.084, 0.0], 0.07),
    (5, [0.0, 0.064, 0.004], [0.0, 0.01, -0.245], 0.068),
    (6, [0.087, 0.009, 0.0], [0.023, 0.007, 0.006], 0.075),
    (7, [0.034, 0.034, 0.1135], [-0.034, -0.034, 0.1135], 0.0755),
    (7, [0.0, 0.0, 0.21], [0.0, 0.0, 0.17], 0.028),
];

/// The arms of the runs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Arm {
    /// A Panda with a hand.
    #[default]
    Panda,
    Ur5e,
    Sawyer,
    TwoPandas,
}

impl Arm {
    /// Returns a posture in which the arm is clear.
    fn home(self) -> Vec<f64> {
        match self {
            Self::Panda => HOME.to_vec(),
            Self::Ur5e => vec![0.0, -1.57, 1.2, -1.2, -1.57, 0.0],
            Self::Sawyer => vec![0.0, -0.8, 0.0, 1.6, 0.0, 0.8, 0.0],
            Self::TwoPandas => [HOME, HOME].concat(),
        }
    }

    /// Returns the arm with shapes, with its jerk limits or without.
    fn robot(self, with_jerk: bool) -> Arc<RobotModel> {
        let built_in = |name: &str| Arc::clone(built_in().iter().find(|robot| robot.name() == name).unwrap());
        match self {
            Self::Panda => panda(with_jerk),
            Self::Ur5e => built_in("ur5e"),
            Self::Sawyer => built_in("sawyer"),
            Self::TwoPandas => {
                let two = two_pandas().as_ref().clone();
                let capsules = ["left", "right"].iter().flat_map(|side| {
                    let two = &two;
                    CAPSULES.iter().map(move |&(place, from, to, radius)| LinkCapsule {
                        link: two.link(&format!("{side}_link{place}")).unwrap(),
                        core: Segment { from: from.into(), to: to.into() },
                        radius,
                    })
                });
                let capsules: Vec<LinkCapsule> = capsules.collect();
                let hand = |side: &str| StatedPair {
                    links: [5, 7].map(|place| two.link(&format!("{side}_link{place}")).unwrap()),
                    reason: String::new(),
                };
                let left_out = ["left", "right"].map(hand);
                Arc::new(two.clone().with_capsules(capsules, &left_out).unwrap())
            }
        }
    }
}

/// Returns a Panda with capsules, with its jerk limits or without.
fn panda(with_jerk: bool) -> Arc<RobotModel> {
    panda_with_jerk(|limits| if with_jerk { limits.jerk } else { f64::INFINITY })
}

/// Returns a Panda with capsules and other jerk limits.
fn panda_with_jerk(jerk: impl Fn(&JointLimits) -> f64) -> Arc<RobotModel> {
    let panda = built_in().iter().find(|robot| robot.name() == "panda").unwrap();
    let joint =
        |joint: &Joint| Joint { limits: JointLimits { jerk: jerk(&joint.limits), ..joint.limits }, ..joint.clone() };
    let joints = panda.joints().iter().map(joint).collect();
    let tool = panda.tool() * IsometryMatrix3::translation(0.0, 0.0, 0.09);
    let robot = RobotModel::new("panda", "", joints, tool).unwrap();
    let link = |place: usize| robot.link(&robot.links()[place].name).unwrap();
    let capsules = CAPSULES.iter().map(|&(place, from, to, radius)| LinkCapsule {
        link: link(place),
        core: Segment { from: from.into(), to: to.into() },
        radius,
    });
    let capsules: Vec<LinkCapsule> = capsules.collect();
    let left_out = [StatedPair { links: [5, 7].map(link), reason: String::new() }];
    let robot = robot.with_capsules(capsules, &left_out).unwrap();
    assert!(nearest(&robot, &[], &HOME) > NEAREST);
    Arc::new(robot)
}

fn capsule(from: [f64; 3], to: [f64; 3], radius: f64) -> ObstacleShape {
    ObstacleShape::Capsule { core: Segment { from: from.into(), to: to.into() }, radius }
}

/// A post, a bar, a ball, a box and the floor; `moves`: whether the ball does.
fn obstacles(moves: bool) -> Vec<Obstacle> {
    let shelf = OrientedBox { pose: IsometryMatrix3::translation(-0.5, 0.3, 0.6), half: Vector3::new(0.15, 0.1, 0.02) };
    let shapes = [
        ("post", capsule([0.45, -0.35, 0.0], [0.45, -0.35, 0.7], 0.05)),
        ("bar", capsule([0.3, 0.45, 0.55], [0.7, 0.3, 0.55], 0.03)),
        ("ball", capsule([0.6, 0.0, 0.15], [0.6, 0.0, 0.15], 0.1)),
        ("shelf", ObstacleShape::Box(shelf)),
        ("floor", ObstacleShape::HalfSpace { normal: Vector3::z(), offset: -0.2 }),
    ];
    shapes.into_iter().map(|(name, shape)| Obstacle::new(name, shape, moves && name == "ball").unwrap()).collect()
}

/// The obstacles that are clear of an arm in its first posture.
fn room(robot: &RobotModel, setup: Setup) -> Vec<Obstacle> {
    let is_clear =
        |obstacle: &Obstacle| nearest(robot, std::slice::from_ref(obstacle), &setup.arm.home()) > NEAREST + 0.01;
    obstacles(setup.ball > 0.0).into_iter().filter(is_clear).collect()
}

/// How a run is set up.
#[derive(Debug, Clone, Copy)]
struct Setup {
    arm: Arm,
    with_jerk: bool,
    period: f64,
    drive: Drive,
    noise: f64,
    /// Speed of a ball that comes towards the arm, m/s; 0: it stands.
    ball: f64,
    seed: u64,
}

impl Default for Setup {
    fn default() -> Self {
        Self { arm: Arm::Panda, with_jerk: false, period: 0.001, drive: SLOW, noise: 0.0, ball: 0.0, seed: 1 }
    }
}

fn config(robot: &Arc<RobotModel>, setup: Setup) -> ControllerConfig {
    let streaming = Streaming::default();
    let tool = TaskConfig {
        name: "tool".to_owned(),
        rows: TaskRows::Tool(tool_rows(&[Axis::X, Axis::Y, Axis::Z])),
        law: position(3, 10.0),
        scaled: false,
        streaming: streaming.clone(),
    };
    let posture = TaskConfig {
        name: "posture".to_owned(),
        rows: joint_rows(&setup.arm.home()),
        law: position(robot.joint_count(), 6.0),
        scaled: false,
        streaming,
    };
    let tasks = if setup.seed.is_multiple_of(2) { vec![tool, posture] } else { vec![posture, tool] };
    let avoidance = CollisionAvoidance {
        min_distance_m: NEAREST,
        obstacles: obstacles(setup.ball > 0.0),
        ..CollisionAvoidance::default()
    };
    ControllerConfig {
        drive: setup.drive,
        constraints: vec![Constraint::Distances(avoidance)],
        leave_local_minima: false,
        ..ControllerConfig::new(Arc::clone(robot), setup.period, tasks)
    }
}

/// Returns the smallest distance of all pairs at a posture, m.
fn nearest(robot: &RobotModel, obstacles: &[Obstacle], q: &[f64]) -> f64 {
    let model = robot.collision().unwrap();
    let body = PlacedBody::new(model, &Configuration::new(robot, q).unwrap());
    let capsules = model.capsules();
    let own = model
        .pairs()
        .iter()
        .map(|pair| pair.capsules)
        .map(|[i, j]| body.core(i).to_segment(body.core(j)).distance - capsules[i].radius - capsules[j].radius);
    let with = |k: usize| {
        let body = &body;
        obstacles.iter().map(move |obstacle| {
            let core = body.core(k);
            let distance = match obstacle.shape {
                ObstacleShape::Capsule { core: other, radius } => core.to_segment(&other).distance - radius,
                ObstacleShape::Box(other) => core.to_box(&other).distance,
                ObstacleShape::HalfSpace { normal, offset } => core.to_half_space(&normal, offset).distance,
            };
            distance - capsules[k].radius
        })
    };
    let moving = (0..capsules.len()).filter(|k| model.joint(*k).is_some());
    own.chain(moving.flat_map(with)).fold(f64::INFINITY, f64::min)
}

/// What a run shows.
#[derive(Debug, Default)]
struct Outcome {
    /// Smallest distance less d_min, m.
    margin: f64,
    /// Periods below d_min − 1e-6.
    below: usize,
    /// Periods whose box was shrunk, to a point, whose stop was not free, and with rows left.
    shrunk: usize,
    to_point: usize,
    unfree: usize,
    with_rows: usize,
    /// Way of all joints, rad.
    way: f64,
    /// Largest excess of a joint's acceleration limit, rad/s².
    excess: f64,
    /// Shortest hold, s.
    shortest_hold: f64,
    times: Times,
}

/// How long each period took, µs.
#[derive(Default)]
struct Times(Vec<f64>);

impl Times {
    fn keep_least(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(time, other)| *time = time.min(*other));
    }
}

impl std::fmt::Debug for Times {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        let [median, high] = [50, 99].map(|percent| sorted[(sorted.len() - 1) * percent / 100]);
        write!(formatter, "median {median:.0} µs, 99th percentile {high:.0} µs")
    }
}

impl Outcome {
    fn add(&mut self, other: &Self) {
        self.times.0.extend(&other.times.0);
        self.margin = self.margin.min(other.margin);
        self.below += other.below;
        self.shrunk += other.shrunk;
        self.to_point += other.to_point;
        self.unfree += other.unfree;
        self.with_rows += other.with_rows;
        self.way += other.way;
        self.excess = self.excess.max(other.excess);
        self.shortest_hold = self.shortest_hold.min(other.shortest_hold);
    }
}

/// A ball that comes towards the arm and goes elsewhere; its velocity changes by at most 1 m/s².
struct Ball {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
}

impl Ball {
    fn roam(&mut self, speed: f64, time_s: f64, period: f64) {
        let way = |amplitude: f64, rate: f64| amplitude * (rate * time_s).sin();
        let centre = Vector3::new(0.62 + way(0.2, 0.37), 0.4 * (0.53 * time_s).cos(), 0.45 + way(0.3, 0.71));
        let to = centre - self.position;
        let wanted = to * (speed / to.norm().max(1e-9)).min(2.0);
        self.velocity += (wanted - self.velocity).map(|change| change.clamp(-period, period));
        self.velocity *= (speed / self.velocity.norm().max(1e-9)).min(1.0);
    }

    fn state(&self) -> ObstacleState {
        ObstacleState { name: "ball".into(), position: self.position, velocity: self.velocity }
    }
}

/// Targets that change every 0.4 s: inside obstacles, inside the base, anywhere; random postures.
fn targets(robot: &RobotModel, tasks: &[TaskConfig], time_s: f64, random: &mut Random) -> Vec<StreamedTarget> {
    let into = |random: &mut Random, k: usize| match k {
        0 => [0.45, -0.35, 0.5 + 0.2 * random.signed()],
        1 => [0.5, 0.37, 0.55],
        2 => [0.6, 0.0, 0.15],
        3 => [-0.5, 0.3, 0.6],
        4 => [0.0, 0.0, 0.4 + 0.2 * random.signed()],
        _ => [0.2 + 0.5 * random.signed(), 0.7 * random.signed(), 0.5 + 0.5 * random.signed()],
    };
    let k = random.below(7);
    let place = Vector3::from(into(random, k));
    let posture = robot.joints().iter().map(|joint| {
        let limits = joint.limits;
        limits.lower + (limits.upper - limits.lower) * random.unit()
    });
    let posture: Vec<f64> = posture.collect();
    let index = |name: &str| tasks.iter().position(|task| task.name == name).unwrap();
    let target = |task, value| StreamedTarget { task, time_s, value, velocity: None, ahead: Vec::new() };
    vec![
        target(index("tool"), StreamedValue::Pose { position: Some(place), orientation: None }),
        target(index("posture"), StreamedValue::JointPosition(posture)),
    ]
}

fn run(setup: Setup, periods: u32) -> Outcome {
    let robot = setup.arm.robot(setup.with_jerk);
    let config = config(&robot, setup);
    let mut obstacles = room(&robot, setup);
    let mut ball = Ball { position: Vector3::new(0.6, 0.0, 0.15), velocity: Vector3::zeros() };
    let controller = Controller::new(config).unwrap();
    let mut stepper = Stepper::new(controller.clone()).unwrap();
    let mut arm = LaggingArm::at_rest(&setup.arm.home(), setup.drive, setup.noise, setup.seed);
    let mut random = Random(setup.seed);
    let mut memory = None;
    let mut outcome = Outcome { margin: f64::INFINITY, shortest_hold: f64::INFINITY, ..Outcome::default() };
    let (mut last, mut next_target_s) = (vec![0.0; robot.joint_count()], 0.0);
    for i in 0..periods {
        let time_s = f64::from(i) * setup.period;
        let mut measured = arm.measure(time_s);
        if time_s >= next_target_s {
            next_target_s += 0.4;
            measured.targets = targets(&robot, &controller.config().tasks, time_s, &mut random);
        }
        if setup.ball > 0.0 {
            ball.roam(setup.ball, time_s, setup.period);
            measured.obstacles = vec![ball.state()];
        }
        let start = std::time::Instant::now();
        let command = stepper.step(&mut memory, &measured).unwrap();
        outcome.times.0.push(start.elapsed().as_secs_f64() * 1e6);
        let report = command.collisions.as_ref().unwrap();
        outcome.shrunk += usize::from(report.share < 1.0);
        outcome.to_point += usize::from(report.share == 0.0);
        outcome.unfree += usize::from(report.is_violated);
        outcome.with_rows += usize::from(report.rows[1] > 0);
        outcome.shortest_hold = outcome.shortest_hold.min(command.hold.time_s);
        let u = command.resolution.joint_velocity.as_slice();
        for ((u, last), joint) in u.iter().zip(&mut last).zip(robot.joints()) {
            outcome.excess = outcome.excess.max((u - *last).abs() / setup.period - joint.limits.acceleration);
            outcome.way += setup.period * u.abs();
            *last = *u;
        }
        arm.follow(u, setup.period);
        ball.position += ball.velocity * setup.period;
        if setup.ball > 0.0 {
            let place = obstacles.iter().position(|obstacle| obstacle.moves).unwrap();
            obstacles[place].shape = capsule(ball.position.into(), ball.position.into(), 0.1);
        }
        let margin = nearest(&robot, &obstacles, &arm.q) - NEAREST;
        outcome.margin = outcome.margin.min(margin);
        outcome.below += usize::from(margin < -1e-6);
    }
    outcome
}

const SLOW: Drive = Drive { lag_s: 0.03, delay_periods: 2 };

/// Drives that follow at once have a lag so short that the plant has no division by zero.
const IDEAL: Drive = Drive { lag_s: 1e-9, delay_periods: 0 };

/// The setups of the table: the first one, and what differs from it.
fn setups() -> [Setup; 12] {
    let first = Setup::default();
    [
        first,
        Setup { with_jerk: true, ..first },
        Setup { drive: IDEAL, ..first },
        Setup { noise: 1e-4, ..first },
        Setup { period: 0.004, ..first },
        Setup { period: 0.008, with_jerk: true, ..first },
        Setup { ball: 0.1, ..first },
        Setup { ball: 0.25, ..first },
        Setup { ball: 0.5, ..first },
        Setup { arm: Arm::Ur5e, ..first },
        Setup { arm: Arm::Sawyer, ..first },
        Setup { arm: Arm::TwoPandas, ..first },
    ]
}

#[test]
#[ignore = "asserts nothing; a million periods take minutes; prints the table of docs/collisions.md"]
fn table_of_adversarial_runs() {
    let number = |name: &str, default: u32| std::env::var(name).map_or(default, |text| text.parse().unwrap());
    let (periods, seeds, repeats) = (number("PERIODS", 20_000), u64::from(number("SEEDS", 4)), number("REPEATS", 1));
    for setup in setups() {
        let mut all = Outcome { margin: f64::INFINITY, ..Outcome::default() };
        for seed in 1..=seeds {
            let mut outcome = run(Setup { seed, ..setup }, periods);
            for _ in 1..repeats {
                // The same periods again. The least time is the one that other programs disturb least.
                outcome.times.keep_least(&run(Setup { seed, ..setup }, periods).times);
            }
            all.add(&outcome);
        }
        println!("{setup:?}\n  {all:?}");
    }
}

#[test]
fn an_arm_keeps_clear_of_a_standing_room_and_of_itself() {
    let mut with_rows = 0;
    for (setup, seed) in setups().into_iter().filter(|setup| setup.ball == 0.0).zip(1..) {
        let outcome = run(Setup { seed, ..setup }, 2000);
        let allowed = 5.0 * setup.noise;
        assert!(outcome.margin >= -allowed, "{setup:?}: {outcome:?}");
        assert!(outcome.excess < 1e-9 && outcome.way > 3.0, "{setup:?}: {outcome:?}");
        with_rows += outcome.with_rows;
    }
    assert!(with_rows > 500, "the arms met obstacles in {with_rows} periods");
}

/// Obstacles come before planes among the levels and after them by name, and so do moving obstacles before standing ones that are
/// named later. Each memory is accepted with the next state.
#[test]
fn planes_and_obstacles_hold_an_arm_together() {
    let robot = panda(false);
    let table = VirtualPlane::new("table", [0.0, 0.0, -1.0], -0.3, PlanePoint::Tool, APPROACH_RATE).unwrap();
    let mut together = [0, 0];
    for seed in 1..=12 {
        let setup = Setup { seed, period: 0.004, drive: IDEAL, ball: 0.1, ..Setup::default() };
        let mut config = config(&robot, setup);
        let Some(Constraint::Distances(avoidance)) = config.constraints.first_mut() else { panic!() };
        avoidance.obstacles.sort_by_key(|obstacle| !obstacle.moves);
        config.constraints.insert(0, Constraint::Plane(table.clone()));
        let controller = Controller::new(config).unwrap();
        let mut stepper = Stepper::new(controller.clone()).unwrap();
        let mut arm = LaggingArm::at_rest(&HOME, setup.drive, 0.0, seed);
        let (mut random, mut memory) = (Random(seed), None);
        for i in 0..2500 {
            let time_s = f64::from(i) * setup.period;
            let mut measured = arm.measure(time_s);
            measured.obstacles = vec![ObstacleState {
                name: "ball".into(),
                position: Vector3::new(0.6, 0.0, 0.15),
                velocity: Vector3::zeros(),
            }];
            if i % 100 == 0 {
                measured.targets = targets(&robot, &controller.config().tasks, time_s, &mut random);
            }
            let command = stepper.step(&mut memory, &measured).unwrap();
            arm.follow(command.resolution.joint_velocity.as_slice(), setup.period);
            let holds = |wanted: usize| {
                let mut active = command.resolution.active_constraints().map(|(_, active)| active.bound.id);
                active.any(|id| matches!(id, BoundId::Constraint { index, .. } if index == wanted))
            };
            together[0] += usize::from(holds(0) && holds(1));
            together[1] += usize::from(command.resolution.active_constraints().filter(|_| holds(1)).count() > 1);
        }
    }
    println!("{together:?}");
    assert!(together.iter().all(|&periods| periods > 10), "{together:?}");
}

/// A ball that comes at 0.1 m/s is no standing obstacle: the arm goes out of its way.
#[test]
fn an_arm_goes_out_of_the_way_of_a_ball() {
    let outcome = run(Setup { ball: 0.1, seed: 2, ..Setup::default() }, 12_000);
    assert!(outcome.margin > -1e-6 && outcome.unfree > 100, "{outcome:?}");
}

/// The same motions without avoidance hit something: otherwise the test above could not fail.
#[test]
fn without_avoidance_the_arm_hits_something() {
    let setup = Setup::default();
    let robot = panda(false);
    let config = ControllerConfig { constraints: Vec::new(), ..config(&robot, setup) };
    let controller = Controller::new(config).unwrap();
    let mut stepper = Stepper::new(controller.clone()).unwrap();
    let mut arm = LaggingArm::at_rest(&HOME, setup.drive, 0.0, 1);
    let (mut random, mut memory, mut nearest_so_far) = (Random(setup.seed), None, f64::INFINITY);
    for i in 0..2000 {
        let time_s = f64::from(i) * setup.period;
        let mut measured = arm.measure(time_s);
        if i % 400 == 0 {
            measured.targets = targets(&robot, &controller.config().tasks, time_s, &mut random);
        }
        let command = stepper.step(&mut memory, &measured).unwrap();
        arm.follow(command.resolution.joint_velocity.as_slice(), setup.period);
        nearest_so_far = nearest_so_far.min(nearest(&robot, &obstacles(false), &arm.q));
    }
    assert!(nearest_so_far < -0.01, "{nearest_so_far} m");
}

/// Limits that let joints jump, and a state that comes so late that the watchdog has braked: the transition then allows accelerations
/// alone, and the stop counts with them.
#[test]
fn a_late_state_with_limits_that_let_joints_jump_keeps_clear() {
    let limits = JointLimits { lower: -2.0, upper: 2.0, velocity: 1.0, acceleration: 2.0, ..JointLimits::NONE };
    let bare = gantry(limits).as_ref().clone();
    let ball = LinkCapsule { link: bare.tips()[0].link, core: Segment::point(Vector3::zeros()), radius: 0.05 };
    let robot = Arc::new(bare.with_capsules(vec![ball], &[]).unwrap());
    for gap in [0.07, 0.2] {
        let middle = IsometryMatrix3::translation(0.05 + gap + 0.1, 0.0, 0.0);
        let wall = ObstacleShape::Box(OrientedBox { pose: middle, half: Vector3::new(0.1, 1.0, 1.0) });
        let obstacles = vec![Obstacle::new("wall", wall, false).unwrap()];
        let avoidance =
            CollisionAvoidance { min_distance_m: 0.02, rate_per_s: 100.0, obstacles, ..CollisionAvoidance::default() };
        let axes = [Axis::X, Axis::Y, Axis::Z];
        let tool = TaskConfig {
            name: "tool".to_owned(),
            rows: TaskRows::Tool(tool_rows(&axes)),
            law: position(3, 20.0),
            scaled: false,
            streaming: Streaming::default(),
        };
        let config = ControllerConfig {
            limits: Limits::Robot(LimitKind::PositionVelocity),
            drive: Drive::IDEAL,
            constraints: vec![Constraint::Distances(avoidance)],
            ..ControllerConfig::new(Arc::clone(&robot), 0.004, vec![tool])
        };
        let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
        let (mut arm, mut memory, mut least) = (LaggingArm::at_rest(&[0.0; 3], IDEAL, 0.0, 1), None, f64::INFINITY);
        for i in 0..400 {
            let time_s = 0.004 * f64::from(if i < 3 { i } else { i + 60 });
            let mut measured = arm.measure(time_s);
            if i >= 3 {
                let value = StreamedValue::Pose { position: Some(Vector3::new(1.5, 0.0, 0.0)), orientation: None };
                measured.targets = vec![StreamedTarget { task: 0, time_s, value, velocity: None, ahead: Vec::new() }];
            }
            let command = stepper.step(&mut memory, &measured).unwrap();
            arm.follow(command.resolution.joint_velocity.as_slice(), 0.004);
            least = least.min(gap - arm.q[0]);
        }
        assert!((0.02 - 1e-6..0.03).contains(&least), "{gap} m: {least} m");
    }
}

#[test]
fn a_stepper_that_starts_in_the_middle_gives_the_same_commands() {
    let (setup, robot) = (Setup { noise: 1e-4, ..Setup::default() }, panda(true));
    let controller = Controller::new(config(&robot, setup)).unwrap();
    let mut stepper = Stepper::new(controller.clone()).unwrap();
    let mut arm = LaggingArm::at_rest(&HOME, setup.drive, setup.noise, 1);
    let (mut random, mut memory) = (Random(5), None);
    for i in 0..400 {
        let time_s = f64::from(i) * setup.period;
        let mut measured = arm.measure(time_s);
        if i % 100 == 0 {
            measured.targets = targets(&robot, &controller.config().tasks, time_s, &mut random);
        }
        let mut before = memory.clone();
        let command = stepper.step(&mut memory, &measured).unwrap().clone();
        if i % 5 == 0 {
            let again = Stepper::new(controller.clone()).unwrap().step(&mut before, &measured).unwrap().clone();
            assert_eq!((&command, &memory), (&again, &before), "period {i}");
        }
        arm.follow(command.resolution.joint_velocity.as_slice(), setup.period);
    }
}

/// An arm that begins inside an obstacle leaves it, with limits of acceleration and a slow drive, and where joints may jump.
#[test]
fn an_arm_inside_an_obstacle_leaves_it() {
    let robot = panda(false);
    let hand = Configuration::new(&robot, &HOME).unwrap().tool_pose().translation.vector;
    let ball = |x: f64| capsule([hand.x + x, hand.y, hand.z], [hand.x + x, hand.y, hand.z], 0.1);
    let slow = (LimitKind::PositionVelocityAcceleration, SLOW, SLOW, 0.001);
    let jumping = (LimitKind::PositionVelocity, Drive::IDEAL, IDEAL, 0.005);
    let depths = [0.0, 0.003, 0.05];
    for (depth, (kind, drive, plant, period)) in depths.into_iter().flat_map(|depth| [(depth, slow), (depth, jumping)])
    {
        let ball = ball(0.1 - depth + 0.03);
        let avoidance = CollisionAvoidance {
            min_distance_m: NEAREST,
            obstacles: vec![Obstacle::new("ball", ball, false).unwrap()],
            ..CollisionAvoidance::default()
        };
        let config = ControllerConfig {
            constraints: vec![Constraint::Distances(avoidance)],
            limits: Limits::Robot(kind),
            ..config(&robot, Setup { period, drive, ..Setup::default() })
        };
        let obstacles = vec![Obstacle::new("ball", ball, false).unwrap()];
        let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
        let mut arm = LaggingArm::at_rest(&HOME, plant, 0.0, 1);
        let mut memory = None;
        let start = nearest(&robot, &obstacles, &HOME) - NEAREST;
        assert!(start < 0.0, "{depth}: {start}");
        let mut deepest = start;
        for i in 0..3000 {
            let measured = arm.measure(f64::from(i) * period);
            let command = stepper.step(&mut memory, &measured).unwrap();
            arm.follow(command.resolution.joint_velocity.as_slice(), period);
            deepest = deepest.min(nearest(&robot, &obstacles, &arm.q) - NEAREST);
        }
        let end = nearest(&robot, &obstacles, &arm.q) - NEAREST;
        assert!(end > -1e-6, "{depth}, {kind:?}: from {start} m to {end} m");
        assert!(deepest > start - 1e-6, "{depth}, {kind:?}: from {start} m to {deepest} m");
    }
}

/// A steady pull into the post: the arm rests beside it, with noise too.
#[test]
fn an_arm_rests_before_an_obstacle() {
    for noise in [0.0, 1e-4] {
        let (setup, robot, obstacles) = (Setup { noise, ..Setup::default() }, panda(false), obstacles(false));
        let controller = Controller::new(config(&robot, Setup { seed: 2, ..setup })).unwrap();
        let mut stepper = Stepper::new(controller.clone()).unwrap();
        let mut arm = LaggingArm::at_rest(&HOME, setup.drive, noise, 1);
        let (mut memory, mut squares, mut least) = (None, 0.0, f64::INFINITY);
        for i in 0..6000 {
            let mut measured = arm.measure(f64::from(i) * 1e-3);
            if i == 0 {
                let value = StreamedValue::Pose { position: Some(Vector3::new(0.45, -0.35, 0.4)), orientation: None };
                measured.targets =
                    vec![StreamedTarget { task: 0, time_s: 0.0, value, velocity: None, ahead: Vec::new() }];
            }
            let command = stepper.step(&mut memory, &measured).unwrap();
            arm.follow(command.resolution.joint_velocity.as_slice(), 1e-3);
            if i >= 4000 {
                squares += command.resolution.joint_velocity.norm_squared() / 2000.0;
                least = least.min(nearest(&robot, &obstacles, &arm.q) - NEAREST);
            }
        }
        println!("noise {noise}: command {} rad/s RMS, distance {least} m more than needed", f64::sqrt(squares));
        assert!(f64::sqrt(squares) < 0.02, "{noise}: {} rad/s", f64::sqrt(squares));
        assert!((0.0..1e-3).contains(&least), "{noise}: {least} m");
    }
}

#[test]
fn controllers_that_cannot_keep_clear_are_refused() {
    let robot = panda(false);
    let with = |change: &dyn Fn(&mut ControllerConfig, &mut CollisionAvoidance)| {
        let mut avoidance = CollisionAvoidance::default();
        let mut config = config(&robot, Setup::default());
        change(&mut config, &mut avoidance);
        config.constraints = vec![Constraint::Distances(avoidance)];
        Controller::new(config).map(|_| ()).unwrap_err()
    };
    let bare = RobotModel::new("bare", "", robot.joints().to_vec(), *robot.tool()).unwrap();
    let bare = Arc::new(bare);
    let no_shapes = with(&|config, _| config.robot = Arc::clone(&bare));
    assert_eq!(no_shapes, ConfigError::Collisions(CollisionAvoidanceError::NoShapes("bare".to_owned())));
    let limits = with(&|config, _| config.limits = Limits::Robot(LimitKind::Velocity));
    assert_eq!(limits, ConfigError::Collisions(CollisionAvoidanceError::Limits));
    let number = with(&|_, avoidance| avoidance.min_distance_m = f64::NAN);
    assert_eq!(number, ConfigError::Collisions(CollisionAvoidanceError::Number));
    let near = with(&|_, avoidance| avoidance.min_distance_m = 1.0);
    assert!(matches!(near, ConfigError::Collisions(CollisionAvoidanceError::AlwaysNear(_))), "{near}");
    let long = with(&|config, _| config.period_s = 1e-5);
    assert!(matches!(long, ConfigError::Collisions(CollisionAvoidanceError::LongStop)), "{long}");
    let mut twice = config(&robot, Setup::default());
    twice.constraints.push(Constraint::Distances(CollisionAvoidance::default()));
    assert_eq!(Controller::new(twice).unwrap_err(), ConfigError::CollisionsTwice);
}

#[test]
fn a_state_names_all_moving_obstacles_and_no_other_ones() {
    let robot = panda(false);
    let mut stepper =
        Stepper::new(Controller::new(config(&robot, Setup { ball: 0.1, ..Setup::default() })).unwrap()).unwrap();
    let mut arm = LaggingArm::at_rest(&HOME, SLOW, 0.0, 1);
    let ball = Ball { position: Vector3::new(0.6, 0.0, 0.15), velocity: Vector3::zeros() }.state();
    let mut answer = |obstacles: Vec<ObstacleState>| {
        stepper.step(&mut None, &Measurement { obstacles, ..arm.measure(0.0) }).map(|_| ())
    };
    assert_eq!(answer(vec![ball.clone()]), Ok(()));
    let name = || "ball".to_owned();
    assert_eq!(answer(vec![]), Err(StepError::MissingObstacle { name: name() }));
    assert_eq!(answer(vec![ball.clone(), ball.clone()]), Err(StepError::ObstacleTwice { index: 1, name: name() }));
    let post = ObstacleState { name: "post".into(), ..ball.clone() };
    let unknown = StepError::UnknownObstacle { index: 1, name: "post".to_owned() };
    assert_eq!(answer(vec![ball.clone(), post]), Err(unknown));
    let nowhere = ObstacleState { position: Vector3::new(f64::NAN, 0.0, 0.0), ..ball };
    assert!(matches!(answer(vec![nowhere]), Err(StepError::Obstacle { index: 0, .. })));
}
