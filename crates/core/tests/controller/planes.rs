//! Fast approaches to virtual planes behind a drive with lag and dead time, in any posture and direction.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;
use revprio_core::constraint::{Constraint, PlanePoint, VirtualPlane};
use revprio_core::controller::{ControllerConfig, Limits, Stepper, TaskConfig};
use revprio_core::law::{Law, PositionLaw};
use revprio_core::limits::{Drive, LimitKind};
use revprio_core::resolution::Solver;
use revprio_core::rows::{TargetPose, TaskRows, ToolRows};
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{Joint, RobotModel, built_in};

use super::arms::{NOMINAL, Random, constant, controller, position, sawyer, task, tool_rows, with_jerk};
use super::drives::LaggingArm;

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// Largest error of a measured position, rad.
const NOISE: f64 = 1e-4;

/// Speed of the fastest joint at the end, rad/s, above which the tool still slides along the plane.
const RESTING: f64 = 0.5;

/// Speed of the fastest joint at the end, rad/s, below which the tool counts as resting.
const CALM: f64 = 0.1;

/// One approach of the tool to a plane.
struct Approach {
    robot: Arc<RobotModel>,
    start: Vec<f64>,
    normal: Vector3<f64>,
    /// Offset of the plane, m.
    offset: f64,
    /// Behind the plane, seldom straight ahead.
    target: Vector3<f64>,
    gain: f64,
}

/// What an approach shows.
#[derive(Debug)]
struct Seen {
    /// Largest distance behind the plane, m.
    outside: f64,
    /// Largest speed along the normal, m/s.
    speed: f64,
    /// Largest minus smallest distance in the last 0.3 s, m.
    swing: f64,
    /// RMS of the fastest joint's command in the last 0.3 s, rad/s.
    command: f64,
    /// Periods in which an inequality was violated.
    violated: u32,
}

impl Approach {
    fn random(random: &mut Random, arms: &[Arc<RobotModel>], rise: Option<f64>, gain: f64) -> Self {
        let robot = &arms[random.below(arms.len())];
        let robot = rise.map_or_else(|| Arc::clone(robot), |rise| Arc::new(with_jerk(robot, rise)));
        let start: Vec<f64> = robot
            .joints()
            .iter()
            .map(|joint: &Joint| {
                let (lower, upper) = (joint.limits.lower.max(-3.0), joint.limits.upper.min(3.0));
                0.5 * (lower + upper + 0.8 * random.signed() * (upper - lower))
            })
            .collect();
        let normal = Vector3::from_fn(|_, _| random.signed()).normalize();
        let tool = Configuration::new(&robot, &start).unwrap().tool_pose().translation.vector;
        let distance = 0.1 + 0.2 * random.signed().abs();
        let sideways = Vector3::from_fn(|_, _| 0.4 * random.signed());
        let target = tool + normal * (distance + 0.4) + sideways;
        Self { robot, start, normal, offset: normal.dot(&tool) + distance, target, gain }
    }

    fn beyond(&self, q: &[f64]) -> f64 {
        let tool = Configuration::new(&self.robot, q).unwrap().tool_pose().translation.vector;
        self.normal.dot(&tool) - self.offset
    }

    fn run(&self, kind: LimitKind, period: f64, drive: Drive, stated: Drive, noise: f64) -> Seen {
        let law = PositionLaw::new(vec![self.gain; 3]).unwrap();
        let mut pose = *Configuration::new(&self.robot, &self.start).unwrap().tool_pose();
        pose.translation.vector = self.target;
        let rows = TaskRows::Tool(ToolRows { target_pose: TargetPose::Fixed(pose), ..tool_rows(&LINEAR) });
        let reach = TaskConfig { rows, ..task(&LINEAR, Law::Position(law)) };
        let normal = [self.normal.x, self.normal.y, self.normal.z];
        let plane = VirtualPlane::new("plane", normal, self.offset, PlanePoint::Tool, 10.0).unwrap();
        let config = ControllerConfig::new(Arc::clone(&self.robot), period, vec![reach]);
        let constraints = vec![Constraint::Plane(plane)];
        let limits = Limits::Robot(kind);
        let config = ControllerConfig { constraints, limits, drive: stated, leave_local_minima: false, ..config };
        let mut stepper = Stepper::new(controller(config)).unwrap();
        let (mut arm, mut memory) = (LaggingArm::at_rest(&self.start, drive, noise, 1), None);
        let mut seen = Seen { outside: f64::MIN, speed: 0.0, swing: 0.0, command: 0.0, violated: 0 };
        let (mut lowest, mut highest, mut squares, mut resting) = (f64::MAX, f64::MIN, 0.0, 0.0);
        let mut time_s = 0.0;
        let mut before = self.beyond(&self.start);
        while time_s < 4.0 {
            let command = stepper.step(&mut memory, &arm.measure(time_s)).unwrap();
            arm.follow(command.resolution.joint_velocity.as_slice(), period);
            seen.violated += u32::from(command.resolution.broken_constraints().next().is_some());
            let beyond = self.beyond(&arm.q);
            seen.outside = seen.outside.max(beyond);
            seen.speed = seen.speed.max((beyond - before) / period);
            before = beyond;
            if time_s > 3.7 {
                (lowest, highest) = (lowest.min(beyond), highest.max(beyond));
                squares += command.resolution.joint_velocity.amax().powi(2);
                resting += 1.0;
            }
            time_s += period;
        }
        Seen { swing: highest - lowest, command: (squares / resting).sqrt(), ..seen }
    }
}

