//! The fifth step: the command with its explanation, and the memory for the next period.

mod contacts;
mod next_memory;
mod progress;
mod stalls;

use revprio_robot::kinematics::joint_limit_index;

pub use self::progress::MAX_ATTEMPTS;
use self::progress::{Observation, ObstacleScratch};
use super::aim::{Gains, Requests};
use super::allow::Allowed;
use super::resolve::Answer;
use crate::arm_state::ArmState;
use crate::channel::ChannelState;
use crate::constraint;
use crate::controller::config::{ControllerConfig, TaskConfig};
use crate::controller::state::{Command, Measurement, Memory, RestState, TaskTarget, are_moving, has_jumped};
use crate::law::VelocityBounds;
use crate::linalg::Vector;
use crate::resolution::{Problem, Resolution, TaskOutcome};

/// The memory of this step.
#[derive(Debug)]
pub(super) struct Recording {
    obstacles: ObstacleScratch,
}

impl Recording {
    /// Allocates the memory for n joints.
    pub fn new(n: usize) -> Self {
        Self { obstacles: ObstacleScratch::new(n) }
    }
}

/// Completes the command, and updates the memory; `in_time`: the state comes one period after the last one.
pub(super) fn record<'a>(
    config: &ControllerConfig,
    (measurement, in_time): (&Measurement, bool),
    (arm, Requests { targets, streams, contacts, gains, share, virtual_arm, channels, .. }, allowed): (
        &ArmState,
        Requests,
        &Allowed,
    ),
    Answer { problem, command, limits, requested, in_transition }: Answer<'a>,
    memory: &mut Memory,
    scratch: &mut Recording,
) -> &'a Command {
    remove_weights(config, &mut command.resolution.tasks, targets);
    copy_targets(&mut command.targets, targets);
    command.wrenches.clear();
    command.wrenches.extend(config.wrench_sensors.iter().map(|sensor| arm.wrenches[sensor.tip]));
    memory.wrench_sensors.clone_from(&arm.sensors);
    command.channels.clear();
    command.channels.extend(channels.iter().map(|channel| channel.command));
    remember_channels(&mut memory.channels, channels);
    report_bounds(config, command);
    let causes = command.resolution.active_limits().map(|(joint, active)| limits.cause(joint, active.bound.side));
    command.limit_causes.clear();
    command.limit_causes.extend(causes);
    command.limit_conflicts.clone_from(&allowed.limits.conflicts);
    let position = &measurement.joint_position;
    command.joint_limit_index = joint_limit_index(&config.robot, position);
    if let Some(ahead) = virtual_arm {
        match &mut memory.virtual_arm {
            Some(known) => known.copy_from(ahead),
            None => memory.virtual_arm = Some(ahead.clone()),
        }
    }
    stalls::update(memory, config, position, in_time, &mut command.stalled);
    update_rest(
        memory,
        (config, arm),
        (gains, makes_way(config, measurement, (problem, &command.resolution))),
        &command.resolution.joint_velocity,
    );
    contacts::update(&mut memory.contacts, (config, &memory.drive), contacts, &problem.tasks, &command.resolution);
    memory.in_transition = in_transition;
    next_memory::update(memory, config, measurement, (command, requested), streams);
    command.request_share = share;
    command.fading_since_s = memory.rest.as_ref().and_then(|rest| rest.fading_since_s).filter(|_| share < 1.0);
    let observed = Observation {
        config,
        tasks: &problem.tasks,
        problem,
        targets: &command.targets,
        resolution: &command.resolution,
        joint_position: position,
        time_s: measurement.time_s,
        share,
        fading_since_s: command.fading_since_s,
        has_new_target: gains.has_new_target,
        distances: &gains.distances,
    };
    let leaves = observed.update(&mut memory.progress, &mut command.stuck, &mut scratch.obstacles);
    if let (true, Some(rest)) = (leaves, &mut memory.rest) {
        rest.restart();
    }
    command
}

/// Speed of an obstacle above which it moves, m/s: more than what a millimetre of noise makes of one that rests, 30 times a second.
const OBSTACLE_SPEED: f64 = 0.05;

