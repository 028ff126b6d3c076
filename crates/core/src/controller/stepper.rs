//! A controller with its workspace: the values that each step overwrites.

use std::sync::Arc;

use revprio_robot::kinematics::Configuration;

use super::capability::Capability;
use super::jerk::Approach;
use super::look_ahead::{ArmAtRest, LookAhead};
use super::progress::ObstacleScratch;
use super::target_streams::ActiveStream;
use super::task_target::TaskTarget;
use super::{Command, Controller, ControllerConfig, Measurement, Memory, StepError, TaskConfig};
use crate::limits::{JointMotion, LimitedBox};
use crate::linalg::{Matrix, Vector};
use crate::resolution::{Problem, Resolver, Solve, Solver};
use crate::task::{Task, TaskStack};

/// A controller with the workspace that its steps overwrite.
///
/// Memory is allocated when it is first needed, for example in the first step, and where the first limit is active or the
/// first task is damped. Once a stepper has met what its periods contain, a step allocates nothing. Exceptions, with the most
/// allocations of a period that `tests/allocations/exceptions.rs` allows:
///
/// | period | allocations |
/// |---|---|
/// | a state that comes late | 22 |
/// | a scaled task that limits slow down | 28 |
/// | bounds of a task, or inequalities, that cannot be kept together | 30; jerk limits before a plane: 54 |
/// | a task of 14 rows; up to 12 have a place without allocation | 19 |
pub struct Stepper {
    controller: Arc<Controller>,
    workspace: Workspace,
}

impl Stepper {
    /// Allocates the workspace of a controller with the solver `auto`.
    pub fn new(controller: impl Into<Arc<Controller>>) -> Result<Self, StepError> {
        let controller = controller.into();
        if controller.config().solver != Solver::Auto {
            return Err(StepError::Solver);
        }
        Self::with_solver(controller, Box::<Resolver>::default())
    }

    /// Allocates the workspace of a controller with the solver that its configuration names.
    pub fn with_solver(controller: impl Into<Arc<Controller>>, solver: Box<dyn Solve>) -> Result<Self, StepError> {
        let controller = controller.into();
        if solver.keeps_limits() != (controller.config().solver != Solver::ClosedForm) {
            return Err(StepError::Solver);
        }
        let workspace = Workspace::new(controller.config(), solver)?;
        Ok(Self { controller, workspace })
    }

    /// Returns the controller. It never changes, so other threads may share it.
    pub fn controller(&self) -> &Arc<Controller> {
        &self.controller
    }

    /// Computes the command for a measurement.
    ///
    /// `memory` is the memory of the previous step, `None` at the first step. The step replaces it by its own memory.
    /// On an error it stays unchanged.
    ///
    /// The same controller, memory and measurement give the same command to the last bit, whatever the stepper computed
    /// before.
    pub fn step(&mut self, memory: &mut Option<Memory>, measurement: &Measurement) -> Result<&Command, StepError> {
        self.controller.step(&mut self.workspace, memory, measurement)
    }

    /// Exchanges the command of the last step with `other`, whose content the next step overwrites.
    ///
    /// A caller that keeps commands can so return those that it does not need any more: a clone would allocate. `other`
    /// becomes a clone if it is not a command of this controller.
    pub fn exchange_command(&mut self, other: &mut Command) {
        let command = &mut self.workspace.command;
        if other.has_size_of(command) {
            std::mem::swap(command, other);
        } else {
            other.clone_from(command);
        }
    }
}

/// The values of one control period. They are allocated once and overwritten in each period. No result depends on their
/// previous content.
pub(super) struct Workspace {
    pub(super) configuration: Configuration,
    pub(super) capability: Capability,
    pub(super) limited: LimitedBox,
    /// For joints with a jerk limit.
    pub(super) approach: Option<Approach>,
    pub(super) problem: Problem,
    pub(super) solver: Box<dyn Solve>,
    pub(super) command: Command,
    /// q̇ of an arm at rest, n.
    pub(super) zero_velocity: Vec<f64>,
    /// p − q, n.
    pub(super) distance_to_rest: Vec<f64>,
    /// For positions behind a drive.
    pub(super) rest: Option<ArmAtRest>,
    /// For planes.
    pub(super) look_ahead: Option<LookAhead>,
    /// The streams of targets of this period.
    pub(super) streams: Vec<ActiveStream>,
    /// For tasks that are stuck.
    pub(super) obstacles: ObstacleScratch,
}

impl Workspace {
    /// Allocates the values for a checked configuration.
    fn new(config: &ControllerConfig, solver: Box<dyn Solve>) -> Result<Self, StepError> {
        let n = config.robot.joint_count();
        let zeros = vec![0.0; n];
        let at_rest =
            JointMotion { position: &zeros, distance_to_rest: &[], last_command: &zeros, last_acceleration: &[] };
        let limited = config.limits.at(&config.robot, at_rest, config.period_s);
        let task = |task: &TaskConfig| {
            let (name, jacobian) = (task.name.clone(), Matrix::zeros(task.rows.len(), n));
            let empty = match task.law.bounds() {
                Some(bounds) => Task::between(name, jacobian, bounds.lower().clone(), bounds.upper().clone()),
                None => Task::new(name, jacobian, Vector::zeros(task.rows.len())),
            };
            Task { scaled: task.scaled, ..empty }
        };
        let problem = Problem {
            tasks: TaskStack::new(config.tasks.iter().map(task).collect())?,
            limits: limited.velocity_box.clone(),
            inequalities: config.barriers.iter().map(|barrier| barrier.before_first_posture(n)).collect(),
            method: config.method,
            damping: config.fading_damping(),
            null_space_velocity: config.moves_null_space().then(|| Vector::zeros(n)),
            wants_certificate: false,
        };
        let target = |task: &Task| TaskTarget { velocity: Vector::zeros(task.lower.len()), ..TaskTarget::default() };
        let command = Command {
            targets: problem.tasks.tasks().iter().map(target).collect(),
            stuck: Vec::with_capacity(config.tasks.len()),
            ..Command::default()
        };
        let configuration = Configuration::new(&config.robot, &zeros)?;
        Ok(Self {
            capability: Capability::new(config),
            limited,
            approach: Approach::new(config),
            problem,
            solver,
            command,
            distance_to_rest: zeros.clone(),
            zero_velocity: zeros,
            rest: ArmAtRest::new(config, &configuration),
            look_ahead: LookAhead::new(config, &configuration),
            configuration,
            streams: Vec::new(),
            obstacles: ObstacleScratch::new(n),
        })
    }
}
