//! Damped commands are continuous along smooth paths of posture, task velocity and limits: steps that are eight times finer
//! make the largest change of q̇ at least four times smaller, across changes of active limits, ranks and conflicts.

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Resolution, Resolver, Solver, Status, resolve};
use revprio_core::task::{Task, TaskStack};
use revprio_robot::kinematics::{Axis, AxisSelection, Configuration};
use revprio_robot::{RobotModel, built_in};

use crate::problems::Random;

const METHODS: [Method; 5] = [
    Method::ReversePriority,
    Method::StrictReversePriority,
    Method::TaskPriority,
    Method::SingularityRobust,
    Method::DampedLeastSquares,
];

/// A value that moves along a + b sin(2π (t + c)), 0 ≤ t ≤ 1.
#[derive(Clone, Copy)]
struct Wave {
    a: f64,
    b: f64,
    c: f64,
}

impl Wave {
    fn random(random: &mut Random, middle: f64, size: f64) -> Self {
        Self { a: middle + size * random.unit(), b: size * random.unit(), c: random.unit() }
    }

    fn at(self, t: f64) -> f64 {
        self.a + self.b * (std::f64::consts::TAU * (t + self.c)).sin()
    }
}

/// A smooth path of a problem.
struct Path {
    robot: &'static RobotModel,
    method: Method,
    posture: Vec<Wave>,
    axes: Vec<Vec<Axis>>,
    velocity: Vec<Vec<Wave>>,
    /// Speed limit of each joint.
    speed: Vec<Wave>,
    damping: Damping,
}

fn panda() -> &'static RobotModel {
    built_in().iter().find(|robot| robot.name() == "panda").expect("a built-in robot")
}

impl Path {
    /// Two or three tasks of a Panda; half of the paths pass the stretched elbow, where the tool's Jacobian loses rank.
    fn random(seed: u64, method: Method) -> Self {
        let mut random = Random::new(seed);
        let mut posture: Vec<Wave> = (0..7).map(|_| Wave::random(&mut random, 0.0, 0.8)).collect();
        posture[3] = if random.one_in(2) {
            Wave { a: -0.1 * random.unit().abs(), b: 0.25, c: random.unit() }
        } else {
            Wave::random(&mut random, -1.5, 0.4)
        };
        let axes: Vec<Vec<Axis>> = match random.below(3) {
            0 => vec![vec![Axis::X, Axis::Y, Axis::Z], vec![Axis::Rx, Axis::Ry, Axis::Rz]],
            1 => vec![vec![Axis::X], vec![Axis::Y, Axis::Z], vec![Axis::Rx, Axis::Ry, Axis::Rz]],
            _ => vec![vec![Axis::X], vec![Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz]],
        };
        let velocity =
            axes.iter().map(|axes| axes.iter().map(|_| Wave::random(&mut random, 0.0, 0.3)).collect()).collect();
        let speed = (0..7).map(|_| Wave { a: 0.6 + 0.3 * random.unit(), b: 0.1, c: random.unit() }).collect();
        Self { robot: panda(), method, posture, axes, velocity, speed, damping: Damping::STANDARD }
    }

    fn problem(&self, t: f64) -> Problem {
        let posture: Vec<f64> = self.posture.iter().map(|wave| wave.at(t)).collect();
        let configuration = Configuration::new(self.robot, &posture).unwrap();
        let task = |(axes, velocity): (&Vec<Axis>, &Vec<Wave>)| {
            let rows = AxisSelection::new(axes).unwrap().rows_of(configuration.jacobian());
            Task::new("", rows, Vector::from_iterator(axes.len(), velocity.iter().map(|wave| wave.at(t))))
        };
        let tasks = TaskStack::new(self.axes.iter().zip(&self.velocity).map(task).collect()).unwrap();
        let upper: Vec<f64> = self.speed.iter().map(|wave| wave.at(t)).collect();
        let lower: Vec<f64> = upper.iter().map(|speed| -speed).collect();
        let limits = VelocityBox::new(&lower, &upper).unwrap();
        Problem { limits, method: self.method, damping: Some(self.damping), ..Problem::new(tasks) }
    }

    /// Returns the largest change of any joint's velocity in one step, and the number of steps with active limits.
    fn largest_change(&self, steps: u32, solver: Solver) -> (f64, u32) {
        let (mut resolver, mut answer) = (Resolver::default(), Resolution::default());
        let mut before: Option<Vector> = None;
        let (mut largest, mut limited) = (0.0_f64, 0);
        for step in 0..=steps {
            let t = f64::from(step) / f64::from(steps);
            let guess = answer.active_set.clone();
            let problem = Problem { solver, ..self.problem(t) };
            resolver.resolve(&problem, &guess, &mut answer).unwrap();
            assert_eq!(answer.solver.status, Status::Optimal, "t = {t}");
            limited += u32::from(!answer.active_limits.is_empty());
            if let Some(before) = &before {
                largest = largest.max((&answer.joint_velocity - before).amax());
            }
            before = Some(answer.joint_velocity.clone());
        }
        (largest, limited)
    }
}

