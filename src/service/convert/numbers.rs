//! Numbers, lists of numbers, joints.

use revprio_api::wire::{self, JointVector};
use revprio_core::law::{VelocityBounds, VelocityBoundsError};
use revprio_core::limits::{VelocityBox, VelocityBoxError};
use revprio_core::linalg::{Damping, Vector};
use revprio_robot::RobotModel;

use crate::service::error::{ApiError, escape_pointer};

/// Maximum number of joints. It is enough for several humanoid robots in one problem.
pub const MAX_JOINTS: usize = 128;

/// Maximum magnitude of a number in a request. It is far above any quantity of an arm, and its square does not overflow.
pub const MAX_MAGNITUDE: f64 = 1e9;

/// Minimum inertia of a law, kg on linear axes and kg·m² on angular axes. A fingertip has more. With much less, the command
/// would jump at the first newton.
pub const MIN_INERTIA: f64 = 1e-6;

/// Checks the inertia of a law.
pub fn inertia(value: f64, pointer: &str) -> Result<f64, ApiError> {
    if (MIN_INERTIA..=MAX_MAGNITUDE).contains(&value) {
        return Ok(value);
    }
    let detail =
        format!("{value:e} is out of range; give an inertia from {MIN_INERTIA:e} to {MAX_MAGNITUDE:e} kg or kg·m²");
    Err(ApiError::invalid(pointer, detail))
}

/// Checks a number.
pub fn number(value: f64, pointer: &str) -> Result<f64, ApiError> {
    if value.abs() <= MAX_MAGNITUDE {
        Ok(value)
    } else {
        Err(ApiError::invalid(pointer, format!("{value:e} is out of range; give a number from -1e9 to 1e9")))
    }
}

/// Checks a number that must not be negative.
pub fn not_negative(value: f64, pointer: &str) -> Result<f64, ApiError> {
    if value < 0.0 {
        return Err(ApiError::invalid(pointer, format!("{value} is out of range; it must not be negative")));
    }
    number(value, pointer)
}

/// Checks a list of numbers.
pub fn numbers(values: &[f64], pointer: &str) -> Result<Vec<f64>, ApiError> {
    check_numbers(values, pointer).map(|()| values.to_vec())
}

/// Checks a list of numbers without copying it.
pub fn check_numbers(values: &[f64], pointer: &str) -> Result<(), ApiError> {
    match values.iter().position(|value| !(value.abs() <= MAX_MAGNITUDE)) {
        Some(i) => number(values[i], &format!("{pointer}/{i}")).map(drop),
        None => Ok(()),
    }
}

/// Checks a list with one number per joint.
pub fn joint_list(values: &[f64], joints: usize, pointer: &str) -> Result<Vec<f64>, ApiError> {
    if values.len() != joints {
        return Err(ApiError::invalid(
            pointer,
            format!("{} numbers for {joints} joints; give one per joint", values.len()),
        ));
    }
    numbers(values, pointer)
}

/// Reads one number per joint of the robot, in its joint order.
pub fn joint_vector(vector: &JointVector, robot: &RobotModel, pointer: &str) -> Result<Vec<f64>, ApiError> {
    match vector {
        JointVector::Ordered(values) => joint_list(values, robot.joint_count(), pointer),
        JointVector::Named(values) => by_name(values, robot, pointer),
    }
}

fn by_name(values: &[(String, f64)], robot: &RobotModel, pointer: &str) -> Result<Vec<f64>, ApiError> {
    let joints = robot.joints();
    if let Some((name, _)) = values.iter().find(|(name, _)| joints.iter().all(|joint| joint.name != *name)) {
        return Err(ApiError::invalid(
            format!("{pointer}/{}", escape_pointer(name)),
            format!("`{}` has no joint `{name}`; its joints are {}", robot.name(), joint_names(robot)),
        ));
    }
    let value_of = |joint: &revprio_robot::Joint| match values.iter().find(|(name, _)| *name == joint.name) {
        Some((name, value)) => {
            number(*value, "").map_err(|error| error.inside(&format!("{pointer}/{}", escape_pointer(name))))
        }
        None => Err(ApiError::invalid(pointer, format!("joint `{}` is missing; give all joints", joint.name))),
    };
    joints.iter().map(value_of).collect()
}

