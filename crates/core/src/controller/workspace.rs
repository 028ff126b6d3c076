//! The memory in which a control period is computed.

use revprio_robot::kinematics::Configuration;

use super::ControllerConfig;
use super::step::{Command, StepError, TaskTarget};
use crate::limits::LimitedBox;
use crate::linalg::{Matrix, Vector};
use crate::resolution::{Problem, Resolver};
use crate::task::{Task, TaskStack};

/// The values of one control period. They are allocated once and overwritten in each period; no answer depends on what
/// they held before.
pub(super) struct Workspace {
    pub(super) configuration: Configuration,
    pub(super) limited: LimitedBox,
    pub(super) problem: Problem,
    pub(super) resolver: Resolver,
    pub(super) command: Command,
    /// q̇ of an arm at rest, n.
    pub(super) rest: Vec<f64>,
}

impl Workspace {
    /// Allocates for a checked configuration.
    pub(super) fn new(config: &ControllerConfig) -> Result<Self, StepError> {
        let n = config.robot.joint_count();
        let rest = vec![0.0; n];
        let limited = config.limits.at(&config.robot, &rest, &rest, config.period_s);
        let tasks = config.tasks.iter().map(|task| Task {
            name: task.name.clone(),
            jacobian: Matrix::zeros(task.rows.len(), n),
            velocity: Vector::zeros(task.rows.len()),
            scaled: task.scaled,
        });
        let problem = Problem {
            tasks: TaskStack::new(tasks.collect())?,
            limits: limited.velocity_box.clone(),
            inequalities: Vec::new(),
            method: config.method,
            solver: config.solver,
            damping: config.damping,
            null_space_velocity: config.null_space.is_some().then(|| Vector::zeros(n)),
        };
        let target = |task: &Task| TaskTarget { velocity: task.velocity.clone(), force: Vec::new() };
        let command = Command { targets: problem.tasks.tasks().iter().map(target).collect(), ..Command::default() };
        let configuration = Configuration::new(&config.robot, &rest)?;
        Ok(Self { configuration, limited, problem, resolver: Resolver::default(), command, rest })
    }
}