/// Steps of the coarsest walk along a path.
const STEPS: u32 = 1000;

/// Changes below this are no jump, however they compare: rad/s.
const SMALL: f64 = 1e-3;

/// Returns the largest changes of the walks that were needed, if none of them shows that the path is continuous.
///
/// A steep change may need finer steps than the coarsest walk has; a jump stays, however fine the steps are.
fn jump(path: &Path, limited: &mut u32) -> Option<Vec<f64>> {
    let mut changes = Vec::new();
    for refinement in 0..4 {
        let (change, active) = path.largest_change(STEPS * 8_u32.pow(refinement), Solver::Auto);
        *limited += if refinement == 0 { active } else { 0 };
        if change <= SMALL || changes.last().is_some_and(|coarse| change <= coarse / 4.0) {
            return None;
        }
        changes.push(change);
    }
    Some(changes)
}

fn assert_continuous(seeds: std::ops::Range<u64>) {
    let mut limited = 0;
    for (method, seed) in METHODS.into_iter().flat_map(|method| seeds.clone().map(move |seed| (method, seed))) {
        let jump = jump(&Path::random(seed, method), &mut limited);
        assert!(jump.is_none(), "{method:?}, seed {seed}: the largest changes are {jump:?}");
    }
    let walks = METHODS.len() as f64 * seeds.count() as f64;
    assert!(f64::from(limited) > 0.2 * f64::from(STEPS) * walks, "limits are rarely active: {limited}");
}

#[test]
fn damped_commands_are_continuous_where_limits_ranks_and_conflicts_change() {
    assert_continuous(0..8);
}

#[test]
#[ignore = "a hundred paths of each method take about half an hour"]
fn damped_commands_are_continuous_along_a_hundred_paths() {
    assert_continuous(0..100);
}

fn matrix(rows: usize, entries: &[f64]) -> Matrix {
    Matrix::from_row_slice(rows, entries.len() / rows, entries)
}

fn damped(method: Method, limits: VelocityBox, tasks: Vec<Task>) -> Resolution {
    let damping = Some(Damping::STANDARD);
    resolve(&Problem { limits, method, damping, ..Problem::new(TaskStack::new(tasks).unwrap()) }, &[]).unwrap()
}

#[test]
fn an_active_limit_does_not_make_the_answer_jump_where_damping_begins() {
    // σ_min of [[1, 0, 1], [t, t, 0]] is 0.05 where t² has this value.
    let squared = 0.05_f64.powi(2) * (2.0 - 0.05_f64.powi(2)) / (3.0 - 2.0 * 0.05_f64.powi(2));
    let threshold = squared.sqrt();
    for method in METHODS {
        let at = |t: f64| {
            let sum = Task::new("sum", matrix(1, &[1.0, 0.0, 1.0]), Vector::from_element(1, 1.0));
            let weak = Task::new("weak", matrix(1, &[t, t, 0.0]), Vector::from_element(1, 0.5 * t));
            damped(method, VelocityBox::new(&[-1.0; 3], &[0.3, 1.0, 1.0]).unwrap(), vec![sum, weak])
        };
        let (below, above) = (at(threshold - 1e-8), at(threshold + 1e-8));
        assert!(
            below.singularity.smallest_singular_value() < 0.05 && above.singularity.smallest_singular_value() > 0.05
        );
        let change = (&below.joint_velocity - &above.joint_velocity).amax();
        assert!(change < 1e-3, "{method:?}: {change}");
    }
}

#[test]
fn inequality_rows_that_become_parallel_do_not_make_the_answer_jump() {
    let at = |t: f64| {
        let (lower, upper) = (Vector::from_vec(vec![-3.0, -3.0, -5.0]), Vector::from_vec(vec![0.0, 0.0, 5.0]));
        let wedge = Task::between("wedge", matrix(3, &[1.0, t, -1.0, t, 0.0, 1.0]), lower, upper);
        let move_out = Task::new("move out", matrix(1, &[0.0, 1.0]), Vector::from_element(1, 0.5));
        let limits = VelocityBox::new(&[-1.0; 2], &[1.0; 2]).unwrap();
        damped(Method::StrictReversePriority, limits, vec![wedge, move_out]).joint_velocity
    };
    assert!((at(1e-9) - at(-1e-9)).amax() < 1e-3);
    assert!((at(0.2) - at(0.0)).amax() > 0.4, "the exact answers differ");
}
