//! An arm that follows its commands, and what its control periods allocate.

use std::f64::consts::TAU;
use std::sync::Arc;

use allocation_counter::measure;
use revprio_core::controller::{
    Command, Controller, ControllerConfig, Limits, Measurement, Memory, Stepper, TaskConfig,
};
use revprio_core::law::{ForceLaw, Gains, Law, PositionLaw, Profile, VelocityBounds};
use revprio_core::limits::LimitKind;
use revprio_core::resolution::Path;
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_robot::kinematics::{Axis, AxisSelection};
use revprio_robot::{Joint, JointLimits, RobotModel, built_in};

pub const NOMINAL: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];
pub const PERIOD: f64 = 1e-3;
pub const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

pub fn sawyer() -> Arc<RobotModel> {
    Arc::clone(&built_in()[0])
}

/// Returns a named task.
pub fn task(name: &str, rows: TaskRows, law: Law) -> TaskConfig {
    TaskConfig { name: name.to_owned(), rows, law, scaled: false, streaming: Streaming::default() }
}

/// Returns rows of the tool along base axes.
pub fn tool(axes: &[Axis]) -> TaskRows {
    TaskRows::Tool(tool_rows(axes))
}

pub fn tool_rows(axes: &[Axis]) -> ToolRows {
    ToolRows::new(AxisSelection::new(axes).unwrap())
}

/// Returns a force law for one row of the tool.
pub fn force(target: Profile) -> Law {
    Law::Force(ForceLaw::new(Gains::new(1, &[15.0], &[150.0], &[0.0]).unwrap(), target).unwrap())
}

/// Returns a constant force, N.
pub fn constant_force(newtons: f64) -> Law {
    force(Profile::constant(vec![newtons]).unwrap())
}

/// Returns a position law with the gain 5/s.
pub fn position(rows: usize) -> Law {
    Law::Position(PositionLaw::new(vec![5.0; rows]).unwrap())
}

/// Returns two tasks: a push along x that oscillates with a period of 1 s, and hold the other axes.
pub fn push_and_hold() -> Vec<TaskConfig> {
    let push = force(Profile::sine(vec![0.0], vec![60.0], TAU, 0.3).unwrap());
    let others = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
    vec![task("push", tool(&[Axis::X]), push), task("hold", tool(&others), position(5))]
}

/// Returns a controller that pushes upwards and holds the other linear axes.
pub fn push_upwards(limits: Limits) -> ControllerConfig {
    let hold = task("hold", tool(&[Axis::X, Axis::Y]), position(2));
    config(limits, vec![task("push", tool(&[Axis::Z]), constant_force(100.0)), hold])
}

/// Returns the same controller below a task that bounds the speed upwards.
pub fn slow_upwards() -> ControllerConfig {
    let bounds = VelocityBounds::new(vec![f64::NEG_INFINITY], vec![0.01]).unwrap();
    let mut config = push_upwards(Limits::Robot(LimitKind::PositionVelocity));
    config.tasks.insert(0, task("slow", tool(&[Axis::Z]), Law::Bounds(bounds)));
    config
}

/// Returns the Sawyer arm with jerk limits.
pub fn with_jerk() -> Arc<RobotModel> {
    let soft = |joint: &Joint| {
        let limits = JointLimits { jerk: 0.2 * joint.limits.acceleration, ..joint.limits };
        Joint { limits, ..joint.clone() }
    };
    let robot = sawyer();
    Arc::new(RobotModel::new("soft", "", robot.joints().iter().map(soft).collect(), *robot.tool()).unwrap())
}

/// Returns a controller of the Sawyer arm.
pub fn config(limits: Limits, tasks: Vec<TaskConfig>) -> ControllerConfig {
    ControllerConfig { limits, ..ControllerConfig::new(sawyer(), PERIOD, tasks) }
}

/// An arm that follows its commands exactly, with its controller.
pub struct Arm {
    pub stepper: Stepper,
    pub memory: Option<Memory>,
    pub measured: Measurement,
}

/// Counts over a run of periods.
#[derive(Debug, Default, Clone, Copy)]
pub struct Counts {
    /// Allocations of all periods.
    pub allocations: u64,
    /// Allocations of the period that allocates most.
    pub most: u64,
    /// Bytes allocated less bytes freed.
    pub kept_bytes: i64,
    /// Periods solved by active sets.
    pub active_set: u32,
    /// Periods solved by Clarabel.
    pub qp: u32,
    /// Periods in which what a test is about was seen.
    pub seen: u32,
}

impl Arm {
    pub fn new(config: ControllerConfig) -> Self {
        Self::at(config, &NOMINAL)
    }

    pub fn at(config: ControllerConfig, joint_position: &[f64]) -> Self {
        let stepper = crate::solvers::stepper(Controller::new(config).unwrap());
        let measured = Measurement {
            channels: Vec::new(),
            chunks: Vec::new(),
            wrenches: Vec::new(),
            obstacles: Vec::new(),
            time_s: 0.0,
            joint_position: joint_position.to_vec(),
            joint_velocity: None,
            wrench: [0.0; 6],
            targets: Vec::new(),
        };
        Self { stepper, memory: None, measured }
    }

    /// Runs for 2000 periods, in which 2000 more have run before and the arm has started again.
    ///
    /// A stepper allocates memory when it is first needed, for example where the first limit is active. After this it has met
    /// all that the next 2000 periods show.
    pub fn warm_up(&mut self) {
        let first = self.measured.clone();
        self.run(4000, |_| true);
        (self.memory, self.measured) = (None, first);
        self.run(2000, |_| true);
    }

    /// Runs for some periods. `is_seen`: whether a command shows what the test is about.
    pub fn run(&mut self, periods: u32, is_seen: impl Fn(&Command) -> bool) -> Counts {
        let period = self.stepper.controller().config().period_s;
        let mut counts = Counts::default();
        for _ in 0..periods {
            let mut command = None;
            let counted = measure(|| command = Some(self.stepper.step(&mut self.memory, &self.measured).unwrap()));
            let command = command.unwrap();
            let path = command.resolution.solver.path;
            counts.seen += u32::from(is_seen(command));
            let speeds = command.resolution.joint_velocity.iter();
            self.measured.joint_position.iter_mut().zip(speeds).for_each(|(q, speed)| *q += period * speed);
            self.measured.time_s += period;
            counts.qp += u32::from(path == Path::Qp);
            counts.active_set += u32::from(path == Path::ActiveSet);
            counts.allocations += counted.count_total;
            counts.most = counts.most.max(counted.count_total);
            counts.kept_bytes += counted.bytes_current;
        }
        counts
    }
}

/// Returns the counts over 2000 periods after a warm-up.
pub fn after_warm_up(config: ControllerConfig, is_seen: impl Fn(&Command) -> bool) -> Counts {
    let mut arm = Arm::new(config);
    arm.warm_up();
    arm.run(2000, is_seen)
}

/// Asserts that no period allocates after the warm-up, and that what the test is about is seen in at least `seen` of the 2000
/// periods.
pub fn assert_allocates_nothing(what: &str, config: ControllerConfig, seen: u32, is_seen: impl Fn(&Command) -> bool) {
    let counts = after_warm_up(config, is_seen);
    assert!(counts.seen >= seen, "{what}: rarely seen: {counts:?}");
    assert_eq!((counts.allocations, counts.qp), (0, 0), "{what}: {counts:?}");
}
