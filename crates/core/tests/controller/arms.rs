//! Arms, tasks and controllers that the tests share, and an arm that follows its commands exactly.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Rotation3, Vector3};
use revprio_core::controller::{
    Command, Controller, ControllerConfig, Limits, Measurement, Memory, StepError, TaskConfig,
};
use revprio_core::law::{
    ContactLaw, ContactSettings, ForceLaw, Gains, HybridLaw, ImpedanceLaw, Law, PositionLaw, Profile,
};
use revprio_core::limits::{Drive, LimitKind, braking_deceleration};
use revprio_core::rows::{JointRows, JointTarget, TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_robot::kinematics::{Axis, AxisSelection, Configuration};
use revprio_robot::{Joint, JointKind, JointLimits, RobotModel, VelocityEnvelope, built_in};

/// T, s.
pub const PERIOD: f64 = 1e-3;
/// A posture of Sawyer far from limits and singularities.
pub const NOMINAL: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];

pub fn sawyer() -> Arc<RobotModel> {
    Arc::clone(&built_in()[0])
}

/// Returns the built-in arms whose joints all have a position range.
pub fn ranged_arms() -> Vec<Arc<RobotModel>> {
    let has_ranges = |robot: &&Arc<RobotModel>| robot.joints().iter().all(|joint| joint.limits.upper.is_finite());
    built_in().iter().filter(has_ranges).cloned().collect()
}

/// Returns the same robot with jerk limits; `rise`: the time in which the acceleration may rise from 0 to its limit, s.
pub fn with_jerk(robot: &RobotModel, rise: f64) -> RobotModel {
    let limited = |joint: &Joint| {
        let jerk = braking_deceleration(&joint.limits) / rise;
        Joint { limits: JointLimits { jerk, ..joint.limits }, ..joint.clone() }
    };
    let name = format!("{} with jerk limits", robot.name());
    RobotModel::new(name, "", robot.joints().iter().map(limited).collect(), *robot.tool()).unwrap()
}

/// Returns the same robot, of which every third joint states no acceleration limit.
pub fn with_free_joints(robot: &RobotModel) -> RobotModel {
    let freed = |(i, joint): (usize, &Joint)| {
        let acceleration = if i % 3 == 1 { f64::INFINITY } else { joint.limits.acceleration };
        Joint { limits: JointLimits { acceleration, ..joint.limits }, ..joint.clone() }
    };
    let name = format!("{} with free joints", robot.name());
    RobotModel::new(name, "", robot.joints().iter().enumerate().map(freed).collect(), *robot.tool()).unwrap()
}

/// Returns the same robot with velocity envelopes, which are softer and harder than the deceleration of the joints, with margins of 3 to
/// 21 mrad or mm.
pub fn with_envelopes(robot: &RobotModel) -> RobotModel {
    let enveloped = |(i, joint): (usize, &Joint)| {
        let deceleration = [0.25, 0.6, 1.0, 2.0][i % 4] * braking_deceleration(&joint.limits);
        let margin = 0.003 * (1 + i) as f64;
        let envelope = VelocityEnvelope { deceleration, offset: (2.0 * deceleration * margin).sqrt() };
        Joint { limits: JointLimits { envelope, ..joint.limits }, ..joint.clone() }
    };
    let name = format!("{} with envelopes", robot.name());
    RobotModel::new(name, "", robot.joints().iter().enumerate().map(enveloped).collect(), *robot.tool()).unwrap()
}

/// Returns how much further away the end that a joint moves to would have to be for its velocity envelope, rad or m; negative: inside.
pub fn missing_distance(limits: &JointLimits, q: f64, v: f64) -> f64 {
    let VelocityEnvelope { deceleration, offset } = limits.envelope;
    let distance = if v > 0.0 { limits.upper - q } else { q - limits.lower };
    if v == 0.0 { f64::NEG_INFINITY } else { (v.abs() + offset).powi(2) / (2.0 * deceleration) - distance }
}

/// Returns rows of all joints with a constant target, n.
pub fn joint_rows(target: &[f64]) -> TaskRows {
    let target_position = JointTarget::Position(constant(target));
    TaskRows::Joints(JointRows { joints: (0..target.len()).collect(), target: target_position })
}

/// Returns a robot of three prismatic joints along x, y, z. Its Jacobian is the identity at every posture.
pub fn gantry(limits: JointLimits) -> Arc<RobotModel> {
    let along = |axis: Vector3<f64>| Rotation3::rotation_between(&Vector3::z(), &axis).unwrap();
    let mut before = Rotation3::identity();
    let mut joints = Vec::new();
    for (name, axis) in [("x", Vector3::x()), ("y", Vector3::y()), ("z", Vector3::z())] {
        let placement = IsometryMatrix3::from_parts(Vector3::zeros().into(), before.inverse() * along(axis));
        before = along(axis);
        joints.push(Joint {
            name: name.to_owned(),
            kind: JointKind::Prismatic,
            placement,
            limits,
            published_range: None,
            denavit_hartenberg: None,
        });
    }
    Arc::new(RobotModel::new("gantry", "", joints, IsometryMatrix3::identity()).unwrap())
}

