//! After the first few periods a control period allocates nothing, unless Clarabel solves it, which is rare with
//! `auto`.

use std::sync::Arc;

use allocation_counter::measure;
use nalgebra::{UnitQuaternion, Vector3};
use revprio_core::controller::{
    Controller, ControllerConfig, JointRows, JointTarget, Limits, Measurement, Memory, NullSpaceMotion, Stepper,
    StreamedTarget, StreamedValue, TaskConfig, TaskRows, ToolRows,
};
use revprio_core::law::{ForceLaw, Gains, Law, PositionLaw, Profile};
use revprio_core::limits::{LimitKind, VelocityBox};
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{Method, Path, Problem, Resolution, Resolver, Solver, resolve};
use revprio_core::streaming::{Quantity, Streaming};
use revprio_core::task::{Task, TaskStack};
use revprio_robot::kinematics::{Axis, AxisSelection};
use revprio_robot::{Joint, JointLimits, RobotModel, built_in};

const NOMINAL: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];
const PERIOD: f64 = 1e-3;

fn sawyer() -> Arc<RobotModel> {
    Arc::clone(&built_in()[0])
}

/// Returns two tasks: an oscillating push along x, and hold the other axes.
fn tasks() -> Vec<TaskConfig> {
    let rows = |axes: &[Axis]| TaskRows::Tool(ToolRows::new(AxisSelection::new(axes).unwrap()));
    let gains = Gains::new(1, &[15.0], &[150.0], &[0.0]).unwrap();
    let push = Profile::sine(vec![0.0], vec![60.0], 6.0, 0.3).unwrap();
    let push = Law::Force(ForceLaw::new(gains, push).unwrap());
    let hold = Law::Position(PositionLaw::new(vec![5.0; 5]).unwrap());
    let others = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
    [("push", rows(&[Axis::X]), push), ("hold", rows(&others), hold)]
        .map(|(name, rows, law)| TaskConfig {
            name: name.to_owned(),
            rows,
            law,
            scaled: false,
            streaming: Streaming::default(),
        })
        .into()
}

fn config(solver: Solver, limits: Limits) -> ControllerConfig {
    ControllerConfig { solver, limits, ..ControllerConfig::new(sawyer(), PERIOD, tasks()) }
}

/// An arm that follows its commands exactly.
struct Loop {
    stepper: Stepper,
    memory: Option<Memory>,
    measured: Measurement,
}

/// Counts over a run of periods.
#[derive(Debug, Default)]
struct Tally {
    /// Allocations in periods without Clarabel.
    allocations: u64,
    /// Periods solved by active sets.
    active_set: u32,
    /// Periods solved by Clarabel.
    qp: u32,
}

impl Loop {
    fn new(config: ControllerConfig) -> Self {
        let controller = Controller::new(config).unwrap();
        let stepper = Stepper::new(controller).unwrap();
        let measured = Measurement {
            time_s: 0.0,
            joint_position: NOMINAL.to_vec(),
            joint_velocity: None,
            wrench: [0.0; 6],
            targets: Vec::new(),
        };
        Self { stepper, memory: None, measured }
    }

    fn run(&mut self, periods: u32) -> Tally {
        let mut tally = Tally::default();
        for _ in 0..periods {
            let mut path = Path::default();
            let counted = measure(|| {
                let command = self.stepper.step(&mut self.memory, &self.measured).unwrap();
                path = command.resolution.solver.path;
                let speeds = command.resolution.joint_velocity.iter();
                self.measured.joint_position.iter_mut().zip(speeds).for_each(|(q, speed)| *q += PERIOD * speed);
            });
            self.measured.time_s += PERIOD;
            tally.qp += u32::from(path == Path::Qp);
            tally.active_set += u32::from(path == Path::ActiveSet);
            if path != Path::Qp {
                tally.allocations += counted.count_total;
            }
        }
        tally
    }
}

/// Counts over 2000 periods, after 2000 periods of warm-up.
fn after_warm_up(config: ControllerConfig) -> Tally {
    let mut arm = Loop::new(config);
    arm.run(2000);
    arm.run(2000)
}

#[test]
fn the_first_step_allocates_and_is_counted() {
    let mut arm = Loop::new(config(Solver::Auto, Limits::Robot(LimitKind::Velocity)));
    let counted = measure(|| drop(arm.stepper.step(&mut arm.memory, &arm.measured).cloned()));
    assert!(counted.count_total > 10);
}

#[test]
fn every_method_allocates_nothing() {
    for method in [
        Method::ReversePriority,
        Method::StrictReversePriority,
        Method::TaskPriority,
        Method::SingularityRobust,
        Method::DampedLeastSquares,
        Method::Pseudoinverse,
    ] {
        let config = config(Solver::Auto, Limits::Robot(LimitKind::PositionVelocity));
        let tally = after_warm_up(ControllerConfig { method, ..config });
        assert_eq!((tally.allocations, tally.qp), (0, 0), "{method:?}");
    }
}

