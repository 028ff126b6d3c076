//! Controllers.

use revprio_api::wire;
use revprio_core::channel::ChannelError;
use revprio_core::constraint::Constraint;
use revprio_core::controller::{
    ConfigError, Controller, ControllerConfig, Limits, NullSpaceError, NullSpaceMotion, TaskConfigError,
};
use revprio_core::limits::{Drive, MAX_DRIVE_DELAY};
use revprio_core::rows::RowsError;
use revprio_robot::RobotModel;

use super::channels;
use super::checks::{Inside, Missing, Result, check, each};
use super::collisions;
use super::environment;
use super::inequalities::InequalityReader;
use super::null_space::null_space;
use super::numbers::{between, damping, not_negative, number, velocity_box};
use super::pose::with_tool_offset;
use super::resolve::{known_robot, positive_period};
use super::resolve_task::check_row_count;
use super::solver::solver;
use super::task::task_config;
use super::terms;
use super::wrench_sensor::{sensor_pointer, wrench_sensors};
use crate::error::ApiError;
use crate::robots::Robots;
use crate::state_rules::StateRules;

/// Maximum lag of a drive, s.
pub const MAX_LAG_S: f64 = 1.0;

/// Smallest and largest characteristic length, m.
pub const CHARACTERISTIC_LENGTH_M: (f64, f64) = (1e-3, 1e3);

/// Maximum number of tasks of a controller.
pub const MAX_TASKS: usize = 64;

/// Maximum validity of an answer that a controller can have, ms.
pub const MAX_VALID_FOR_MS: u64 = 10_000;

/// Reads a controller.
pub fn controller(request: &wire::Controller, robots: &Robots) -> Result<Controller> {
    state_rules(request)?;
    let robot = with_tool_offset(&known_robot(&request.robot, robots)?, request.tool_offset.as_ref())?;
    check(request.tasks.len() <= MAX_TASKS, "/tasks", format_args!("give at most {MAX_TASKS} tasks"))?;
    let tasks: Vec<_> = each("/tasks", &request.tasks, |_, task| task_config(task, &robot))?;
    let (period_s, drive) = (positive_period(request.period_s, "/period_s")?, drive(request.drive)?);
    let joints = robot.joint_count();
    let config = ControllerConfig {
        period_s,
        method: terms::method(request.method),
        solver: solver(request.solver)?,
        damping: damping(request.damping)?,
        characteristic_length_m: characteristic_length(request.characteristic_length_m)?,
        limits: match &request.limits {
            wire::Limits::Robot(kind) => Limits::Robot(terms::limit_kind(*kind)),
            wire::Limits::Box { lower, upper } => Limits::Fixed(velocity_box(lower, upper, joints)?),
        },
        drive,
        valid_for_ms: request.valid_for_ms,
        constraints: constraints(request, &robot)?,
        wrench_convention: terms::wrench_convention(request.wrench_convention),
        wrench_frame: terms::wrench_frame(request.wrench_frame),
        wrench_sensors: wrench_sensors(request, &robot)?,
        null_space: match &request.null_space_velocity {
            Some(motion) => null_space(motion, Some(&robot), joints)?,
            None => NullSpaceMotion::default_for(&robot, &tasks, drive, period_s),
        },
        leave_local_minima: request.leave_local_minima,
        anti_windup: terms::anti_windup(request.anti_windup),
        tasks,
        channels: channels::channels(&request.channels)?,
        robot,
    };
    check_row_count(config.tasks.iter().map(|task| task.rows.len()))?;
    environment::check_environment(request)?;
    Controller::new(config).map_err(|error| ApiError::invalid(config_pointer(&error), error))
}

/// Reads the inequalities, then what the arm keeps clear of.
fn constraints(request: &wire::Controller, robot: &RobotModel) -> Result<Vec<Constraint>> {
    let reader = InequalityReader { robot: Some(robot), joints: robot.joint_count(), period_s: Some(request.period_s) };
    let mut constraints = reader.read(&request.inequalities)?;
    if let Some(stated) = &request.collisions {
        let distances = Constraint::Distances(collisions::avoidance(stated, robot).inside("/collisions")?);
        let is_taken = |constraint: &Constraint| constraint.name().starts_with(distances.name());
        if let Some(index) = constraints.iter().position(is_taken) {
            let detail =
                format!("names with `{}` are those of the rows of `collisions`; give another", distances.name());
            return Err(ApiError::invalid(format!("/inequalities/{index}/name"), detail));
        }
        constraints.push(distances);
    }
    Ok(constraints)
}

