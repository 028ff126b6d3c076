//! The values of targets and actions.

use nalgebra::{UnitQuaternion, Vector3};
use revprio_api::wire::{self, JointVector};
use revprio_core::controller::TaskConfig;
use revprio_core::rows::TaskRows;
use revprio_core::streaming::{Quantity, StreamedValue};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::pose as pose_of;

use super::checks::{Refused, Result, check};
use super::numbers::{by_name, check_numbers, numbers};
use crate::error::escape_pointer;

/// Returns the JSON pointer of the target of a task.
pub fn place(task: &str) -> String {
    format!("/targets/{}", escape_pointer(task))
}

/// Explains which targets a task accepts.
pub fn misfit(task: &TaskConfig) -> String {
    let accepted = |quantity: &Quantity| match quantity {
        Quantity::Pose => "`pose`, if known with its `velocity`",
        Quantity::JointPosition => "`joint_position`, if known with its `velocity`",
        Quantity::Velocity => "`velocity`",
        Quantity::Force => "`force`",
    };
    follows(task, ("a target", "is"), accepted)
}

/// Explains which fields the actions of a chunk have.
pub fn action_misfit(task: &TaskConfig) -> String {
    let accepted = |quantity: &Quantity| match quantity {
        Quantity::Pose => "`position` and `orientation` as its axes need, or both as `pose`",
        Quantity::JointPosition => "`joint_position`",
        Quantity::Velocity => "`velocity`",
        Quantity::Force => "`force`",
    };
    follows(task, ("an action", "has"), accepted)
}

/// Explains what targets or actions of a task have.
fn follows(task: &TaskConfig, (what, verb): (&str, &str), accepted: impl Fn(&Quantity) -> &'static str) -> String {
    let name = &task.name;
    match task.quantities().iter().map(accepted).collect::<Vec<_>>().as_slice() {
        [] => format!(
            "task `{name}` follows no target, because it has bounds, the target `mid_range` or the law `look_at`"
        ),
        accepted => format!("{what} of task `{name}` {verb} {}", accepted.join(", or ")),
    }
}

/// Reads one number per row of a task.
pub fn rows(values: &[f64], task: &TaskConfig, pointer: &str) -> Result<Vec<f64>> {
    let (given, expected, name) = (values.len(), task.rows.len(), &task.name);
    let detail = format_args!("{given} numbers for {expected} rows of task `{name}`; give one per row");
    check(given == expected, pointer, detail)?;
    numbers(values, pointer)
}

/// Reads a pose that has what the axes of the task need.
pub fn read_pose(pose: &wire::StreamedPose, task: &TaskConfig) -> Result<StreamedValue> {
    let has_axis = |is_linear: bool| match &task.rows {
        TaskRows::Tool(rows) => rows.axes.axes().iter().any(|axis| (axis.index() < 3) == is_linear),
        _ => false,
    };
    for (field, is_given, is_linear) in
        [("position", pose.position.is_some(), true), ("orientation", pose.orientation.is_some(), false)]
    {
        let (name, kind) = (&task.name, if is_linear { "a linear" } else { "an angular" });
        let detail = format_args!("task `{name}` has {kind} axis and needs the `{field}`");
        check(is_given || !has_axis(is_linear), "", detail)?;
    }
    pose.position.map_or(Ok(()), |position| check_numbers(&position, "/position"))?;
    let orientation = pose.orientation.map(|wire::Orientation { w, x, y, z }| {
        let pose = pose_of([0.0; 3], [w, x, y, z]).at("/orientation")?;
        Ok(UnitQuaternion::from_rotation_matrix(&pose.rotation))
    });
    Ok(StreamedValue::Pose { position: pose.position.map(Vector3::from), orientation: orientation.transpose()? })
}

/// Reads one position per joint of the task.
pub fn joint_positions(given: &JointVector, task: &TaskConfig, robot: &RobotModel) -> Result<Vec<f64>> {
    let field = "/joint_position";
    let named = match given {
        JointVector::Ordered(values) => return rows(values, task, field),
        JointVector::Named(named) => named,
    };
    let names: Vec<&str> = task.rows.joints().iter().map(|&joint| robot.joints()[joint].name.as_str()).collect();
    let unknown = |name: &str| format!("task `{}` has no joint `{name}`; its joints: {}", task.name, names.join(", "));
    by_name(named, &names, field, unknown, |name| format!("the position of joint `{name}` is missing"))
}