/// What a set of approaches shows; pairs: without and with noise.
#[derive(Debug)]
struct Found {
    /// Distances behind the plane, m, ascending.
    outside: [Vec<f64>; 2],
    /// Largest swing at rest, m.
    swing: [f64; 2],
    /// Approaches that are fast, come to rest, still slide, and violate an inequality.
    fast: usize,
    calm: usize,
    still_sliding: usize,
    violated: usize,
}

impl Found {
    fn reached(&self) -> usize {
        self.outside.iter().map(Vec::len).sum()
    }

    /// Returns how many pass the plane by more than this, m.
    fn passed(&self, noisy: usize, distance: f64) -> usize {
        self.outside[noisy].iter().filter(|outside| **outside > distance).count()
    }

    /// Returns the distance behind the plane that so many percent of the approaches do not exceed, mm.
    fn quantile(&self, noisy: usize, percent: usize) -> f64 {
        let list = &self.outside[noisy];
        1e3 * list[(list.len() - 1) * percent / 100]
    }

    /// Asserts that approaches seldom pass the plane by more than a millimetre, and swing by little at rest, and that few cannot keep the plane.
    fn check(&self, may_violate: usize) {
        let passed = self.passed(0, 1e-3) + self.passed(1, 1e-3);
        let Self { outside, swing, fast, calm, still_sliding, violated } = self;
        let most = [0, 1].map(|noisy| self.quantile(noisy, 95));
        println!(
            "{passed} of {} pass, {fast} fast, {calm} calm, {still_sliding} slide, {violated} violate, 95 % within {most:?} mm, swing {swing:?}",
            self.reached()
        );
        assert!(self.reached() > 150 && *fast > 50 && *calm > 100, "{outside:?}");
        assert!(most[0] <= 0.2 && most[1] <= 0.4 && passed <= 4, "{outside:?}");
        assert!(*violated <= may_violate, "{violated} approaches cannot keep the plane");
        assert!(swing.iter().all(|swing| *swing <= 2e-3), "{swing:?}");
    }
}

/// Runs 240 approaches of random arms, drives, periods and gains for each sequence of random numbers; `rise`: A/J of the arms, s.
fn approaches(arms: &[Arc<RobotModel>], rise: Option<f64>, sequences: Range<u64>) -> Found {
    let mut found =
        Found { outside: [vec![], vec![]], swing: [0.0; 2], fast: 0, calm: 0, still_sliding: 0, violated: 0 };
    for sequence in sequences {
        let mut random = Random(sequence);
        for case in 0..240 {
            let gain = 2.0 + 18.0 * random.signed().abs();
            let approach = Approach::random(&mut random, arms, rise, gain);
            let period = 1e-3 * 10_f64.powf(random.signed().abs());
            let lag_s = if random.below(4) == 0 { 0.0 } else { 0.03 * random.signed().abs() };
            let drive = Drive { lag_s, delay_periods: random.below(3) };
            let stated = [drive, Drive::CONSERVATIVE][case % 2];
            let noisy = usize::from(case % 4 < 2);
            let kind =
                [LimitKind::PositionVelocityAcceleration, LimitKind::PositionVelocity][usize::from(case % 8 == 7)];
            let seen = approach.run(kind, period, drive, stated, [0.0, NOISE][noisy]);
            if seen.outside < -5e-3 {
                continue;
            }
            found.outside[noisy].push(seen.outside);
            found.fast += usize::from(seen.speed > 0.5);
            found.violated += usize::from(seen.violated > 0);
            found.still_sliding += usize::from(seen.command > RESTING);
            if seen.command <= CALM {
                found.calm += 1;
                found.swing[noisy] = found.swing[noisy].max(seen.swing);
            }
        }
    }
    found.outside.iter_mut().for_each(|list| list.sort_by(f64::total_cmp));
    found
}

