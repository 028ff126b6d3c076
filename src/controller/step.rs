//! One control period.

use nalgebra::Vector3;

use super::task::Sensed;
use super::{ConfigError, ControllerConfig, Memory, MemoryError, TaskConfig, WrenchFrame};
use crate::kinematics::{Configuration, ConfigurationError, joint_limit_index};
use crate::linalg::Vector;
use crate::resolution::{Problem, ProblemError, Resolution, Status, TaskOutcome, resolve};
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
    /// Force (N), then torque (N·m), at the tool point, in the controller's wrench convention and frame.
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
    /// H, how near the joints are to the ends of their ranges. Paper: Eq. (8).
    pub joint_limit_index: f64,
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
        let (robot, position) = (&self.config.robot, &measurement.joint_position);
        let configuration = Configuration::new(robot, position)?;
        let qdot = self.joint_velocity(memory.as_ref(), measurement);
        let sensed = self.sense(memory.as_ref(), measurement, &configuration, &qdot);
        let before = memory.clone().unwrap_or_else(|| self.first_memory(&sensed));
        let targets = self.targets(&before, &sensed);
        let limited = self.config.limits.at(robot, position, before.last_command.as_slice(), self.config.period_s);
        let problem = Problem {
            tasks: self.stack(&configuration, &targets)?,
            limits: limited.velocity_box,
            inequalities: self.config.barriers.iter().map(|barrier| barrier.at(&configuration)).collect(),
            method: self.config.method,
            solver: self.config.solver,
            damping: self.config.damping,
            null_space_velocity: self.config.null_space.as_ref().map(|motion| motion.velocity(robot, position)),
        };
        let resolution = resolve(&problem, &before.active_set)?;
        *memory = Some(Memory {
            task_velocities: self.integrators(&targets, &resolution),
            initial_pose: before.initial_pose,
            last_command: resolution.joint_velocity.clone(),
            active_set: resolution.active_set.clone(),
        });
        let joint_limit_index = joint_limit_index(robot, position);
        Ok(Command { resolution, targets, limit_conflicts: limited.conflicts, joint_limit_index })
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

    /// q̇, n: measured, else the last command, else rest.
    fn joint_velocity(&self, memory: Option<&Memory>, measurement: &Measurement) -> Vec<f64> {
        match (&measurement.joint_velocity, memory) {
            (Some(measured), _) => measured.clone(),
            (None, Some(memory)) => memory.last_command.as_slice().to_vec(),
            (None, None) => vec![0.0; self.config.robot.joint_count()],
        }
    }

    fn sense<'a>(
        &'a self,
        memory: Option<&Memory>,
        measurement: &Measurement,
        configuration: &'a Configuration,
        qdot: &'a [f64],
    ) -> Sensed<'a> {
        let tool_pose = configuration.tool_pose();
        Sensed {
            time_s: measurement.time_s,
            robot: &self.config.robot,
            configuration,
            joint_velocity: qdot,
            twist: configuration.twist(qdot),
            wrench: self.wrench(measurement, configuration),
            initial_pose: memory.map_or(*tool_pose, |memory| memory.initial_pose),
        }
    }

    /// F_e on the environment, base axes, at the tool point.
    fn wrench(&self, measurement: &Measurement, configuration: &Configuration) -> [f64; 6] {
        let [fx, fy, fz, tx, ty, tz] = measurement.wrench.map(|entry| self.config.wrench_convention.sign() * entry);
        match self.config.wrench_frame {
            WrenchFrame::Base => [fx, fy, fz, tx, ty, tz],
            WrenchFrame::Tool => {
                let rotation = &configuration.tool_pose().rotation;
                let (force, torque) = (rotation * Vector3::new(fx, fy, fz), rotation * Vector3::new(tx, ty, tz));
                [force.x, force.y, force.z, torque.x, torque.y, torque.z]
            }
        }
    }

    /// What stands for a memory at the first step: an arm moving as measured.
    fn first_memory(&self, sensed: &Sensed) -> Memory {
        Memory {
            task_velocities: self.config.tasks.iter().map(|task| task.rows.velocity(sensed)).collect(),
            initial_pose: sensed.initial_pose,
            last_command: Vector::from_row_slice(sensed.joint_velocity),
            active_set: Vec::new(),
        }
    }

    fn targets(&self, before: &Memory, sensed: &Sensed) -> Vec<TaskTarget> {
        let target = |(task, integrator): (&TaskConfig, &Vector)| TaskTarget {
            velocity: task.law.velocity(&task.rows.state(sensed), integrator, self.config.period_s),
            force: task.law.target_force(sensed.time_s),
        };
        self.config.tasks.iter().zip(&before.task_velocities).map(target).collect()
    }

    fn stack(&self, configuration: &Configuration, targets: &[TaskTarget]) -> Result<TaskStack, TaskError> {
        let task = |(task, target): (&TaskConfig, &TaskTarget)| Task {
            name: task.name.clone(),
            jacobian: task.rows.jacobian(configuration),
            velocity: target.velocity.clone(),
            scaled: task.scaled,
        };
        TaskStack::new(self.config.tasks.iter().zip(targets).map(task).collect())
    }

    /// ẋ of the integrators after the command, with anti-windup: where a limit or a conflict kept an axis from following,
    /// its integrator continues from the achieved velocity, so that a release does not jump.
    ///
    /// Departs: damping alone is no such case. Resetting there would add a second damping to the classical control, whose
    /// F_x RMSE on `force_tracking_singular` would be 2.4 N instead of 1.4 N. The price: a lower task that damping holds off
    /// for long asks for more and more (9 m/s after 5 s of `stiff_wall_singular`), and takes it, up to the limits, when the
    /// posture recovers.
    ///
    /// A law without an integrator leaves what was achieved.
    fn integrators(&self, targets: &[TaskTarget], resolution: &Resolution) -> Vec<Vector> {
        let held_back = !resolution.active_limits.is_empty()
            || !resolution.active_inequalities.is_empty()
            || resolution.singularity.algorithmic
            || resolution.solver.status != Status::Optimal;
        let after = |((task, target), outcome): ((&TaskConfig, &TaskTarget), &TaskOutcome)| {
            if !task.law.integrates() {
                return outcome.achieved.clone();
            }
            let follow = |wanted: f64, achieved: f64| {
                let followed = (achieved - wanted).abs() <= FOLLOWED * wanted.abs().max(1.0);
                if held_back && !followed { achieved } else { wanted }
            };
            target.velocity.zip_map(&outcome.achieved, follow)
        };
        self.config.tasks.iter().zip(targets).zip(&resolution.tasks).map(after).collect()
    }
}
