//! Random smooth paths of posture, task velocity and limits, for the tests of continuity.

use revprio_core::constraint::Inequality;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Resolution, Solve, Solver, Status};
use revprio_core::task::{Task, TaskStack};
use revprio_robot::kinematics::{Axis, AxisSelection, Configuration};
use revprio_robot::{RobotModel, built_in};

use crate::problems::Random;

/// The methods that damp.
pub const METHODS: [Method; 5] = [
    Method::ReversePriority,
    Method::StrictReversePriority,
    Method::TaskPriority,
    Method::SingularityRobust,
    Method::DampedLeastSquares,
];

/// What a family of paths crosses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Two or three tasks within velocity limits; half of the paths pass near a stretched arm.
    Velocity,
    /// The same, with a narrow box around a velocity that moves: what acceleration limits leave of one period.
    Acceleration,
    /// Two tasks ask for different velocities along one axis, and a third one for those of the joints.
    Conflict,
    /// A hard inequality, and a task with bounds between two tasks of equations.
    Inequalities,
    /// The arm is stretched exactly at the middle of the path.
    Stretched,
}

pub const FAMILIES: [Family; 5] =
    [Family::Velocity, Family::Acceleration, Family::Conflict, Family::Inequalities, Family::Stretched];

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

/// The rows of a task.
enum Rows {
    Tool(Vec<Axis>),
    Joints,
}

struct PathTask {
    rows: Rows,
    velocity: Vec<Wave>,
    /// Half the distance between the bounds of an inequality task.
    half_width: Option<f64>,
}

/// A smooth path of a problem.
pub struct Path {
    robot: &'static RobotModel,
    method: Method,
    posture: Vec<Wave>,
    tasks: Vec<PathTask>,
    /// Speed limit of each joint.
    speed: Vec<Wave>,
    /// Middle and half width of a narrower box.
    narrow: Option<(Vec<Wave>, f64)>,
    inequality: Option<(Vec<Wave>, Wave)>,
    damping: Damping,
}

fn robot(name: &str) -> &'static RobotModel {
    built_in().iter().find(|robot| robot.name() == name).expect("a built-in robot")
}

/// Tool axes of the tasks, highest priority first.
fn axes(random: &mut Random, robot: &RobotModel, family: Family) -> Vec<Vec<Axis>> {
    use Axis::{Rx, Ry, Rz, X, Y, Z};
    match (robot.joint_count() == 3, family) {
        (true, Family::Conflict) => vec![vec![X], vec![X, Y]],
        (true, _) => match random.below(3) {
            0 => vec![vec![X, Y], vec![Rz]],
            1 => vec![vec![X], vec![Y]],
            _ => vec![vec![Rz], vec![X], vec![Y]],
        },
        (false, Family::Conflict) => match random.below(2) {
            0 => vec![vec![X, Y, Z], vec![Z, Rx]],
            _ => vec![vec![X], vec![X, Y, Z]],
        },
        (false, _) => match random.below(3) {
            0 => vec![vec![X, Y, Z], vec![Rx, Ry, Rz]],
            1 => vec![vec![X], vec![Y, Z], vec![Rx, Ry, Rz]],
            _ => vec![vec![X], vec![Y, Z, Rx, Ry, Rz]],
        },
    }
}

impl Path {
    pub fn random(seed: u64, method: Method, family: Family) -> Self {
        let mut random = Random::new(seed);
        let robot = robot(random.pick(&["panda", "sawyer", "planar_3r"]));
        let n = robot.joint_count();
        let mut posture: Vec<Wave> = (0..n).map(|_| Wave::random(&mut random, 0.0, 0.8)).collect();
        // A joint at zero stretches the arm.
        let elbow = if n == 3 { 1 } else { 3 };
        posture[elbow] = match family {
            Family::Stretched => Wave { a: 0.0, b: 0.4 + 0.2 * random.unit(), c: 0.5 },
            _ if random.one_in(2) => Wave { a: -0.1 * random.unit().abs(), b: 0.25, c: random.unit() },
            _ => Wave::random(&mut random, -1.5, 0.4),
        };
        if family == Family::Stretched && n == 3 {
            posture[2] = Wave { a: 0.0, b: 0.3 * random.unit(), c: 0.5 };
        }
        let mut tasks: Vec<PathTask> = axes(&mut random, robot, family)
            .into_iter()
            .map(|axes| PathTask {
                velocity: axes.iter().map(|_| Wave::random(&mut random, 0.0, 0.3)).collect(),
                rows: Rows::Tool(axes),
                half_width: None,
            })
            .collect();
        let joints = |random: &mut Random, size| (0..n).map(|_| Wave::random(random, 0.0, size)).collect::<Vec<_>>();
        let mut inequality = None;
        if family == Family::Conflict {
            tasks.push(PathTask { rows: Rows::Joints, velocity: joints(&mut random, 0.2), half_width: None });
        }
        if family == Family::Inequalities {
            let velocity = joints(&mut random, 0.1);
            let place = random.below(tasks.len() + 1);
            tasks.insert(place, PathTask { rows: Rows::Joints, velocity, half_width: Some(0.3) });
            if random.one_in(2) {
                inequality = Some((joints(&mut random, 1.0), Wave { a: 0.15, b: 0.1, c: random.unit() }));
            }
        }
        let speed = (0..n).map(|_| Wave { a: 0.6 + 0.3 * random.unit(), b: 0.1, c: random.unit() }).collect();
        let narrow = (family == Family::Acceleration).then(|| (joints(&mut random, 0.08), random.pick(&[0.02, 0.1])));
        Self { robot, method, posture, tasks, speed, narrow, inequality, damping: Damping::STANDARD }
    }

