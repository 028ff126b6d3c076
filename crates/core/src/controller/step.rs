//! One control period.

use nalgebra::Vector3;
use revprio_robot::kinematics::{Configuration, ConfigurationError, joint_limit_index};

use super::task::Sensed;
use super::workspace::Workspace;
use super::{ConfigError, ControllerConfig, Memory, MemoryError, WrenchFrame};
use crate::linalg::Vector;
use crate::resolution::{ProblemError, Resolution, Status};
use crate::task::TaskError;

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
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TaskTarget {
    /// ẋ_k, m_k, m/s and rad/s.
    pub velocity: Vector,
    /// F_d per row, N and N·m; `None` where no force is followed.
    pub force: Vec<Option<f64>>,
}

/// The answer to one measurement.
#[derive(Debug, Clone, PartialEq, Default)]
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

/// A checked configuration. A [`Stepper`](super::Stepper) steps it.
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

    /// Solves one control period in a workspace of this controller.
    ///
    /// On an error the memory stays as it was.
    pub(super) fn step<'a>(
        &self,
        workspace: &'a mut Workspace,
        memory: &mut Option<Memory>,
        measurement: &Measurement,
    ) -> Result<&'a Command, StepError> {
        self.check(measurement)?;
        if let Some(memory) = memory {
            memory.check(&self.config)?;
        }
        let config = &self.config;
        let Workspace { configuration, limited, problem, resolver, command, rest } = workspace;
        let position = &measurement.joint_position;
        configuration.update(&config.robot, position)?;
        let qdot = match (&measurement.joint_velocity, &*memory) {
            (Some(measured), _) => measured,
            (None, Some(memory)) => memory.last_command.as_slice(),
            (None, None) => rest,
        };
        let sensed = self.sense(memory.as_ref(), measurement, configuration, qdot);
        let mut first = None;
        let before = match &*memory {
            Some(memory) => memory,
            None => first.insert(self.first_memory(&sensed)),
        };
        self.aim(&mut command.targets, before, &sensed);
        problem.tasks.overwrite(|k, jacobian, velocity| {
            config.tasks[k].rows.write_jacobian(configuration, jacobian);
            velocity.copy_from(&command.targets[k].velocity);
        })?;
        config.limits.update(limited, &config.robot, position, before.last_command.as_slice(), config.period_s);
        problem.limits.copy_from(&limited.velocity_box);
        problem.inequalities.clear();
        problem.inequalities.extend(config.barriers.iter().map(|barrier| barrier.at(configuration)));
        if let (Some(motion), Some(velocity)) = (&config.null_space, &mut problem.null_space_velocity) {
            motion.write(&config.robot, position, velocity);
        }
        resolver.resolve(problem, &before.active_set, &mut command.resolution)?;
        command.limit_conflicts.clone_from(&limited.conflicts);
        command.joint_limit_index = joint_limit_index(&config.robot, position);
        let memory = match first {
            Some(first) => Some(memory.insert(first)),
            None => memory.as_mut(),
        };
        if let Some(memory) = memory {
            self.remember(memory, command);
        }
        Ok(command)
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
            task_velocities: self.config.tasks.iter().map(|task| task.rows.velocity(sensed).to_vector()).collect(),
            initial_pose: sensed.initial_pose,
            last_command: Vector::from_row_slice(sensed.joint_velocity),
            active_set: Vec::new(),
        }
    }

    /// Asks each law for its target.
    fn aim(&self, targets: &mut [TaskTarget], before: &Memory, sensed: &Sensed) {
        for (target, (task, integrator)) in
            targets.iter_mut().zip(self.config.tasks.iter().zip(&before.task_velocities))
        {
            let velocity = task.law.velocity(&task.rows.state(sensed), integrator.as_slice(), self.config.period_s);
            target.velocity.copy_from_slice(&velocity);
            target.force.clear();
            target.force.extend(task.law.target_force(sensed.time_s));
        }
    }

    /// Makes the memory one of this command, with anti-windup: where a limit or a conflict kept an axis from following, its
    /// integrator continues from the achieved velocity, so that a release does not jump.
    ///
    /// Departs: damping alone is no such case. Resetting there would add a second damping to the classical control, whose
    /// F_x RMSE on `force_tracking_singular` would be 2.4 N instead of 1.4 N. The price: a lower task that damping holds off
    /// for long asks for more and more (9 m/s after 5 s of `stiff_wall_singular`), and takes it, up to the limits, when the
    /// posture recovers.
    ///
    /// A law without an integrator leaves what was achieved.
    fn remember(&self, memory: &mut Memory, Command { resolution, targets, .. }: &Command) {
        let held_back = !resolution.active_limits.is_empty()
            || !resolution.active_inequalities.is_empty()
            || resolution.singularity.algorithmic
            || resolution.solver.status != Status::Optimal;
        for (k, velocity) in memory.task_velocities.iter_mut().enumerate() {
            let (wanted, achieved) = (&targets[k].velocity, &resolution.tasks[k].achieved);
            for (row, velocity) in velocity.iter_mut().enumerate() {
                let followed = (achieved[row] - wanted[row]).abs() <= FOLLOWED * wanted[row].abs().max(1.0);
                let continues = self.config.tasks[k].law.integrates() && (followed || !held_back);
                *velocity = if continues { wanted[row] } else { achieved[row] };
            }
        }
        memory.last_command.copy_from(&resolution.joint_velocity);
        memory.active_set.clone_from(&resolution.active_set);
    }
}
