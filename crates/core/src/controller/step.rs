//! One control period.

use nalgebra::Vector3;
use revprio_robot::kinematics::{Configuration, ConfigurationError, joint_limit_index};

use super::capability::Capability;
use super::next_memory::update_streams;
use super::progress::Observation;
use super::stepper::Workspace;
use super::target_streams::{self, ActiveStream, TaskStreams};
use super::task::ArmState;
use super::task_target::TaskTarget;
use super::{Command, ConfigError, ControllerConfig, Memory, MemoryError, StreamedTarget, TargetError, WrenchFrame};
use crate::law::Law;
use crate::limits::JointMotion;
use crate::resolution::ProblemError;
use crate::streaming::Quantity;
use crate::task::{TaskError, TaskStack};

/// The measured state of one period.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// t, time of the caller, s.
    pub time_s: f64,
    /// q, joint position, n, rad or m.
    pub joint_position: Vec<f64>,
    /// q̇, joint velocity, n; `None` if it is not measured: the last command replaces it, at the first step zero.
    pub joint_velocity: Option<Vec<f64>>,
    /// Force (N), then torque (N·m), at the tool point, in the controller's wrench convention and frame.
    pub wrench: [f64; 6],
    /// Streamed targets that arrived since the last measurement, at most one per task and quantity; usually none.
    pub targets: Vec<StreamedTarget>,
}

/// Why a measurement is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StepError {
    /// The joint positions do not fit the robot or are not finite.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
    /// The joint velocities do not fit the robot or are not finite.
    #[error("the joint velocity needs {expected} finite entries")]
    JointVelocity {
        /// Joints of the robot.
        expected: usize,
    },
    /// Time or wrench is NaN or infinite.
    #[error("time and wrench must be finite numbers")]
    NotFinite,
    /// A streamed target does not fit its task.
    #[error("{source}")]
    Target {
        /// Index of the target in the measurement, from 0.
        index: usize,
        /// What is wrong with it.
        source: TargetError,
    },
    /// The memory belongs to another controller or is damaged.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// A task velocity overflows.
    #[error("a task velocity is not a finite number; check gains and wrench: {0}")]
    Task(#[from] TaskError),
    /// The solver is not the one that the configuration names.
    #[error("the solver is not the one that the controller names; pass that one to `Stepper::with_solver`")]
    Solver,
    /// The parts of the problem do not fit each other. A checked configuration excludes this.
    #[error(transparent)]
    Problem(#[from] ProblemError),
}

/// A checked configuration. A [`Stepper`](super::Stepper) computes its commands.
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    config: ControllerConfig,
}

