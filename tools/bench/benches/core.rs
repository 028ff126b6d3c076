//! The mathematical core on the arm of the paper: one row per quantity of docs/performance.md.

use std::sync::Arc;

use divan::{Bencher, black_box};
use nalgebra::IsometryMatrix3;
use revprio::service::{solver, stepper};
use revprio_core::controller::{Controller, ControllerConfig, Limits, Measurement, TaskConfig};
use revprio_core::law::{Law, PositionLaw, Profile};
use revprio_core::limits::{JointMotion, LimitKind, VelocityBox};
use revprio_core::linalg::Vector;
use revprio_core::resolution::{Problem, Resolution, Resolver, Solver};
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_core::task::{Task, TaskStack};
use revprio_robot::kinematics::{Axis, AxisSelection, BodyFrame, Configuration, TaskBody, TaskFrame};
use revprio_robot::{RobotModel, UrdfTip, UrdfTreeOptions, built_in};

const POSTURE: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];

fn main() {
    divan::main();
}

fn sawyer() -> Arc<RobotModel> {
    built_in()[0].clone()
}

/// Push along x, hold the other five directions.
fn two_tasks(configuration: &Configuration, push: f64, hold: f64) -> TaskStack {
    let task = |name: &str, axes: &[Axis], velocity: Vec<f64>| {
        let rows = AxisSelection::new(axes).unwrap().rows_of(configuration.jacobian());
        Task::new(name, rows, Vector::from_vec(velocity))
    };
    let others = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
    let tasks = vec![
        task("push", &[Axis::X], vec![push]),
        task("hold", &others, vec![hold, -0.5 * hold, 0.2 * hold, 0.0, 0.1 * hold]),
    ];
    TaskStack::new(tasks).unwrap()
}

#[divan::bench]
fn kinematics(bencher: Bencher) {
    let robot = sawyer();
    let mut configuration = Configuration::new(&robot, &POSTURE).unwrap();
    bencher.bench_local(|| {
        configuration.update(black_box(&robot), black_box(&POSTURE)).unwrap();
        configuration.jacobian()[(0, 0)]
    });
}

/// Kinematics, the rows of the tasks, reverse priority, ranks, smallest singular value and manipulability.
#[divan::bench]
fn auto_two_tasks_without_limits(bencher: Bencher) {
    let robot = sawyer();
    let mut configuration = Configuration::new(&robot, &POSTURE).unwrap();
    let mut problem = Problem::new(two_tasks(&configuration, 0.05, 0.02));
    let (push, hold) = selections();
    let (mut resolver, mut answer) = (Resolver::default(), Resolution::default());
    bencher.bench_local(|| {
        configuration.update(&robot, black_box(&POSTURE)).unwrap();
        overwrite(&mut problem.tasks, &configuration, &push, &hold);
        resolver.resolve(black_box(&problem), &[], &mut answer).unwrap();
        answer.joint_velocity[0]
    });
}

fn selections() -> (AxisSelection, AxisSelection) {
    let others = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
    (AxisSelection::new(&[Axis::X]).unwrap(), AxisSelection::new(&others).unwrap())
}

fn overwrite(tasks: &mut TaskStack, configuration: &Configuration, push: &AxisSelection, hold: &AxisSelection) {
    tasks
        .overwrite(|k, jacobian, _, _| {
            let axes = if k == 0 { push } else { hold };
            TaskFrame::default().at(configuration).write_rows(axes, jacobian);
        })
        .unwrap();
}

/// One second of a 1 kHz trajectory; limits are active for about half of the time.
struct Trajectory {
    problems: Vec<Problem>,
    solver: Solver,
}

impl Trajectory {
    fn new(solver: Solver) -> Self {
        let robot = sawyer();
        let at = |i: i32| {
            let t = f64::from(i) * 1e-3;
            let posture: Vec<f64> = POSTURE.iter().enumerate().map(|(j, q)| q + 0.1 * (t + j as f64).sin()).collect();
            let configuration = Configuration::new(&robot, &posture).unwrap();
            let speed = 0.6 * (std::f64::consts::TAU * t).sin();
            let tasks = two_tasks(&configuration, speed, 0.4 * speed);
            let limits = VelocityBox::new(&[-0.35; 7], &[0.35; 7]).unwrap();
            Problem { limits, ..Problem::new(tasks) }
        };
        Self { problems: (0..1000).map(at).collect(), solver }
    }

    /// Keeps only the cycles with active limits.
    fn limited(mut self) -> Self {
        self.problems.retain(|problem| {
            let answer = revprio_core::resolution::resolve(problem, &[]).unwrap();
            answer.active_limits().next().is_some()
        });
        self
    }

    fn run(&self, bencher: Bencher) {
        let (mut solver, mut answer) = (solver(self.solver), Resolution::default());
        let mut guess = Vec::new();
        let mut i = 0;
        bencher.bench_local(|| {
            solver.solve(&self.problems[i], &guess, &mut answer).unwrap();
            guess.clone_from(&answer.active_set);
            i = (i + 1) % self.problems.len();
            answer.joint_velocity[0]
        });
    }
}

#[divan::bench(sample_count = 1000, sample_size = 10)]
fn auto_two_tasks_trajectory(bencher: Bencher) {
    Trajectory::new(Solver::Auto).run(bencher);
}

