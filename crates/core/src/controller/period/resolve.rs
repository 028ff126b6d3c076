//! The fourth step: which joint velocities are the answer.

mod approach;
mod clear;
mod hold;
mod released;

use self::approach::Approach;
use self::clear::keep_clear;
use self::hold::{HeldMotion, Holding};
use super::aim::Requests;
use super::allow::Allowed;
use crate::arm_state::ArmState;
use crate::collision::{CollisionGuard, Moment};
use crate::controller::config::ControllerConfig;
use crate::controller::state::{Command, Memory, StepError, TaskTarget};
use crate::limits::{LimitedBox, braking_deceleration};
use crate::linalg::{SingularValues, Vector};
use crate::resolution::{Problem, Solve};

/// The answer of the solver.
pub(super) struct Answer<'a> {
    /// The problem that the answer solves.
    pub problem: &'a Problem,
    /// The command, whose resolution is the answer, and how long it may be held. The next step sets its other fields.
    pub command: &'a mut Command,
    /// The box in which the answer lies.
    pub limits: &'a LimitedBox,
    /// The velocity that the tasks want without limits of acceleration and jerk, n; `None`: the controller keeps no jerk limit.
    pub requested: Option<&'a Vector>,
    /// Whether the transition from another controller goes on.
    pub in_transition: bool,
}

/// The memory of this step.
pub(super) struct Resolving {
    solver: Box<dyn Solve>,
    approach: Option<Approach>,
    clear: LimitedBox,
    held: Option<HeldMotion>,
    singular: SingularValues,
    command: Command,
}

impl Resolving {
    /// Allocates the command of a checked configuration; `targets`: as many as the tasks have, with their sizes.
    pub fn new(config: &ControllerConfig, arm: &ArmState, targets: &[TaskTarget], solver: Box<dyn Solve>) -> Self {
        let command =
            Command { targets: targets.to_vec(), stuck: Vec::with_capacity(targets.len()), ..Command::default() };
        let clear = LimitedBox::unbounded(config.robot.joint_count());
        let (approach, held) = (Approach::new(config), HeldMotion::new(config, arm));
        Self { solver, approach, clear, held, singular: SingularValues::default(), command }
    }

    /// Returns the command of the last period.
    pub fn command(&mut self) -> &mut Command {
        &mut self.command
    }
}

/// Returns the answer to a problem within what is allowed.
pub(super) fn resolve<'a>(
    config: &ControllerConfig,
    (arm, previous, requests): (&ArmState, &Memory, Requests),
    problem: &'a mut Problem,
    (allowed, guard): (&'a Allowed, Option<&mut CollisionGuard>),
    Resolving { solver, approach, clear, held, singular, command }: &'a mut Resolving,
) -> Result<Answer<'a>, StepError> {
    for (row, allowed) in problem.inequalities.iter_mut().zip(&allowed.inequalities) {
        row.copy_from(allowed);
    }
    let alone = allowed.alone.as_ref().filter(|_| previous.in_transition);
    let in_transition = if let Some(alone) = alone {
        problem.limits.copy_from(&alone.velocity_box);
        solver.solve(problem, &previous.active_set, &mut command.resolution)?;
        !is_in_reach(config, &arm.last_command, &command.resolution.joint_velocity)
    } else {
        false
    };
    let box_of_all = alone.filter(|_| !in_transition).unwrap_or(&allowed.limits);
    let (limits, requested) = if let (Some(approach), Some(without_jerk)) = (approach, &allowed.without_jerk) {
        let (limits, requested) = approach.resolve(
            (arm, previous, box_of_all),
            without_jerk,
            (&mut *problem, &mut **solver, &mut command.resolution),
            config.period_s,
        )?;
        (limits, Some(requested))
    } else {
        problem.limits.copy_from(&box_of_all.velocity_box);
        solver.solve(problem, &previous.active_set, &mut command.resolution)?;
        (box_of_all, None)
    };
    let mut holding = Holding { config, arm, requests, held: held.as_mut() };
    let Some(guard) = guard else {
        holding.update(&mut command.hold, command.resolution.joint_velocity.as_slice(), &problem.tasks);
        released::report((config, arm, requests), problem, &mut command.resolution, singular)?;
        return Ok(Answer { problem, command, limits, requested, in_transition });
    };
    let moment = Moment { arm, drive_state: &previous.drive };
    let is_clear = keep_clear(
        (&mut *guard, moment),
        (&allowed.limits, &mut *clear),
        (&mut *problem, &mut **solver, &mut command.resolution),
        (&previous.active_set, holding, &mut command.hold),
    )?;
    released::report((config, arm, requests), problem, &mut command.resolution, singular)?;
    command.collisions.get_or_insert_default().copy_from(guard.report());
    Ok(Answer { problem, command, limits: if is_clear { limits } else { clear }, requested, in_transition })
}

/// Returns whether no joint changes its velocity from the last command by more than A T.
fn is_in_reach(config: &ControllerConfig, last_command: &[f64], velocity: &Vector) -> bool {
    let changes = last_command.iter().zip(velocity).map(|(last, velocity)| (velocity - last).abs());
    let joints = config.robot.joints().iter();
    changes.zip(joints).all(|(change, joint)| change <= braking_deceleration(&joint.limits) * config.period_s)
}