fn joint_names(robot: &RobotModel) -> String {
    robot.joints().iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Reads one number per joint. Without a robot, the vector must be a list.
pub fn joint_vector_of(
    vector: &JointVector,
    robot: Option<&RobotModel>,
    joints: usize,
    pointer: &str,
) -> Result<Vector, ApiError> {
    match (vector, robot) {
        (vector, Some(robot)) => joint_vector(vector, robot, pointer).map(Vector::from_vec),
        (JointVector::Ordered(values), None) => joint_list(values, joints, pointer).map(Vector::from_vec),
        (JointVector::Named(_), None) => {
            Err(ApiError::invalid(pointer, "joints have names only with a `robot`; give a list instead"))
        }
    }
}

/// Reads the damping law at `/damping`.
pub fn damping(damping: Option<wire::Damping>) -> Result<Option<Damping>, ApiError> {
    let Some(wire::Damping { threshold, max_factor }) = damping else { return Ok(None) };
    number(threshold, "/damping/threshold")?;
    number(max_factor, "/damping/max_factor")?;
    match Damping::new(threshold, max_factor) {
        Some(damping) => Ok(Some(damping)),
        None => {
            Err(ApiError::invalid("/damping", "`threshold` must be positive and `max_factor` must not be negative"))
        }
    }
}

/// Reads the box of joint velocities at `/limits`.
pub fn velocity_box(lower: &[f64], upper: &[f64], joints: usize) -> Result<VelocityBox, ApiError> {
    let lower = joint_list(lower, joints, "/limits/lower")?;
    let upper = joint_list(upper, joints, "/limits/upper")?;
    VelocityBox::new(&lower, &upper).map_err(|error| match error {
        VelocityBoxError::Empty { joint, .. } => ApiError::invalid(format!("/limits/lower/{joint}"), error),
        VelocityBoxError::Size { .. } => ApiError::invalid("/limits", error),
    })
}

/// Reads the bounds of a task of `rows` rows. Returns `None` if it has none.
pub fn velocity_bounds(
    lower: Option<&[Option<f64>]>,
    upper: Option<&[Option<f64>]>,
    rows: usize,
) -> Result<Option<VelocityBounds>, ApiError> {
    if lower.is_none() && upper.is_none() {
        return Ok(None);
    }
    let lower = row_bounds(lower, rows, f64::NEG_INFINITY, "/lower")?;
    let upper = row_bounds(upper, rows, f64::INFINITY, "/upper")?;
    VelocityBounds::new(lower, upper).map(Some).map_err(|error| match error {
        VelocityBoundsError::Empty { row, .. } => ApiError::invalid(format!("/lower/{row}"), error),
        VelocityBoundsError::Size { .. } => ApiError::invalid("/lower", error),
    })
}

/// Reads one bound per row. `none` stands for no bound.
fn row_bounds(bounds: Option<&[Option<f64>]>, rows: usize, none: f64, pointer: &str) -> Result<Vec<f64>, ApiError> {
    let Some(bounds) = bounds else { return Ok(vec![none; rows]) };
    if bounds.len() != rows {
        let detail = format!("{} bounds for {rows} rows; give one per row, `null` for no bound", bounds.len());
        return Err(ApiError::invalid(pointer, detail));
    }
    let read = |(row, bound): (usize, &Option<f64>)| match bound {
        Some(bound) => number(*bound, "").map_err(|error| error.inside(&format!("{pointer}/{row}"))),
        None => Ok(none),
    };
    bounds.iter().enumerate().map(read).collect()
}