#[divan::bench(sample_count = 1000, sample_size = 10)]
fn auto_two_tasks_limited_cycles(bencher: Bencher) {
    Trajectory::new(Solver::Auto).limited().run(bencher);
}

#[divan::bench(sample_count = 1000, sample_size = 1)]
fn qp_two_tasks(bencher: Bencher) {
    Trajectory::new(Solver::Qp).run(bencher);
}

/// A whole control period: laws, kinematics, resolution, memory.
#[divan::bench(args = [Solver::ClosedForm, Solver::Auto, Solver::Qp], sample_count = 1000, sample_size = 1)]
fn controller_step(bencher: Bencher, solver: Solver) {
    let task = |name: &str, axes: &[Axis], amplitude: f64| {
        let rows = ToolRows::new(AxisSelection::new(axes).unwrap());
        let (zeros, swing) = (vec![0.0; axes.len()], vec![amplitude; axes.len()]);
        let law = Law::Velocity(Profile::sine(zeros, swing, std::f64::consts::TAU, 0.0).unwrap());
        TaskConfig {
            name: name.to_owned(),
            rows: TaskRows::Tool(rows),
            law,
            scaled: false,
            streaming: Streaming::default(),
        }
    };
    let others = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
    let tasks = vec![task("swing", &[Axis::X], 0.4), task("hold", &others, 0.0)];
    let limits = Limits::Fixed(VelocityBox::new(&[-0.35; 7], &[0.35; 7]).unwrap());
    let controller =
        Controller::new(ControllerConfig { solver, limits, ..ControllerConfig::new(sawyer(), 1e-3, tasks) }).unwrap();
    let (mut stepper, mut memory) = (stepper(controller).unwrap(), None);
    let mut measured = at_rest();
    bencher.bench_local(|| {
        let command = stepper.step(&mut memory, &measured).unwrap();
        let speeds = command.resolution.joint_velocity.iter();
        measured.joint_position.iter_mut().zip(speeds).for_each(|(q, speed)| *q += 1e-3 * speed);
        measured.time_s += 1e-3;
    });
}

/// A control period of two arms with 14 joints: the pose of one hand seen from the other, the poses of both hands, and all limits.
#[divan::bench(sample_count = 1000, sample_size = 1)]
fn controller_step_of_two_arms(bencher: Bencher) {
    let text = include_str!("../../../examples/robots/two_pandas.urdf");
    let hands = ["left_link8", "right_link8"];
    let tips = hands.map(|link| UrdfTip { name: link, link, offset: IsometryMatrix3::identity() });
    let robot = RobotModel::from_urdf_tree(text, &UrdfTreeOptions { tips: &tips, ..UrdfTreeOptions::default() });
    let robot = Arc::new(robot.unwrap());
    let [left, right] = hands.map(|name| BodyFrame::from(robot.tip(name).unwrap()));
    let task = |name: &str, body: TaskBody, amplitude: f64| {
        let frame = TaskFrame { body: Some(body), ..TaskFrame::default() };
        let mut rows = ToolRows { frame, ..ToolRows::new(AxisSelection::new(&Axis::ALL).unwrap()) };
        let swing = vec![0.0, amplitude, amplitude, 0.0, 0.0, 0.0];
        rows.target_displacement = Some(Profile::sine(vec![0.0; 6], swing, 2.0, 0.0).unwrap());
        let law = Law::Position(PositionLaw::new(vec![8.0; 6]).unwrap());
        TaskConfig {
            name: name.to_owned(),
            rows: TaskRows::Tool(rows),
            law,
            scaled: false,
            streaming: Streaming::default(),
        }
    };
    let tasks = vec![
        task("hold", TaskBody { body: right, relative_to: Some(left) }, 0.0),
        task("left", TaskBody { body: left, relative_to: None }, 0.1),
        task("right", TaskBody { body: right, relative_to: None }, 0.1),
    ];
    let controller = Controller::new(ControllerConfig::new(robot, 1e-3, tasks)).unwrap();
    let (mut stepper, mut memory) = (stepper(controller).unwrap(), None);
    let home = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
    let mut measured = Measurement { joint_position: [home, home].concat(), ..at_rest() };
    bencher.bench_local(|| {
        let command = stepper.step(&mut memory, &measured).unwrap();
        let speeds = command.resolution.joint_velocity.iter();
        measured.joint_position.iter_mut().zip(speeds).for_each(|(q, speed)| *q += 1e-3 * speed);
        measured.time_s += 1e-3;
    });
}

/// A state of the Sawyer without wrench and targets.
fn at_rest() -> Measurement {
    Measurement {
        channels: Vec::new(),
        chunks: Vec::new(),
        wrenches: Vec::new(),
        obstacles: Vec::new(),
        time_s: 0.0,
        joint_position: POSTURE.to_vec(),
        joint_velocity: None,
        wrench: [0.0; 6],
        targets: Vec::new(),
    }
}

/// The robot's own limits at a state.
#[divan::bench]
fn limits(bencher: Bencher) {
    let robot = sawyer();
    let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
    let motion =
        JointMotion { position: &POSTURE, distance_to_rest: &[], last_command: &[0.1; 7], last_acceleration: &[] };
    bencher.bench_local(|| limits.at(black_box(&robot), black_box(motion), 1e-3).velocity_box.lower()[0]);
}