/// Reads the rules for the states of a controller.
pub fn state_rules(controller: &wire::Controller) -> Result<StateRules> {
    let wire::Controller { valid_for_ms, why, state_checks: checks, .. } = *controller;
    let detail = format_args!("give 1 to {MAX_VALID_FOR_MS} ms");
    check((1..=MAX_VALID_FOR_MS).contains(&valid_for_ms), "/valid_for_ms", detail)?;
    not_negative(checks.position_tolerance, "/state_checks/position_tolerance")?;
    not_negative(checks.max_force_n.unwrap_or_default(), "/state_checks/max_force_n")?;
    not_negative(checks.max_torque_nm.unwrap_or_default(), "/state_checks/max_torque_nm")?;
    Ok(StateRules { valid_for_ms, why, checks })
}

fn characteristic_length(length: f64) -> Result<f64> {
    let (pointer, (least, greatest)) = ("/characteristic_length_m", CHARACTERISTIC_LENGTH_M);
    between(number(length, pointer)?, least..=greatest, pointer, format_args!("give {least} to {greatest} m"))
}

fn drive(drive: wire::JointDrive) -> Result<Drive> {
    let lag_s = number(drive.lag_s, "/drive/lag_s")?;
    let lag_s = between(lag_s, 0.0..=MAX_LAG_S, "/drive/lag_s", format_args!("give 0 to {MAX_LAG_S} s"))?;
    let delay = usize::try_from(drive.delay_periods).ok().filter(|delay| *delay <= MAX_DRIVE_DELAY);
    let too_long = format_args!("give at most {MAX_DRIVE_DELAY}");
    Ok(Drive { lag_s, delay_periods: delay.or_invalid("/drive/delay_periods", too_long)? })
}

fn config_pointer(error: &ConfigError) -> String {
    match error {
        ConfigError::Period(_) => "/period_s".to_owned(),
        ConfigError::CharacteristicLength(_) => "/characteristic_length_m".to_owned(),
        ConfigError::NoTasks => "/tasks".to_owned(),
        ConfigError::DuplicateTask { task, .. } => format!("/tasks/{task}/name"),
        ConfigError::Task { task, source: TaskConfigError::Streaming(source) } => {
            format!("/tasks/{task}/streaming/{}", source.field())
        }
        ConfigError::Task { task, source } => format!("/tasks/{task}{}", task_field(source)),
        ConfigError::Surfaces { task } => format!("/tasks/{task}/law/surface"),
        ConfigError::Path { task } => format!("/tasks/{task}/law"),
        ConfigError::Limits { .. } | ConfigError::Unplanned => "/limits".to_owned(),
        ConfigError::Collisions(_) | ConfigError::CollisionsTwice => "/collisions".to_owned(),
        ConfigError::Channel { index, source } => format!("/channels/{index}{}", channel_field(source)),
        ConfigError::WrenchSensor { source, .. } => sensor_pointer(source),
        ConfigError::Drive => "/drive".to_owned(),
        ConfigError::Constraint { index, .. } => format!("/inequalities/{index}"),
        ConfigError::ConstraintRows { .. } => "/inequalities".to_owned(),
        ConfigError::NullSpace(NullSpaceError::Size { .. }) => "/null_space_velocity".to_owned(),
        ConfigError::NullSpace(NullSpaceError::Gain(_) | NullSpaceError::Unstable { .. }) => {
            "/null_space_velocity/gain".to_owned()
        }
    }
}

fn channel_field(error: &ChannelError) -> &'static str {
    match error {
        ChannelError::Range { .. } => "/upper",
        ChannelError::Rate(_) => "/max_rate",
        ChannelError::Target(_) => "/target",
        ChannelError::Twice(_) => "/name",
        ChannelError::TooMany(_) => "",
    }
}

fn task_field(error: &TaskConfigError) -> &'static str {
    match error {
        TaskConfigError::Rows(
            RowsError::Rows { .. } | RowsError::JointLaw | RowsError::RawLaw | RowsError::GazeLaw | RowsError::LinkLaw,
        ) => "/law",
        TaskConfigError::Rows(RowsError::Direction) => "/law/direction",
        TaskConfigError::Rows(RowsError::Link) => "/link",
        TaskConfigError::Rows(RowsError::Joints) => "/law/joints",
        TaskConfigError::Rows(RowsError::Jacobian { .. }) => "/jacobian",
        TaskConfigError::Unstable { .. } => "/law/gain",
        TaskConfigError::Path => "/law/path",
        TaskConfigError::Scaled => "/scale",
        TaskConfigError::Streaming(_) => "/streaming",
    }
}