    pub fn problem(&self, t: f64) -> Problem {
        let at = |waves: &[Wave]| waves.iter().map(|wave| wave.at(t)).collect::<Vec<f64>>();
        let configuration = Configuration::new(self.robot, &at(&self.posture)).unwrap();
        let n = self.robot.joint_count();
        let task = |task: &PathTask| {
            let rows = match &task.rows {
                Rows::Tool(axes) => AxisSelection::new(axes).unwrap().rows_of(configuration.jacobian()),
                Rows::Joints => Matrix::identity(n, n),
            };
            let velocity = Vector::from_vec(at(&task.velocity));
            match task.half_width {
                Some(width) => Task::between("", rows, velocity.add_scalar(-width), velocity.add_scalar(width)),
                None => Task::new("", rows, velocity),
            }
        };
        let tasks = TaskStack::new(self.tasks.iter().map(task).collect()).unwrap();
        let mut upper = at(&self.speed);
        let mut lower: Vec<f64> = upper.iter().map(|speed| -speed).collect();
        if let Some((middle, half_width)) = &self.narrow {
            for (joint, middle) in at(middle).into_iter().enumerate() {
                // The middle stays inside the speed limits.
                upper[joint] = upper[joint].min(middle + half_width);
                lower[joint] = lower[joint].max(middle - half_width);
            }
        }
        let inequalities =
            self.inequality.iter().map(|(row, bound)| Inequality::new("", at(row), bound.at(t)).unwrap());
        Problem {
            limits: VelocityBox::new(&lower, &upper).unwrap(),
            inequalities: inequalities.collect(),
            method: self.method,
            damping: Some(self.damping),
            ..Problem::new(tasks)
        }
    }
}

/// A step along a path.
#[derive(Clone, Copy)]
pub struct Step {
    pub from: f64,
    pub to: f64,
    /// Largest change of a joint's velocity, rad/s.
    pub change: f64,
}

/// Answers along a path.
pub struct Walk<'a> {
    path: &'a Path,
    solver: Box<dyn Solve>,
    answer: Resolution,
    /// Answers with active limits.
    pub limited: u32,
    /// Working sets of all answers.
    pub working_sets: u32,
    /// Sum of the residuals of each task over all answers.
    pub residuals: [f64; 4],
}

impl<'a> Walk<'a> {
    pub fn new(path: &'a Path, solver: Solver) -> Self {
        let (solver, answer) = (crate::solvers::solver(solver), Resolution::default());
        Self { path, solver, answer, limited: 0, working_sets: 0, residuals: [0.0; 4] }
    }

    pub fn at(&mut self, t: f64) -> Vector {
        let guess = self.answer.active_set.clone();
        let problem = self.path.problem(t);
        self.solver.solve(&problem, &guess, &mut self.answer).unwrap();
        let answer = &self.answer;
        assert_eq!(answer.solver.status, Status::Optimal, "t = {t}");
        assert!(problem.limits.allows(answer.joint_velocity.as_slice()), "t = {t}");
        self.limited += u32::from(answer.active_limits().next().is_some());
        self.working_sets += answer.solver.working_sets;
        for (sum, task) in self.residuals.iter_mut().zip(&answer.tasks) {
            *sum += task.residual_norm;
        }
        answer.joint_velocity.clone()
    }

    /// Walks along the path in equal steps.
    pub fn steps(&mut self, count: u32) -> Vec<Step> {
        self.split(Step { from: 0.0, to: 1.0, change: f64::NAN }, count)
    }

    /// Walks along a step in `count` equal parts.
    pub fn split(&mut self, step: Step, count: u32) -> Vec<Step> {
        let place = |part: u32| step.from + (step.to - step.from) * f64::from(part) / f64::from(count);
        let mut before = self.at(step.from);
        let part = |part: u32| {
            let now = self.at(place(part));
            let change = (&now - &before).amax();
            before = now;
            Step { from: place(part - 1), to: place(part), change }
        };
        (1..=count).map(part).collect()
    }
}
