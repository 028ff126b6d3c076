//! The states of control periods and their answers.

use std::collections::BTreeMap;

use crate::clock::Instant;
use revprio_api::wire;
use revprio_core::controller::{Command, Controller, Measurement, StepError, StuckTask, TransitionError};
use revprio_core::limits::{Hold, braking_deceleration};
use revprio_core::linalg::Vector;
use revprio_robot::kinematics::ConfigurationError;

use super::arm::arm_view;
use super::checks::{Result, check};
use super::collisions::{obstacle_states, report_answer};
use super::contact::contact_answer;
use super::numbers::{joint_names, joint_vector, time};
use super::outcome::{Outcome, elapsed_us};
use super::wrench_sensor::corrected;
use super::{channels, chunks, targets, terms, wrenches};
use crate::constraint_names::ConstraintNames;
use crate::error::ApiError;
use crate::state_rules::StateRules;

/// Maximum sequence number. Clients with double-precision numbers cannot count beyond it.
pub const MAX_SEQUENCE: u64 = (1 << 53) - 1;

/// Refuses a sequence number that is not greater than the last one.
pub fn check_sequence(last: u64, new: u64) -> Result<()> {
    if new > last {
        return Ok(());
    }
    Err(ApiError::sequence(format!(
        "sequence {new} after {last}; increase it with every new state, and repeat it only with an unchanged state"
    )))
}

/// Reads a state.
pub fn measurement(state: &wire::State, controller: &Controller) -> Result<Measurement> {
    let robot = &controller.config().robot;
    check(state.sequence <= MAX_SEQUENCE, "/sequence", format_args!("give at most {MAX_SEQUENCE}"))?;
    let time_s = time(state.time_s, "/time_s")?;
    let (targets, chunks) = targets::targets(&state.targets, time_s, controller)?;
    targets::check_times(&targets, time_s, controller)?;
    chunks::check_times(&chunks, time_s, controller)?;
    Ok(Measurement {
        obstacles: obstacle_states(&state.obstacles)?,
        time_s,
        joint_position: joint_vector(&state.joint_position, robot, "/joint_position")?,
        joint_velocity: state.joint_velocity.as_ref().map(|v| joint_vector(v, robot, "/joint_velocity")).transpose()?,
        wrench: wrenches::tool(state, controller)?,
        wrenches: wrenches::other_tips(state, controller)?,
        targets,
        chunks,
        channels: channels::inputs(&state.channels, controller)?,
    })
}

/// Converts the error of a step to a measurement, if there is one. Pointers begin at the state, except those to the memory.
pub fn step_error(error: &StepError, measurement: Option<&Measurement>) -> ApiError {
    let has_wrench = |measurement: &Measurement| measurement.wrench != [0.0; 6] || !measurement.wrenches.is_empty();
    let field = match error {
        StepError::Configuration(ConfigurationError::Size { .. } | ConfigurationError::NotFinite { .. }) => {
            "/joint_position"
        }
        StepError::JointVelocity { .. } => "/joint_velocity",
        StepError::NotFinite => "/wrench",
        // Gains may be the cause, too.
        StepError::Task(_) => measurement.filter(|measurement| has_wrench(measurement)).map_or("", |_| "/wrench"),
        StepError::Channel => "/channels",
        StepError::WrenchTip { .. } => "/wrenches",
        StepError::Target { .. } | StepError::Chunk { .. } => "/targets",
        StepError::UnknownObstacle { index, .. } | StepError::ObstacleTwice { index, .. } => {
            return ApiError::invalid(format!("/obstacles/{index}/name"), error);
        }
        StepError::Obstacle { index, .. } => return ApiError::invalid(format!("/obstacles/{index}"), error),
        StepError::MissingObstacle { .. } => "/obstacles",
        StepError::Memory(_) => return ApiError::invalid("/memory", error),
        StepError::Problem(_) | StepError::Solver => "",
    };
    ApiError::invalid(field, error)
}

/// Converts the error of a controller that is to replace another one. Pointers begin at the controller.
pub fn transition_error(error: &TransitionError) -> ApiError {
    let field = match error {
        TransitionError::Robot => "/robot",
        TransitionError::Period { .. } => "/period_s",
        TransitionError::Drive => "/drive",
        TransitionError::IgnoresLimits => "/solver",
        TransitionError::Reverses { task } => {
            return ApiError::invalid(format!("/tasks/{task}/law/target_force"), error);
        }
        TransitionError::Configuration(_) | TransitionError::Memory(_) => "",
    };
    ApiError::invalid(field, error)
}

