//! Numbers, lists of numbers, joints.

use std::ops::RangeInclusive;

use revprio_api::wire::{self, JointVector};
use revprio_core::law::{VelocityBounds, VelocityBoundsError};
use revprio_core::limits::{VelocityBox, VelocityBoxError};
use revprio_core::linalg::{Damping, Vector};
use revprio_lab::number::Exact;
use revprio_robot::RobotModel;

use super::checks::{Inside, Missing, Result, check, each};
use crate::error::{ApiError, escape_pointer};

/// Maximum magnitude of a number in a request. It is far above any quantity of an arm, and its square does not overflow.
pub const MAX_MAGNITUDE: f64 = 1e9;

/// Maximum magnitude of a time, s: the year 2286 on the clock of Unix, which is then exact to 2 µs.
pub const MAX_TIME_S: f64 = 1e10;

/// Minimum inertia of a law, kg on linear axes and kg·m² on angular axes. A fingertip has more. With much less, the command
/// would jump at the first newton.
pub const MIN_INERTIA: f64 = 1e-6;

/// Checks the inertia of a law.
pub fn inertia(value: f64, pointer: &str) -> Result<f64> {
    let range = format_args!("give an inertia from {MIN_INERTIA:e} to {MAX_MAGNITUDE:e} kg or kg·m²");
    between(value, MIN_INERTIA..=MAX_MAGNITUDE, pointer, format_args!("{} is out of range; {range}", Exact(value)))
}

/// Checks a number that must be in a range; `detail` says why not, with the range.
pub fn between(value: f64, range: RangeInclusive<f64>, pointer: &str, detail: impl std::fmt::Display) -> Result<f64> {
    check(range.contains(&value), pointer, detail).map(|()| value)
}

/// Checks a number.
pub fn number(value: f64, pointer: &str) -> Result<f64> {
    let detail = format_args!("{} is out of range; give a number from -1e9 to 1e9", Exact(value));
    between(value, -MAX_MAGNITUDE..=MAX_MAGNITUDE, pointer, detail)
}

/// Maximum magnitude of what a law remembers. Sums of squares of the largest forces that a state may have are smaller.
pub const MAX_REMEMBERED: f64 = 1e24;

/// Checks a number that a law remembers.
pub fn remembered(value: f64, pointer: &str) -> Result<f64> {
    let detail = format_args!("{value:e} is out of range; send the memory of the last answer back unchanged");
    between(value, -MAX_REMEMBERED..=MAX_REMEMBERED, pointer, detail)
}

/// Checks numbers that a law remembers.
pub fn check_remembered(values: &[f64], pointer: &str) -> Result<()> {
    let is_wrong = |value: &f64| !(value.abs() <= MAX_REMEMBERED);
    let Some(i) = values.iter().position(is_wrong) else { return Ok(()) };
    remembered(values[i], "").map(drop).inside(&format!("{pointer}/{i}"))
}

/// Checks a time on the clock of a client, which may be that of Unix.
pub fn time(value: f64, pointer: &str) -> Result<f64> {
    let detail = format_args!(
        "{} is out of range; give seconds, from -1e10 to 1e10, not milliseconds or nanoseconds",
        Exact(value)
    );
    between(value, -MAX_TIME_S..=MAX_TIME_S, pointer, detail)
}

/// Checks a number that must not be negative.
pub fn not_negative(value: f64, pointer: &str) -> Result<f64> {
    check(!(value < 0.0), pointer, format_args!("{} is out of range; it must not be negative", Exact(value)))?;
    number(value, pointer)
}

/// Checks a list of numbers.
pub fn numbers<V: From<Vec<f64>>>(values: &[f64], pointer: &str) -> Result<V> {
    check_numbers(values, pointer).map(|()| values.to_vec().into())
}

/// Checks a list of numbers without copying it.
pub fn check_numbers(values: &[f64], pointer: &str) -> Result<()> {
    match values.iter().position(|value| !(value.abs() <= MAX_MAGNITUDE)) {
        Some(i) => number(values[i], "").map(drop).inside(&format!("{pointer}/{i}")),
        None => Ok(()),
    }
}

