//! Tasks of `POST /v1/resolve`.

use revprio_api::wire;
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::task::{Task, TaskError, TaskStack};
use revprio_robot::kinematics::{AxisSelection, Configuration};

use super::numbers::{MAX_JOINTS, check_numbers, numbers, velocity_bounds};
use super::pose::task_frame;
use super::terms;
use crate::service::error::ApiError;

/// Maximum number of rows of all tasks together. It is far above any arm, and bounds the time of a request.
pub const MAX_ROWS: usize = 512;

/// Reads the tasks of a request.
pub fn task_stack(
    request: &wire::ResolveRequest,
    configuration: Option<&Configuration>,
) -> Result<TaskStack, ApiError> {
    let read = |(k, request): (usize, &wire::ResolveTask)| {
        task(k, request, configuration).map_err(|error| error.inside(&format!("/tasks/{k}")))
    };
    let tasks: Vec<Task> = request.tasks.iter().enumerate().map(read).collect::<Result<_, _>>()?;
    check_row_count(tasks.iter().map(|task| task.jacobian.nrows()))?;
    TaskStack::new(tasks).map_err(|error| ApiError::invalid(task_pointer(&error), error))
}

/// Checks the number of rows of all tasks together, from the number of rows of each task.
pub fn check_row_count(rows: impl Iterator<Item = usize>) -> Result<(), ApiError> {
    if rows.sum::<usize>() <= MAX_ROWS {
        return Ok(());
    }
    Err(ApiError::invalid("/tasks", format!("give at most {MAX_ROWS} rows in all tasks together")))
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

fn task(k: usize, task: &wire::ResolveTask, configuration: Option<&Configuration>) -> Result<Task, ApiError> {
    let jacobian = match (&task.axes, &task.jacobian) {
        (Some(axes), None) => {
            let axes = axis_selection(axes, "/axes")?;
            let detail = "axes need `robot` and `joint_position`; or give `jacobian` rows instead";
            let configuration = configuration.ok_or_else(|| ApiError::invalid("/axes", detail))?;
            let frame = task_frame(&task.frame, task.reference_point)?;
            axes.rows_of(&frame.at(configuration).jacobian())
        }
        (None, Some(rows)) => own_jacobian(rows, &task.frame, task.reference_point)?,
        _ => return Err(ApiError::invalid("", "give either `axes` or `jacobian`")),
    };
    let name = task.name.clone().unwrap_or_else(|| format!("task {}", k + 1));
    let bounds = velocity_bounds(task.lower.as_deref(), task.upper.as_deref(), jacobian.nrows())?;
    match (&task.velocity, bounds) {
        (Some(velocity), None) => {
            let velocity = Vector::from_vec(numbers(velocity, "/velocity")?);
            Ok(Task { scaled: task.scale, ..Task::new(name, jacobian, velocity) })
        }
        (None, Some(_)) if task.scale => Err(scaled_bounds()),
        (None, Some(bounds)) => Ok(Task::between(name, jacobian, bounds.lower().clone(), bounds.upper().clone())),
        _ => Err(ApiError::invalid("", "give either `velocity`, or `lower` and `upper` (or one of them)")),
    }
}

/// Returns the error of a task with bounds that is to be scaled.
pub fn scaled_bounds() -> ApiError {
    ApiError::invalid("/scale", "a task with bounds has no direction to keep; omit `scale`")
}

/// Reads the Jacobian of a task at `/jacobian`. Such a task has no frame and no reference point.
pub fn own_jacobian(
    rows: &[Vec<f64>],
    frame: &wire::Frame,
    reference_point: Option<[f64; 3]>,
) -> Result<Matrix, ApiError> {
    if *frame != wire::Frame::Base {
        return Err(ApiError::invalid("/frame", "`jacobian` rows have no frame; it needs `axes`"));
    }
    if reference_point.is_some() {
        return Err(ApiError::invalid("/reference_point", "`jacobian` rows have no point; it needs `axes`"));
    }
    matrix(rows).map_err(|error| error.inside("/jacobian"))
}

/// Reads the axes of a task.
pub fn axis_selection(axes: &[wire::Axis], pointer: &str) -> Result<AxisSelection, ApiError> {
    let axes: Vec<_> = axes.iter().copied().map(terms::axis).collect();
    AxisSelection::new(&axes).map_err(|error| ApiError::invalid(pointer, error))
}

fn matrix(rows: &[Vec<f64>]) -> Result<Matrix, ApiError> {
    let columns = rows.first().map_or(0, Vec::len);
    if columns == 0 || columns > MAX_JOINTS {
        return Err(ApiError::invalid("", format!("give rows of 1 to {MAX_JOINTS} numbers, one per joint")));
    }
    for (i, row) in rows.iter().enumerate() {
        if row.len() != columns {
            let detail = format!("{} numbers, but the first row has {columns}; give rows of equal length", row.len());
            return Err(ApiError::invalid(format!("/{i}"), detail));
        }
        check_numbers(row, "").map_err(|error| error.inside(&format!("/{i}")))?;
    }
    Ok(Matrix::from_fn(rows.len(), columns, |i, j| rows[i][j]))
}