/// Damping averages several solutions, whose sum is at the plane up to rounding.
#[test]
fn a_damped_tool_that_rests_at_a_plane_names_it_in_every_period() {
    let robot = sawyer();
    let height = Configuration::new(&robot, &NOMINAL).unwrap().tool_pose().translation.vector.z;
    let plane = VirtualPlane::new("floor", [0.0, 0.0, -1.0], 0.01 - height, PlanePoint::Tool, 10.0).unwrap();
    let down = Law::Velocity(constant(&[-0.02]));
    let others = [Axis::X, Axis::Y, Axis::Rx, Axis::Ry, Axis::Rz];
    let tasks = vec![task(&[Axis::Z], down), task(&others, position(5, 2.0))];
    let config = ControllerConfig::new(Arc::clone(&robot), 0.004, tasks);
    let config = ControllerConfig { constraints: vec![Constraint::Plane(plane)], ..config };
    for solver in [Solver::Auto, Solver::Qp] {
        let mut stepper = crate::solvers::stepper(controller(ControllerConfig { solver, ..config.clone() }));
        let (mut arm, mut memory, mut blended) = (LaggingArm::at_rest(&NOMINAL, Drive::IDEAL, 0.0, 1), None, 0);
        for period in 0..1500 {
            let command = stepper.step(&mut memory, &arm.measure(0.004 * f64::from(period))).unwrap();
            if period > 1000 {
                let active = command.resolution.active_constraints().count();
                assert_eq!(active, 1, "{solver:?}, period {period}");
                blended += usize::from(command.resolution.solver.working_sets > 1);
            }
            arm.follow(command.resolution.joint_velocity.as_slice(), 0.004);
        }
        assert!(solver == Solver::Qp || blended > 400, "{blended}");
    }
}

#[test]
fn fast_approaches_stop_at_the_plane_in_any_posture() {
    approaches(&built_in()[..5], None, 1..2).check(10);
}

/// Arms that need 200 ms to reach their acceleration pass planes far more often.
#[test]
fn fast_approaches_of_arms_with_jerk_limits_stop_at_the_plane() {
    for rise in [0.01, 0.05] {
        approaches(&built_in()[..5], Some(rise), 1..2).check(usize::MAX);
    }
    let slow = approaches(&built_in()[..5], Some(0.2), 1..2);
    assert!(slow.passed(0, 1e-3) + slow.passed(1, 1e-3) <= 20, "{slow:?}");
}

#[test]
fn fast_approaches_of_arms_of_other_sizes_stop_at_the_plane() {
    approaches(&built_in()[5..], None, 1..2).check(10);
}

#[test]
#[ignore = "five minutes; prints the table of docs/limits.md"]
fn table_of_fast_approaches() {
    println!(
        "| arms | noise | approaches | 95 %, 99 %, worst, mm | by more than 1 mm, 5 mm |\n|---|---|---:|---:|---:|"
    );
    let (five, others) = built_in().split_at(5);
    for (label, arms, rise) in [
        ("the five", five, None),
        ("the other ones", others, None),
        ("the five, A/J = 10 ms", five, Some(0.01)),
        ("the five, A/J = 50 ms", five, Some(0.05)),
        ("the five, A/J = 200 ms", five, Some(0.2)),
    ] {
        let found = approaches(arms, rise, 1..11);
        for (noisy, noise) in ["0", "1e-4 rad"].into_iter().enumerate() {
            let [most, nearly_all, worst] = [95, 99, 100].map(|percent| found.quantile(noisy, percent));
            let (passed, far) = (found.passed(noisy, 1e-3), found.passed(noisy, 5e-3));
            println!(
                "| {label} | {noise} | {} | {most:.2}, {nearly_all:.2}, {worst:.1} | {passed}, {far} |",
                found.outside[noisy].len()
            );
        }
        let Found { fast, calm, still_sliding, violated, swing, .. } = found;
        println!("{fast} fast, {calm} calm, {still_sliding} slide, {violated} violate, swing {swing:?}");
    }
}