/// Checks a list with one number per joint.
pub fn joint_list<V: From<Vec<f64>>>(values: &[f64], joints: usize, pointer: &str) -> Result<V> {
    let given = values.len();
    check(given == joints, pointer, format_args!("{given} numbers for {joints} joints; give one per joint"))?;
    numbers(values, pointer)
}

/// Reads one number per joint of the robot, in its joint order.
pub fn joint_vector<V: From<Vec<f64>>>(vector: &JointVector, robot: &RobotModel, pointer: &str) -> Result<V> {
    let named = match vector {
        JointVector::Ordered(values) => return joint_list(values, robot.joint_count(), pointer),
        JointVector::Named(named) => named,
    };
    let names = joint_names(robot);
    let unknown = |name: &str| format!("`{}` has no joint `{name}`; its joints are {}", robot.name(), names.join(", "));
    by_name(named, &names, pointer, unknown, |name| format!("joint `{name}` is missing; give all joints"))
}

/// Reads one number for each of the names. `unknown` and `missing` describe the error about a name.
pub fn by_name<V: From<Vec<f64>>>(
    given: &[(String, f64)],
    names: &[&str],
    pointer: &str,
    unknown: impl Fn(&str) -> String,
    missing: impl Fn(&str) -> String,
) -> Result<V> {
    let place = |name: &str| format!("{pointer}/{}", escape_pointer(name));
    if let Some((name, _)) = given.iter().find(|(name, _)| !names.contains(&name.as_str())) {
        return Err(ApiError::invalid(place(name), unknown(name)));
    }
    let value = |name: &&str| match given.iter().find(|(given, _)| given == name) {
        Some((name, value)) => number(*value, "").map_err(|error| error.inside(&place(name))),
        None => Err(ApiError::invalid(pointer, missing(name))),
    };
    names.iter().map(value).collect::<Result<Vec<_>>>().map(V::from)
}

/// Returns the names of the joints, in joint order.
pub fn joint_names(robot: &RobotModel) -> Vec<&str> {
    robot.joints().iter().map(|joint| joint.name.as_str()).collect()
}

/// Returns the index of the joint with this name.
pub fn joint_index(robot: &RobotModel, name: &str) -> Option<usize> {
    robot.joints().iter().position(|joint| joint.name == name)
}

/// Reads one number per joint. Without a robot, the vector must be a list.
pub fn joint_vector_of(
    vector: &JointVector,
    robot: Option<&RobotModel>,
    joints: usize,
    pointer: &str,
) -> Result<Vector> {
    match (vector, robot) {
        (vector, Some(robot)) => joint_vector(vector, robot, pointer),
        (JointVector::Ordered(values), None) => joint_list(values, joints, pointer),
        (JointVector::Named(_), None) => {
            Err(ApiError::invalid(pointer, "joints have names only with a `robot`; give a list instead"))
        }
    }
}

/// Reads the damping law at `/damping`.
pub fn damping(damping: Option<wire::Damping>) -> Result<Option<Damping>> {
    let Some(wire::Damping { threshold, max_factor }) = damping else { return Ok(None) };
    number(threshold, "/damping/threshold")?;
    number(max_factor, "/damping/max_factor")?;
    let detail = "`threshold` must be positive and `max_factor` must not be negative";
    Damping::new(threshold, max_factor).or_invalid("/damping", detail).map(Some)
}

/// Reads the box of joint velocities at `/limits`.
pub fn velocity_box(lower: &[f64], upper: &[f64], joints: usize) -> Result<VelocityBox> {
    let lower: Vec<f64> = joint_list(lower, joints, "/limits/lower")?;
    let upper: Vec<f64> = joint_list(upper, joints, "/limits/upper")?;
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
) -> Result<Option<VelocityBounds>> {
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
fn row_bounds(bounds: Option<&[Option<f64>]>, rows: usize, none: f64, pointer: &str) -> Result<Vec<f64>> {
    let Some(bounds) = bounds else { return Ok(vec![none; rows]) };
    let given = bounds.len();
    let detail = format_args!("{given} bounds for {rows} rows; give one per row, `null` for no bound");
    check(given == rows, pointer, detail)?;
    each(pointer, bounds, |_, bound| bound.map_or(Ok(none), |bound| number(bound, "")))
}
