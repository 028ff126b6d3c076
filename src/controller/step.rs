//! One control period.

use nalgebra::IsometryMatrix3;

use super::{ConfigError, ControllerConfig, Memory, MemoryError, TargetPose, TaskConfig};
use crate::kinematics::{Configuration, ConfigurationError, orientation_error};
use crate::law::TaskState;
use crate::linalg::Vector;
use crate::resolution::{Problem, ProblemError, Resolution, Status, resolve};
use crate::task::{Task, TaskError, TaskStack};

/// Relative difference of achieved and requested velocity that counts as not following.
const FOLLOWED: f64 = 1e-9;

/// The measured state of one period.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// t, s, counted by the caller.
    pub time_s: f64,
    /// q, n, rad or m.
    pub joint_position: Vec<f64>,
    /// q̇, n; `None` where it is not measured: the last command stands for it.
    pub joint_velocity: Option<Vec<f64>>,
    /// Force (N), then torque (N·m), base axes, at the tool point, in the controller's wrench convention.
    pub wrench: [f64; 6],
}

/// What a task was after in this period.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskTarget {
    /// ẋ_k, m_k, m/s and rad/s.
    pub velocity: Vector,
    /// F_d per row, N and N·m; `None` where no force is followed.
    pub force: Vec<Option<f64>>,
}

/// The answer to one measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Command {
    /// Joint velocities and why they are what they are.
    pub resolution: Resolution,
    /// What each task was after, highest priority first.
    pub targets: Vec<TaskTarget>,
    /// Joints (index from 0) whose acceleration limit was overruled by position or velocity.
    pub limit_conflicts: Vec<usize>,
}

/// Why a measurement is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StepError {
    /// The joint positions do not describe a posture of the robot.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
    /// The joint velocities do not fit the robot.
    #[error("the joint velocity needs {expected} finite entries")]
    JointVelocity {
        /// Joints of the robot.
        expected: usize,
    },
    /// Time or wrench is NaN or infinite.
    #[error("time and wrench must be finite numbers")]
    NotFinite,
    /// The memory belongs to another controller.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The task velocities left the range of numbers.
    #[error("a task velocity is not a finite number; check gains and wrench: {0}")]
    Task(#[from] TaskError),
    /// The parts of the problem do not fit, which a checked configuration rules out.
    #[error(transparent)]
    Problem(#[from] ProblemError),
}

/// A checked configuration, ready to step.
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    config: ControllerConfig,
}