/// The memory of the answer has its size from a first answer, which starts from the right working set.
#[test]
fn a_search_that_meets_more_limits_than_before_allocates_nothing() {
    let task = Task::new("all", Matrix::from_diagonal_element(7, 7, 1.0), Vector::from_element(7, 1.0));
    let mut problem = Problem::new(TaskStack::new(vec![task]).unwrap());
    let mut limit = [10.0; 7];
    limit[0] = 0.5;
    let bounds = |limit: [f64; 7]| VelocityBox::new(&limit.map(|limit| -limit), &limit).unwrap();
    let (mut resolver, mut answer) = (Resolver::default(), Resolution::default());
    problem.limits = bounds(limit);
    resolver.resolve(&problem, &[], &mut answer).unwrap();
    problem.limits = bounds([0.5; 7]);
    let guess = resolve(&problem, &[]).unwrap().active_set;
    resolver.resolve(&problem, &guess, &mut answer).unwrap();
    let counted = measure(|| resolver.resolve(&problem, &[], &mut answer).unwrap());
    assert_eq!((counted.count_total, answer.active_limits.len(), answer.solver.working_sets), (0, 7, 2));
}

#[test]
fn streamed_targets_allocate_nothing() {
    let mut arm = Loop::new(config(Solver::Auto, Limits::Robot(LimitKind::Velocity)));
    let pose = StreamedValue::Pose {
        position: Some(Vector3::new(0.6, 0.1, 0.4)),
        orientation: Some(UnitQuaternion::identity()),
    };
    let hold = arm.stepper.controller().config().tasks.iter().position(|task| task.accepts(Quantity::Pose)).unwrap();
    let mut run = |targets: u32| {
        let mut allocations = 0;
        for _ in 0..targets {
            arm.measured.targets =
                vec![StreamedTarget { task: hold, time_s: arm.measured.time_s, value: pose.clone(), velocity: None }];
            // A target arrives, then periods without one.
            allocations += arm.run(1).allocations;
            arm.measured.targets.clear();
            allocations += arm.run(300).allocations;
        }
        allocations
    };
    run(4);
    assert_eq!(run(4), 0);
}

#[test]
fn auto_inside_the_limits_allocates_nothing() {
    let tally = after_warm_up(config(Solver::Auto, Limits::Robot(LimitKind::Velocity)));
    assert_eq!((tally.allocations, tally.qp, tally.active_set), (0, 0, 0));
}

#[test]
fn auto_with_active_limits_allocates_nothing() {
    let slow = VelocityBox::new(&[-0.1; 7], &[0.1; 7]).unwrap();
    for method in [Method::ReversePriority, Method::StrictReversePriority] {
        let config = ControllerConfig { method, ..config(Solver::Auto, Limits::Fixed(slow.clone())) };
        let tally = after_warm_up(config);
        assert!(tally.active_set > 200, "limits are rarely active: {tally:?}");
        assert_eq!((tally.allocations, tally.qp), (0, 0), "{method:?}: {tally:?}");
    }
}

/// Periods are solved once or twice.
#[test]
fn jerk_limits_allocate_nothing() {
    let soft = |joint: &Joint| {
        let limits = JointLimits { jerk: 0.2 * joint.limits.acceleration, ..joint.limits };
        Joint { limits, ..joint.clone() }
    };
    let robot = sawyer();
    let soft = RobotModel::new("soft", "", robot.joints().iter().map(soft).collect(), *robot.tool()).unwrap();
    let config = config(Solver::Auto, Limits::Robot(LimitKind::PositionVelocityAcceleration));
    let mut arm = Loop::new(ControllerConfig { robot: Arc::new(soft), ..config });
    arm.run(2000);
    let tally = arm.run(2000);
    assert!(arm.memory.as_ref().is_some_and(|memory| memory.jerk.is_some()));
    assert!(tally.active_set > 200, "limits are rarely active: {tally:?}");
    assert_eq!((tally.allocations, tally.qp), (0, 0), "{tally:?}");
}

#[test]
fn joints_and_null_space_motions_allocate_nothing() {
    let posture = JointRows { joints: vec![1, 4], target: JointTarget::MidRange };
    let law = Law::Position(PositionLaw::new(vec![1.0; 2]).unwrap());
    let centre = TaskConfig {
        name: "centre".to_owned(),
        rows: TaskRows::Joints(posture),
        law,
        scaled: false,
        streaming: Streaming::default(),
    };
    let config = config(Solver::Auto, Limits::Robot(LimitKind::PositionVelocityAcceleration));
    let tasks = config.tasks.iter().take(1).cloned().chain([centre]).collect();
    let null_space = Some(NullSpaceMotion::JointLimits { gain: 0.5 });
    assert_eq!(after_warm_up(ControllerConfig { tasks, null_space, ..config }).allocations, 0);
}