impl Controller {
    /// Checks the configuration.
    pub fn new(config: ControllerConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { config })
    }

    /// Returns the configuration.
    pub fn config(&self) -> &ControllerConfig {
        &self.config
    }

    /// Computes one control period in the workspace of this controller. On an error the memory stays unchanged.
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
        let late = memory.as_ref().and_then(|memory| memory.after_missed_periods(config, measurement));
        let known = late.as_ref().or(memory.as_ref());
        let Workspace {
            configuration,
            capability,
            limited,
            approach,
            problem,
            solver,
            command,
            zero_velocity,
            distance_to_rest,
            rest,
            look_ahead,
            streams,
            obstacles,
        } = workspace;
        let position = &measurement.joint_position;
        configuration.update(&config.robot, position)?;
        let qdot = match (&measurement.joint_velocity, known) {
            (Some(measured), _) => measured,
            (None, Some(memory)) => memory.last_command.as_slice(),
            (None, None) => zero_velocity,
        };
        let mut arm = self.arm_state(known, measurement, configuration, qdot);
        let mut initial = None;
        let previous = match known {
            Some(memory) => memory,
            None => initial.insert(self.initial_memory(&arm)),
        };
        target_streams::update(streams, previous, measurement, &arm, config);
        for (joint, distance) in distance_to_rest.iter_mut().enumerate() {
            *distance = previous.drive.distance_to_rest(config.drive, joint, config.period_s);
        }
        if let Some(rest) = rest {
            arm.rest = rest.update(&config.robot, position, distance_to_rest)?;
        }
        problem.tasks.overwrite_jacobians(|k, jacobian| {
            config.tasks[k].rows.write_jacobian(arm.rest, jacobian);
            config.weigh_jacobian(k, jacobian);
        })?;
        self.evaluate_laws(&mut command.targets, capability, &problem.tasks, streams, previous, &arm);
        self.update_null_space(problem, &mut command.targets, capability, streams, previous, &arm);
        self.write_bounds(&mut problem.tasks, &command.targets)?;
        let last_acceleration = match (&*approach, &previous.jerk) {
            (None, _) => &[],
            (Some(_), Some(jerk)) => jerk.acceleration.as_slice(),
            (Some(_), None) => zero_velocity.as_slice(),
        };
        let last_command = previous.last_command.as_slice();
        let motion = JointMotion { position, distance_to_rest, last_command, last_acceleration };
        config.limits.update(limited, &config.robot, motion, config.period_s);
        problem.limits.copy_from(&limited.velocity_box);
        if previous.in_transition {
            config.limit_transition(limited, &mut problem.limits, motion);
        }
        let ahead =
            look_ahead.as_mut().map(|look_ahead| look_ahead.update(config, arm.rest, last_command)).transpose()?;
        let braking = Some(capability.joint_braking());
        config.write_barriers(configuration, ahead, braking, &mut problem.inequalities);
        if let Some(approach) = approach {
            approach.resolve(config, (problem, &mut **solver), limited, motion, previous, &mut command.resolution)?;
        } else {
            solver.solve(problem, &previous.active_set, &mut command.resolution)?;
        }
        config.remove_weights(&mut command.resolution.tasks, &command.targets);
        command.report_bounds(&config.tasks);
        command.limit_conflicts.clone_from(&limited.conflicts);
        command.joint_limit_index = joint_limit_index(&config.robot, position);
        if let Some(kind) = config.kept_limits() {
            let velocity = command.resolution.joint_velocity.as_slice();
            command.hold.update(&config.robot, kind, motion, qdot, velocity, config.period_s);
        }
        let in_time = late.is_none();
        let memory = match late.or(initial) {
            Some(new) => Some(memory.insert(new)),
            None => memory.as_mut(),
        };
        if let Some(memory) = memory {
            memory.update_stalls(config, position, in_time, &mut command.stalled);
            self.update_memory(memory, command, approach.as_ref());
            self.remember_state(memory, measurement, &command.hold);
            let observed = Observation {
                config,
                tasks: &problem.tasks,
                problem,
                targets: &command.targets,
                resolution: &command.resolution,
                joint_position: position,
                time_s: measurement.time_s,
            };
            observed.update(&mut memory.progress, &mut command.stuck, obstacles);
            update_streams(&mut memory.target_streams, streams);
        }
        Ok(command)
    }

    /// Overwrites the bounds of the rows of the tasks: their targets, or the bounds of a task with bounds.
    fn write_bounds(&self, tasks: &mut TaskStack, targets: &[TaskTarget]) -> Result<(), TaskError> {
        let config = &self.config;
        tasks.overwrite(|k, _, lower, upper| {
            let velocity = &targets[k].velocity;
            let (least, greatest) =
                config.tasks[k].law.bounds().map_or((velocity, velocity), |b| (b.lower(), b.upper()));
            lower.copy_from_slice(&config.weighed(k, least.as_slice()));
            upper.copy_from_slice(&config.weighed(k, greatest.as_slice()));
        })
    }

    fn check(&self, measurement: &Measurement) -> Result<(), StepError> {
        let expected = self.config.robot.joint_count();
        let fits = |v: &Vec<f64>| v.len() == expected && v.iter().all(|entry| entry.is_finite());
        if !measurement.joint_velocity.as_ref().is_none_or(fits) {
            return Err(StepError::JointVelocity { expected });
        }
        let finite = measurement.time_s.is_finite() && measurement.wrench.iter().all(|entry| entry.is_finite());
        if !finite {
            return Err(StepError::NotFinite);
        }
        for (index, target) in measurement.targets.iter().enumerate() {
            target.check(&self.config, measurement.time_s).map_err(|source| StepError::Target { index, source })?;
        }
        Ok(())
    }

    fn arm_state<'a>(
        &'a self,
        memory: Option<&Memory>,
        measurement: &Measurement,
        configuration: &'a Configuration,
        qdot: &'a [f64],
    ) -> ArmState<'a> {
        let tool_pose = configuration.tool_pose();
        ArmState {
            time_s: measurement.time_s,
            robot: &self.config.robot,
            configuration,
            joint_velocity: qdot,
            twist: configuration.twist(qdot),
            wrench: self.wrench(measurement, configuration),
            initial_pose: memory.map_or(*tool_pose, |memory| memory.initial_pose),
            rest: configuration,
            time_to_rest: self.config.drive.time_to_rest(self.config.period_s),
        }
    }

    /// Returns F_e on the environment, base axes, at the tool point.
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

    /// Computes the target of each task by its law, bounded by what the joints can give. `tasks`: with the Jacobians of
    /// this period.
    fn evaluate_laws(
        &self,
        targets: &mut [TaskTarget],
        capability: &mut Capability,
        tasks: &TaskStack,
        streams: &[ActiveStream],
        previous: &Memory,
        arm: &ArmState,
    ) {
        let (config, period) = (&self.config, self.config.period_s);
        capability.start_period();
        let laws = config.tasks.iter().zip(&previous.task_velocities);
        for (k, (target, (task, integrator))) in targets.iter_mut().zip(laws).enumerate() {
            let (streams, integrator) = (TaskStreams::of(streams, k), integrator.as_slice());
            let state = match task.law {
                Law::Position(_) => task.state_at_rest(arm, streams),
                _ => task.state(arm, streams),
            };
            let velocity = task.law.velocity(&state, integrator, period);
            let mut velocity = capability.bounded(k, config, tasks, &state, velocity);
            let mut force = task.law.target_force(arm.time_s);
            if let Some(streamed) = streams.values() {
                force.iter_mut().zip(streamed.iter()).for_each(|(force, value)| *force = force.map(|_| *value));
            }
            let bound = |row| task.bound(Quantity::Force, row, arm.robot);
            streams.brake_forces(&mut velocity, &force, integrator, bound, period);
            target.velocity.copy_from_slice(&velocity);
            target.force.clear();
            target.force.extend(force);
            target.streamed = streams.report(arm.time_s);
        }
    }
}
