//! Tasks of `POST /v1/resolve`.

use revprio_api::wire;
use revprio_core::linalg::Matrix;
use revprio_core::task::{Task, TaskError, TaskStack};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{AxisSelection, Configuration};

use super::checks::{Inside, Missing, Refused, Result, check, each};
use super::numbers::{check_numbers, numbers, velocity_bounds};
use super::pose::{task_body, task_frame};
use super::terms;
use crate::error::ApiError;
use crate::robots::MAX_JOINTS;

/// Maximum number of rows of all tasks together. It is far above any arm, and bounds the time of a request.
pub const MAX_ROWS: usize = 512;

/// Reads the tasks of a request.
pub fn task_stack(request: &wire::ResolveRequest, arm: Option<(&RobotModel, &Configuration)>) -> Result<TaskStack> {
    let tasks: Vec<Task> = each("/tasks", &request.tasks, |k, request| task(k, request, arm))?;
    check_row_count(tasks.iter().map(|task| task.jacobian.nrows()))?;
    TaskStack::new(tasks).map_err(|error| ApiError::invalid(task_pointer(&error), error))
}

/// Checks the number of rows of all tasks together, from the number of rows of each task.
pub fn check_row_count(rows: impl Iterator<Item = usize>) -> Result<()> {
    let detail = format_args!("give at most {MAX_ROWS} rows in all tasks together");
    check(rows.sum::<usize>() <= MAX_ROWS, "/tasks", detail)
}

fn task_pointer(error: &TaskError) -> String {
    match error {
        TaskError::NoTasks => "/tasks".to_owned(),
        TaskError::Rows { task, .. } => format!("/tasks/{task}/velocity"),
        TaskError::Columns { task, .. } | TaskError::NotFinite { task } => format!("/tasks/{task}/jacobian"),
        TaskError::Bounds { task, row } => format!("/tasks/{task}/lower/{row}"),
        TaskError::Scaled { task } => format!("/tasks/{task}/scale"),
    }
}

fn task(k: usize, task: &wire::ResolveTask, arm: Option<(&RobotModel, &Configuration)>) -> Result<Task> {
    let jacobian = match (&task.axes, &task.jacobian) {
        (Some(axes), None) => {
            let axes = axis_selection(axes, "/axes")?;
            let detail = "axes need `robot` and `joint_position`; or give `jacobian` rows instead";
            let (robot, configuration) = arm.or_invalid("/axes", detail)?;
            let body = task_body(robot, task.link.as_deref(), task.relative_to.as_deref())?;
            let frame = task_frame(body, &task.frame, task.reference_point)?;
            without_rounding(axes.rows_of(&frame.at(configuration).jacobian()), &axes, configuration)
        }
        (None, Some(rows)) => {
            check_no_link(task.link.as_deref(), task.relative_to.as_deref())?;
            let jacobian = own_jacobian(rows, &task.frame, task.reference_point)?;
            let (columns, joints) = (jacobian.ncols(), arm.map(|(robot, _)| robot.joint_count()));
            let detail =
                format_args!("its rows have {columns} entries, but the robot has {} joints", joints.unwrap_or(0));
            check(joints.is_none_or(|joints| columns == joints), "/jacobian", detail)?;
            jacobian
        }
        _ => return Err(ApiError::invalid("", "give either `axes` or `jacobian`")),
    };
    let name = task.name.clone().unwrap_or_else(|| format!("task {}", k + 1));
    let bounds = velocity_bounds(task.lower.as_deref(), task.upper.as_deref(), jacobian.nrows())?;
    match (&task.velocity, bounds) {
        (Some(velocity), None) => {
            Ok(Task { scaled: task.scale, ..Task::new(name, jacobian, numbers(velocity, "/velocity")?) })
        }
        (None, Some(_)) if task.scale => Err(scaled_bounds()),
        (None, Some(bounds)) => Ok(Task::between(name, jacobian, bounds.lower().clone(), bounds.upper().clone())),
        _ => Err(ApiError::invalid("", "give either `velocity`, or `lower` and `upper` (or one of them)")),
    }
}

/// Returns a Jacobian (m × n) whose rows are zero where only rounding is left of them: no joint moves such a row at this posture, and a solver
/// would move all of them as fast as they can.
fn without_rounding(mut jacobian: Matrix, axes: &AxisSelection, configuration: &Configuration) -> Matrix {
    for (mut row, axis) in jacobian.row_iter_mut().zip(axes.axes()) {
        if row.norm() <= configuration.rounding(axis.index() >= 3) {
            row.fill(0.0);
        }
    }
    jacobian
}

/// Returns the error of a task with bounds that is to be scaled.
pub fn scaled_bounds() -> ApiError {
    ApiError::invalid("/scale", "a task with bounds has no direction to keep; omit `scale`")
}

/// Checks that a task with `jacobian` names no link.
pub fn check_no_link(link: Option<&str>, relative_to: Option<&str>) -> Result<()> {
    check(link.is_none(), "/link", "`jacobian` rows have no link; it needs `axes`")?;
    check(relative_to.is_none(), "/relative_to", "`jacobian` rows have no link; it needs `axes`")
}

/// Reads the Jacobian of a task at `/jacobian`. Such a task has no frame and no reference point.
pub fn own_jacobian(rows: &[Vec<f64>], frame: &wire::Frame, reference_point: Option<[f64; 3]>) -> Result<Matrix> {
    check(*frame == wire::Frame::Base, "/frame", "`jacobian` rows have no frame; it needs `axes`")?;
    let detail = "`jacobian` rows have no point; it needs `axes`";
    check(reference_point.is_none(), "/reference_point", detail)?;
    matrix(rows).inside("/jacobian")
}

/// Reads the axes of a task.
pub fn axis_selection(axes: &[wire::Axis], pointer: &str) -> Result<AxisSelection> {
    let axes: Vec<_> = axes.iter().copied().map(terms::axis).collect();
    AxisSelection::new(&axes).at(pointer)
}

fn matrix(rows: &[Vec<f64>]) -> Result<Matrix> {
    let columns = rows.first().map_or(0, Vec::len);
    let detail = format_args!("give rows of 1 to {MAX_JOINTS} numbers, one per joint");
    check((1..=MAX_JOINTS).contains(&columns), "", detail)?;
    each::<_, _, ()>("", rows, |_, row| {
        let given = row.len();
        let detail = format_args!("{given} numbers, but the first row has {columns}; give rows of equal length");
        check(given == columns, "", detail)?;
        check_numbers(row, "")
    })?;
    Ok(Matrix::from_fn(rows.len(), columns, |i, j| rows[i][j]))
}