/// Returns how long a command may be held, whole ms.
pub fn valid_for_ms(hold: &Hold, rules: &StateRules) -> u64 {
    hold.valid_for_ms(rules.valid_for_ms)
}

/// Returns the body of the answer, without memory, warnings and `why`.
pub fn step_answer(
    controller: &Controller,
    rules: &StateRules,
    sequence: u64,
    command: &Command,
    start: Instant,
) -> wire::StepAnswer {
    let config = controller.config();
    let deceleration = |joint: &revprio_robot::Joint| {
        Some(braking_deceleration(&joint.limits)).filter(|deceleration| deceleration.is_finite())
    };
    let outcome = Outcome {
        resolution: &command.resolution,
        joints: joint_names(&config.robot),
        tasks: config.tasks.iter().map(|task| task.name.as_str()).collect(),
        inequalities: ConstraintNames::of_command(config, command),
        faster_than: (!config.limits.include_speeds()).then_some(&config.robot),
    };
    let task = |k: usize| {
        let target = &command.targets[k];
        (target.velocity.as_slice().to_vec(), Some(target.force.clone()))
    };
    let (mut wrench, mut other_wrenches) = (None, BTreeMap::new());
    for (tip, is_tool, corrected) in corrected(command, config) {
        if is_tool {
            wrench = Some(corrected);
        } else {
            other_wrenches.insert(tip.name.clone(), corrected);
        }
    }
    wire::StepAnswer {
        wrench,
        wrenches: other_wrenches,
        joint_velocity: outcome.joint_velocity(),
        sequence,
        memory: None,
        channels: channels::commands(command, config),
        valid_for_ms: valid_for_ms(&command.hold, rules),
        stop_time_s: command.hold.stop_time_s,
        braking_deceleration: config.robot.joints().iter().map(deceleration).collect(),
        warnings: Vec::new(),
        why: Vec::new(),
        tasks: tasks_with_targets(outcome.tasks(task), command),
        stuck_tasks: command.stuck.iter().map(|stuck| stuck_task(stuck, controller)).collect(),
        request_share: command.fading_since_s.map(|_| command.request_share),
        fading_since_s: command.fading_since_s,
        active_limits: outcome.active_limits(),
        violated_limits: outcome.violated_limits(),
        active_inequalities: outcome.active_inequalities(),
        violated_inequalities: outcome.violated_inequalities(),
        contradictions: outcome.contradictions(),
        collisions: command.collisions.as_ref().map(report_answer),
        limit_conflict: outcome.names(&command.limit_conflicts),
        solver: outcome.solver(),
        singularity: outcome.singularity(),
        joint_limit_index: command.joint_limit_index,
        elapsed_us: elapsed_us(start),
    }
}

fn stuck_task(stuck: &StuckTask, controller: &Controller) -> wire::StuckTask {
    wire::StuckTask {
        task: controller.config().tasks[stuck.task].name.clone(),
        since_s: stuck.since_s,
        held_by: stuck.held_by.iter().map(|obstacle| terms::obstacle_answer(*obstacle)).collect(),
        leaving: stuck.leaving,
    }
}

/// Adds the reports of contacts and of streamed targets to the outcomes of tasks.
fn tasks_with_targets(mut tasks: Vec<wire::TaskOutcome>, command: &Command) -> Vec<wire::TaskOutcome> {
    for (task, target) in tasks.iter_mut().zip(&command.targets) {
        task.contact = target.contact.iter().map(contact_answer).collect();
        task.target_state = target.streamed.map(|report| terms::target_state_answer(report.state));
        task.target_age_s = target.streamed.and_then(|report| report.age_s);
        task.chunk = target.streamed.and_then(|report| report.chunk).map(chunks::status);
    }
    tasks
}

/// Returns a period of a session for watchers. `last_command`: joint velocities of the previous period, n, if known.
pub fn watched_step(
    controller: &Controller,
    state: &wire::State,
    answer: &wire::StepAnswer,
    last_command: Option<&Vector>,
) -> wire::WatchedStep {
    let config = controller.config();
    let position = joint_vector(&state.joint_position, &config.robot, "").ok();
    let measured = state.joint_velocity.as_ref().and_then(|v| joint_vector(v, &config.robot, "").ok());
    let last = last_command.cloned().or(measured).unwrap_or_else(|| Vector::zeros(config.robot.joint_count()));
    let arm = position.and_then(|position: Vec<f64>| arm_view(config, &position, last.as_slice()));
    wire::WatchedStep { state: state.clone(), answer: answer.clone(), arm }
}