impl Controller {
    /// Checks the configuration once and for all.
    pub fn new(config: ControllerConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { config })
    }

    /// What the controller is made of.
    pub fn config(&self) -> &ControllerConfig {
        &self.config
    }

    /// Turns a measurement into a command; `memory` is the last step's, `None` at the first, and becomes this step's.
    ///
    /// On an error the memory stays as it was.
    pub fn step(&self, memory: &mut Option<Memory>, measurement: &Measurement) -> Result<Command, StepError> {
        self.check(measurement)?;
        if let Some(memory) = memory {
            memory.check(&self.config)?;
        }
        let configuration = Configuration::new(&self.config.robot, &measurement.joint_position)?;
        let before = self.recall(memory.as_ref(), measurement, &configuration);
        let targets = self.targets(&before, measurement, &configuration);
        let limited = self.config.limits.at(
            &self.config.robot,
            &measurement.joint_position,
            before.memory.last_command.as_slice(),
            self.config.period_s,
        );
        let problem = Problem {
            tasks: self.stack(&configuration, &targets)?,
            limits: limited.velocity_box,
            inequalities: self.config.barriers.iter().map(|barrier| barrier.at(&configuration)).collect(),
            method: self.config.method,
            solver: self.config.solver,
            damping: self.config.damping,
            null_space_velocity: None,
        };
        let resolution = resolve(&problem, &before.memory.active_set)?;
        *memory = Some(Memory {
            task_velocities: integrators(&targets, &resolution),
            initial_pose: before.memory.initial_pose,
            last_command: resolution.joint_velocity.clone(),
            active_set: resolution.active_set.clone(),
        });
        Ok(Command { resolution, targets, limit_conflicts: limited.conflicts })
    }

    fn check(&self, measurement: &Measurement) -> Result<(), StepError> {
        let expected = self.config.robot.joint_count();
        let fits = |v: &Vec<f64>| v.len() == expected && v.iter().all(|entry| entry.is_finite());
        if !measurement.joint_velocity.as_ref().is_none_or(fits) {
            return Err(StepError::JointVelocity { expected });
        }
        let finite = measurement.time_s.is_finite() && measurement.wrench.iter().all(|entry| entry.is_finite());
        if finite { Ok(()) } else { Err(StepError::NotFinite) }
    }

    /// The state before this step: remembered, or at the first step that of an arm moving as measured.
    fn recall(&self, memory: Option<&Memory>, measurement: &Measurement, configuration: &Configuration) -> Before {
        let moving = |qdot: &[f64]| configuration.twist(qdot);
        if let Some(memory) = memory {
            let qdot = measurement.joint_velocity.as_deref().unwrap_or(memory.last_command.as_slice());
            return Before { twist: moving(qdot), memory: memory.clone() };
        }
        let resting = vec![0.0; self.config.robot.joint_count()];
        let qdot = measurement.joint_velocity.as_deref().unwrap_or(&resting);
        let twist = moving(qdot);
        let memory = Memory {
            task_velocities: self.config.tasks.iter().map(|task| task.axes.entries_of(&twist)).collect(),
            initial_pose: *configuration.tool_pose(),
            last_command: Vector::from_row_slice(qdot),
            active_set: Vec::new(),
        };
        Before { twist, memory }
    }

    fn targets(&self, before: &Before, measurement: &Measurement, configuration: &Configuration) -> Vec<TaskTarget> {
        let wrench = measurement.wrench.map(|entry| self.config.wrench_convention.sign() * entry);
        let target = |(task, integrator): (&TaskConfig, &Vector)| {
            let state = TaskState {
                time_s: measurement.time_s,
                velocity: task.axes.entries_of(&before.twist),
                displacement: task.axes.entries_of(&displacement(task, before, configuration)),
                force: task.axes.entries_of(&wrench),
            };
            TaskTarget {
                velocity: task.law.velocity(&state, integrator, self.config.period_s),
                force: task.law.target_force(measurement.time_s),
            }
        };
        self.config.tasks.iter().zip(&before.memory.task_velocities).map(target).collect()
    }

    fn stack(&self, configuration: &Configuration, targets: &[TaskTarget]) -> Result<TaskStack, TaskError> {
        let task = |(task, target): (&TaskConfig, &TaskTarget)| Task {
            name: task.name.clone(),
            jacobian: task.axes.rows_of(configuration.jacobian()),
            velocity: target.velocity.clone(),
            scaled: task.scaled,
        };
        TaskStack::new(self.config.tasks.iter().zip(targets).map(task).collect())
    }
}

/// What is known before a command is chosen.
struct Before {
    /// Ẋ = J q̇, measured, base axes.
    twist: [f64; 6],
    memory: Memory,
}

/// X − X_d: position difference (m), then rotation vector (rad), base axes.
fn displacement(task: &TaskConfig, before: &Before, configuration: &Configuration) -> [f64; 6] {
    let desired: &IsometryMatrix3<f64> = match &task.target_pose {
        TargetPose::Initial => &before.memory.initial_pose,
        TargetPose::Fixed(pose) => pose,
    };
    let actual = configuration.tool_pose();
    let linear = actual.translation.vector - desired.translation.vector;
    let angular = orientation_error(&actual.rotation, &desired.rotation);
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// ẋ of the integrators after the command, with anti-windup: where a limit or a conflict kept an axis from following,
/// its integrator continues from the achieved velocity, so that a release does not jump.
///
/// Departs: damping alone is no such case. Resetting there would add a second damping to the classical control, whose
/// F_x RMSE on `force_tracking_singular` would be 2.4 N instead of 1.4 N. The price: a lower task that damping holds off
/// for long asks for more and more (9 m/s after 5 s of `stiff_wall_singular`), and takes it, up to the limits, when the
/// posture recovers.
fn integrators(targets: &[TaskTarget], resolution: &Resolution) -> Vec<Vector> {
    let held_back = !resolution.active_limits.is_empty()
        || !resolution.active_inequalities.is_empty()
        || resolution.singularity.algorithmic
        || resolution.solver.status != Status::Optimal;
    let after = |(target, outcome): (&TaskTarget, &crate::resolution::TaskOutcome)| {
        let follow = |wanted: f64, achieved: f64| {
            let followed = (achieved - wanted).abs() <= FOLLOWED * wanted.abs().max(1.0);
            if held_back && !followed { achieved } else { wanted }
        };
        target.velocity.zip_map(&outcome.achieved, follow)
    };
    targets.iter().zip(&resolution.tasks).map(after).collect()
}
