//! What a controller is made of, checked once.

use std::sync::Arc;

use crate::kinematics::AxisSelection;
use crate::law::Law;
use crate::limits::{Barrier, LimitKind, LimitedBox, PlanePoint, VelocityBox, robot_box};
use crate::linalg::Damping;
use crate::resolution::{Method, Solver};
use crate::robot::RobotModel;
use nalgebra::IsometryMatrix3;

/// Whose wrench is measured; the laws speak of the wrench on the environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WrenchConvention {
    /// What the tool exerts on the environment: pressing on a wall at +x gives a positive x force.
    #[default]
    OnEnvironment,
    /// What the environment exerts on the tool: the opposite sign, as most wrist sensors give.
    OnTool,
}

impl WrenchConvention {
    /// The factor that makes a measured wrench one on the environment.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::OnEnvironment => 1.0,
            Self::OnTool => -1.0,
        }
    }
}

/// The pose that displacements ΔX are counted from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TargetPose {
    /// Where the tool was at the first step.
    Initial,
    /// A pose in the base frame, m.
    Fixed(IsometryMatrix3<f64>),
}

/// Which joint velocities are allowed.
#[derive(Debug, Clone, PartialEq)]
pub enum Limits {
    /// The robot's own limits at the measured state.
    Robot(LimitKind),
    /// A box that does not depend on the state, n, rad/s.
    Fixed(VelocityBox),
}

impl Limits {
    /// The allowed velocities at a state: `joint_position` and `last_velocity` (the last command), n; `period` in s.
    pub fn at(&self, robot: &RobotModel, joint_position: &[f64], last_velocity: &[f64], period: f64) -> LimitedBox {
        match self {
            Self::Robot(kind) => robot_box(robot, *kind, joint_position, last_velocity, period),
            Self::Fixed(velocity_box) => LimitedBox { velocity_box: velocity_box.clone(), conflicts: Vec::new() },
        }
    }
}

/// One task with its law.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskConfig {
    /// Name, for people and answers.
    pub name: String,
    /// The rows of the tool Jacobian that the task is about.
    pub axes: AxisSelection,
    /// How its velocity is made; as many rows as axes.
    pub law: Law,
    /// Where displacements are counted from.
    pub target_pose: TargetPose,
    /// Whether limits may slow the task down, but not bend it.
    pub scaled: bool,
}

/// Everything that stays the same from period to period.
#[derive(Debug, Clone, PartialEq)]
pub struct ControllerConfig {
    /// The arm.
    pub robot: Arc<RobotModel>,
    /// T, s.
    pub period_s: f64,
    /// How priorities are understood.
    pub method: Method,
    /// How each period's problem is solved.
    pub solver: Solver,
    /// Damping near singularities; `None` is exact.
    pub damping: Option<Damping>,
    /// Which joint velocities are allowed.
    pub limits: Limits,
    /// What joint velocities must obey beside the box.
    pub barriers: Vec<Barrier>,
    /// Whose wrench is measured.
    pub wrench_convention: WrenchConvention,
    /// The tasks, highest priority first.
    pub tasks: Vec<TaskConfig>,
}

/// Why a controller is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// T must be positive and finite.
    #[error("the period must be a positive number of seconds, not {0}")]
    Period(f64),
    /// Nothing to control.
    #[error("give at least one task")]
    NoTasks,
    /// Two tasks share a name.
    #[error("two tasks are named `{name}`; give each its own name")]
    DuplicateTask {
        /// Place of the second, from 0.
        task: usize,
        /// The repeated name.
        name: String,
    },
    /// The law is about another number of rows than the axes.
    #[error("the law has {law} rows for {axes} axes; give one value per axis")]
    Rows {
        /// Place of the task, from 0.
        task: usize,
        /// Rows of the law.
        law: usize,
        /// Axes of the task.
        axes: usize,
    },
    /// A barrier is about another number of joints, or about a joint that the robot does not have.
    #[error("inequality `{name}` does not fit a robot of {expected} joints")]
    Barrier {
        /// Place in the list, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// Joints of the robot.
        expected: usize,
    },
    /// The box is about another number of joints.
    #[error("limits for {given} joints, the robot has {expected}")]
    Limits {
        /// Joints of the robot.
        expected: usize,
        /// Joints of the box.
        given: usize,
    },
}

impl ControllerConfig {
    /// Checks that the parts fit together.
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        if !(self.period_s.is_finite() && self.period_s > 0.0) {
            return Err(ConfigError::Period(self.period_s));
        }
        if self.tasks.is_empty() {
            return Err(ConfigError::NoTasks);
        }
        if let Limits::Fixed(velocity_box) = &self.limits {
            let (expected, given) = (self.robot.joint_count(), velocity_box.joint_count());
            if expected != given {
                return Err(ConfigError::Limits { expected, given });
            }
        }
        let joints = self.robot.joint_count();
        let fits = |barrier: &Barrier| match barrier {
            Barrier::Fixed(inequality) => inequality.coefficients().len() == joints,
            Barrier::Plane(plane) => !matches!(plane.point(), PlanePoint::Joint(joint) if joint >= joints),
        };
        if let Some(index) = self.barriers.iter().position(|barrier| !fits(barrier)) {
            let name = self.barriers[index].name().to_owned();
            return Err(ConfigError::Barrier { index, name, expected: joints });
        }
        for (index, task) in self.tasks.iter().enumerate() {
            if self.tasks[..index].iter().any(|earlier| earlier.name == task.name) {
                return Err(ConfigError::DuplicateTask { task: index, name: task.name.clone() });
            }
            if task.law.rows() != task.axes.len() {
                return Err(ConfigError::Rows { task: index, law: task.law.rows(), axes: task.axes.len() });
            }
        }
        Ok(())
    }
}
