//! The fourth step: which joint velocities are the answer.

mod approach;

use self::approach::Approach;
use super::allow::Allowed;
use crate::arm_state::ArmState;
use crate::controller::config::ControllerConfig;
use crate::controller::state::{Command, Memory, TaskTarget};
use crate::limits::LimitedBox;
use crate::linalg::Vector;
use crate::resolution::{Problem, ProblemError, Solve};

/// The answer of the solver.
pub(super) struct Answer<'a> {
    /// The problem that the answer solves.
    pub problem: &'a Problem,
    /// The command, whose resolution is the answer. The next step sets its other fields.
    pub command: &'a mut Command,
    /// The box in which the answer lies.
    pub limits: &'a LimitedBox,
    /// The velocity that the tasks want without limits of acceleration and jerk, n; `None`: the controller keeps no jerk limit.
    pub requested: Option<&'a Vector>,
}

/// The memory of this step.
pub(super) struct Resolving {
    solver: Box<dyn Solve>,
    approach: Option<Approach>,
    command: Command,
}

impl Resolving {
    /// Allocates the command of a checked configuration; `targets`: as many as the tasks have, with their sizes.
    pub fn new(config: &ControllerConfig, targets: &[TaskTarget], solver: Box<dyn Solve>) -> Self {
        let command =
            Command { targets: targets.to_vec(), stuck: Vec::with_capacity(targets.len()), ..Command::default() };
        Self { solver, approach: Approach::new(config), command }
    }

    /// Returns the command of the last period.
    pub fn command(&mut self) -> &mut Command {
        &mut self.command
    }
}

/// Returns the answer to a problem within what is allowed.
pub(super) fn resolve<'a>(
    config: &ControllerConfig,
    (arm, previous): (&ArmState, &Memory),
    problem: &'a mut Problem,
    allowed: &'a Allowed,
    Resolving { solver, approach, command }: &'a mut Resolving,
) -> Result<Answer<'a>, ProblemError> {
    for (row, allowed) in problem.inequalities.iter_mut().zip(&allowed.inequalities) {
        row.overwrite(|coefficients| {
            coefficients.copy_from_slice(allowed.coefficients().as_slice());
            allowed.bound()
        });
    }
    let (limits, requested) = if let (Some(approach), Some(without_jerk)) = (approach, &allowed.without_jerk) {
        let (limits, requested) = approach.resolve(
            (arm, previous, allowed),
            without_jerk,
            (&mut *problem, &mut **solver, &mut command.resolution),
            config.period_s,
        )?;
        (limits, Some(requested))
    } else {
        problem.limits.copy_from(&allowed.limits.velocity_box);
        solver.solve(problem, &previous.active_set, &mut command.resolution)?;
        (&allowed.limits, None)
    };
    Ok(Answer { problem, command, limits, requested })
}