/// Returns the gains M_d and B_d of the paper on these axes, with this stiffness.
pub fn gains(axes: &[Axis], stiffness: f64) -> Gains {
    let by_kind = |linear: f64, angular: f64| {
        axes.iter().map(|axis| if axis.index() < 3 { linear } else { angular }).collect::<Vec<_>>()
    };
    let stiffness = vec![stiffness; axes.len()];
    Gains::new(axes.len(), &by_kind(15.0, 80.0), &by_kind(150.0, 280.0), &stiffness).unwrap()
}

pub fn constant(value: &[f64]) -> Profile {
    Profile::constant(value.to_vec()).unwrap()
}

pub fn force(axes: &[Axis], target: &[f64]) -> Law {
    Law::Force(ForceLaw::new(gains(axes, 0.0), constant(target)).unwrap())
}

pub fn contact(forces: &[f64], settings: ContactSettings) -> Law {
    Law::Contact(ContactLaw::new(constant(forces), vec![settings; forces.len()]).unwrap())
}

pub fn impedance(axes: &[Axis], stiffness: f64) -> Law {
    Law::Impedance(ImpedanceLaw::new(gains(axes, stiffness)))
}

/// Returns a position law with the same gain on every row.
pub fn position(rows: usize, gain: f64) -> Law {
    Law::Position(PositionLaw::new(vec![gain; rows]).unwrap())
}

pub fn hybrid(axes: &[Axis], stiffness: f64, target: &[f64], position_controlled: &[bool]) -> Law {
    Law::Hybrid(HybridLaw::new(gains(axes, stiffness), constant(target), position_controlled.to_vec()).unwrap())
}

pub fn task(axes: &[Axis], law: Law) -> TaskConfig {
    let name = axes.iter().map(|axis| format!("{axis:?}")).collect::<Vec<_>>().concat();
    TaskConfig { name, rows: TaskRows::Tool(tool_rows(axes)), law, scaled: false, streaming: Streaming::default() }
}

/// Returns rows along the base axes at the tool point, with the initial pose as target.
pub fn tool_rows(axes: &[Axis]) -> ToolRows {
    ToolRows::new(AxisSelection::new(axes).unwrap())
}

/// Returns the default configuration, but without limits and at rest in the null space, for an arm that follows its
/// commands at once.
pub fn config(robot: &Arc<RobotModel>, tasks: Vec<TaskConfig>) -> ControllerConfig {
    let limits = Limits::Robot(LimitKind::None);
    let defaults = ControllerConfig::new(Arc::clone(robot), PERIOD, tasks);
    ControllerConfig { limits, drive: Drive::IDEAL, null_space: None, leave_local_minima: false, ..defaults }
}

/// Computes one step with a new stepper.
pub fn step(
    controller: &Controller,
    memory: &mut Option<Memory>,
    measurement: &Measurement,
) -> Result<Command, StepError> {
    crate::solvers::stepper(controller.clone()).step(memory, measurement).cloned()
}

pub fn controller(config: ControllerConfig) -> Controller {
    Controller::new(config).unwrap()
}

pub fn measurement(joint_position: &[f64]) -> Measurement {
    Measurement {
        channels: Vec::new(),
        chunks: Vec::new(),
        wrenches: Vec::new(),
        obstacles: Vec::new(),
        time_s: 0.0,
        joint_position: joint_position.to_vec(),
        joint_velocity: None,
        wrench: [0.0; 6],
        targets: Vec::new(),
    }
}

/// An arm that follows its commands exactly, and the memory of its controller.
#[derive(Clone)]
pub struct Loop {
    pub q: Vec<f64>,
    pub memory: Option<Memory>,
    periods: u32,
}

impl Loop {
    pub fn at_rest(q: &[f64]) -> Self {
        Self { q: q.to_vec(), memory: None, periods: 0 }
    }

    pub fn measurement(&self, period: f64, wrench: [f64; 6]) -> Measurement {
        Measurement { time_s: f64::from(self.periods) * period, wrench, ..measurement(&self.q) }
    }

    /// Computes one period of the controller under a wrench on the environment, and moves the arm.
    pub fn step(&mut self, controller: &Controller, wrench: [f64; 6]) -> Command {
        let period = controller.config().period_s;
        let measurement = self.measurement(period, wrench);
        let command = step(controller, &mut self.memory, &measurement).unwrap();
        self.follow(&command, period);
        command
    }

    pub fn follow(&mut self, command: &Command, period: f64) {
        for (q, qdot) in self.q.iter_mut().zip(&command.resolution.joint_velocity) {
            *q += period * qdot;
        }
        self.periods += 1;
    }

    pub fn configuration(&self, robot: &RobotModel) -> Configuration {
        Configuration::new(robot, &self.q).unwrap()
    }

    /// Returns Ẋ = J q̇ of the last command.
    pub fn twist(&self, robot: &RobotModel) -> [f64; 6] {
        let zero = vec![0.0; self.q.len()];
        let qdot = self.memory.as_ref().map_or(zero.as_slice(), |memory| memory.last_command.as_slice());
        self.configuration(robot).twist(qdot)
    }
}

/// Reproducible random numbers (SplitMix64).
#[derive(Clone)]
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// 0 to 1, without 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn pick<T: Clone>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())].clone()
    }

    pub fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    pub fn below(&mut self, count: usize) -> usize {
        let scaled = (self.bits() >> 32) * count as u64;
        usize::try_from(scaled >> 32).unwrap()
    }
}