/// Returns whether the arm keeps clear while an obstacle moves: it turns with the obstacle then, as with a target that moves.
fn makes_way(
    config: &ControllerConfig,
    measurement: &Measurement,
    (problem, resolution): (&Problem, &Resolution),
) -> bool {
    let moves = measurement.obstacles.iter().any(|obstacle| obstacle.velocity.norm() > OBSTACLE_SPEED);
    let Some((_, rows)) = constraint::distances(&config.constraints).filter(|_| moves) else { return false };
    // Each row 0 begins a constraint.
    let index = |row: usize| problem.inequalities[..row].iter().filter(|row| row.row() == 0).count();
    let of_distances = index(rows.start)..index(rows.end);
    resolution.active_constraints().any(|(constraint, _)| of_distances.contains(&constraint))
}

/// Updates how the joints turn and what the tasks gained. The memory is that before the command, n.
fn update_rest(
    memory: &mut Memory,
    (config, arm): (&ControllerConfig, &ArmState),
    (gains, makes_way): (&Gains, bool),
    command: &Vector,
) {
    if !config.comes_to_rest() {
        return;
    }
    let Memory { rest, progress, .. } = memory;
    let rest = rest.get_or_insert_with(|| RestState::new(command.len(), config.tasks.len()));
    rest.tasks.clone_from(&gains.tasks);
    // Not by its own way while states were missing.
    let moved = arm.moved.iter().zip(&arm.missed_way).map(|(moved, missed)| moved - missed);
    let targets_change = gains.has_new_target || are_moving(gains.way, config.period_s);
    if targets_change || makes_way || has_jumped(moved) {
        rest.restart();
    }
    if !progress.iter().any(|progress| progress.is_leaving(arm.time_s)) {
        let joints = (command.as_slice(), arm.at_rest().configuration.joint_position());
        rest.update(arm.time_s, joints, gains.earned, config.period_s);
    }
}

/// Divides the outcomes by the weights of their rows, and computes the residuals in m/s and rad/s.
fn remove_weights(config: &ControllerConfig, outcomes: &mut [TaskOutcome], targets: &[TaskTarget]) {
    if config.is_unweighted() {
        return;
    }
    for (k, (outcome, target)) in outcomes.iter_mut().zip(targets).enumerate() {
        let mut squares = 0.0;
        for (row, achieved) in outcome.achieved.iter_mut().enumerate() {
            *achieved /= config.weight(k, row);
            let missed = match stated_bounds(&config.tasks[k], target) {
                Some(bounds) => *achieved - achieved.clamp(bounds.lower()[row], bounds.upper()[row]),
                None => *achieved - target.velocity[row],
            };
            squares += missed * missed;
        }
        outcome.residual_norm = squares.sqrt();
    }
}

/// Returns the bounds that a task asks for; `None`: it has a law, or is released.
fn stated_bounds<'a>(task: &'a TaskConfig, target: &TaskTarget) -> Option<&'a VelocityBounds> {
    task.law.bounds().filter(|_| target.released_by.is_none())
}

/// Keeps the channels, without allocating if the memory has them.
fn remember_channels(memory: &mut Vec<ChannelState>, channels: &[ChannelState]) {
    memory.resize_with(channels.len(), ChannelState::default);
    memory.iter_mut().zip(channels).for_each(|(known, channel)| known.clone_from(channel));
}

/// Copies targets of the same sizes.
fn copy_targets(targets: &mut [TaskTarget], wished: &[TaskTarget]) {
    for (target, wished) in targets.iter_mut().zip(wished) {
        target.velocity.copy_from(&wished.velocity);
        target.force.clone_from(&wished.force);
        target.streamed = wished.streamed;
        target.unused = wished.unused;
        target.released_by = wished.released_by;
        target.is_short = wished.is_short;
        target.contact.clone_from(&wished.contact);
    }
}

/// Sets the targets of tasks with bounds, which the answer decides.
fn report_bounds(config: &ControllerConfig, command: &mut Command) {
    for ((target, outcome), task) in command.targets.iter_mut().zip(&command.resolution.tasks).zip(&config.tasks) {
        if let Some(bounds) = stated_bounds(task, target) {
            target.velocity.copy_from_slice(&bounds.nearest(outcome.achieved.as_slice()));
        }
    }
}
