//! `POST /v1/simulations/{id}/control`.

use revprio_api::wire;
use revprio_core::controller::Controller;
use serde_json::Value;

use super::checks::{Inside, Result, check};
use super::controller::controller;
use super::numbers::{between, check_numbers};
use super::targets::targets;
use crate::service::error::{ApiError, escape_pointer};
use crate::service::robots::Robots;

/// Minimum speed of an interactive run, simulated seconds per second.
pub const MIN_SPEED: f64 = 0.001;
/// Maximum speed of an interactive run, simulated seconds per second.
pub const MAX_SPEED: f64 = 1000.0;

/// Maximum number of control periods in one step of an interactive run.
pub const MAX_STEPS: usize = 100_000;

/// Checks a speed.
fn check_speed(speed: f64, pointer: &str) -> Result<()> {
    let detail = format_args!("{speed} is out of range; give a speed from {MIN_SPEED} to {MAX_SPEED}");
    between(speed, MIN_SPEED..=MAX_SPEED, pointer, detail).map(drop)
}

/// Checks the speed of an interactive run.
pub fn check_interactive(interactive: Option<&wire::Interactive>) -> Result<()> {
    interactive.map_or(Ok(()), |interactive| check_speed(interactive.speed, "/interactive/speed"))
}

/// Checks the fields of a command to a run with this controller.
pub fn check_control(command: &wire::SimulationControl, controller: &Controller) -> Result<()> {
    command.speed.map_or(Ok(()), |speed| check_speed(speed, "/speed"))?;
    let is_possible = command.step.is_none_or(|step| (1..=MAX_STEPS as u64).contains(&step));
    check(is_possible, "/step", format_args!("give 1 to {MAX_STEPS} control periods"))?;
    let goes_on = command.step.is_some() && command.paused == Some(false);
    check(!goes_on, "/step", "a run pauses after a step; omit `paused`")?;
    if let Some((name, _)) = command.targets.iter().find(|(_, target)| target.time_s.is_some()) {
        let pointer = format!("/targets/{}/time_s", escape_pointer(name));
        return Err(ApiError::invalid(pointer, "omit it; the target belongs to the next state"));
    }
    targets(&command.targets, 0.0, controller)?;
    command.external_force.map_or(Ok(()), |force| check_numbers(&force, "/external_force"))
}

/// Returns the controller that a command selects; `None` if the command changes none. The new controller continues from
/// the memory of the `current` one.
pub fn changed_controller(
    command: &wire::SimulationControl,
    current: &wire::Controller,
    robots: &Robots,
) -> Result<Option<wire::Controller>> {
    if command.controller.is_none() && command.method.is_none() && command.solver.is_none() {
        return Ok(None);
    }
    let mut new = command.controller.clone().unwrap_or_else(|| current.clone());
    new.method = command.method.unwrap_or(new.method);
    new.solver = command.solver.unwrap_or(new.solver);
    controller(&new, robots).inside("/controller")?;
    match difference(&as_value(&with_allowed_changes(current, &new))?, &as_value(&new)?) {
        None => Ok(Some(new)),
        Some(pointer) => Err(ApiError::invalid(
            format!("/controller{pointer}"),
            "cannot change during the run, because the command would jump; start another run",
        )),
    }
}

/// Returns the current controller with the allowed changes of the new one: method, solver, and parameters of laws that
/// integrate.
fn with_allowed_changes(current: &wire::Controller, new: &wire::Controller) -> wire::Controller {
    let mut changed = wire::Controller { method: new.method, solver: new.solver, why: new.why, ..current.clone() };
    for (task, new) in changed.tasks.iter_mut().zip(&new.tasks) {
        if let (Some(law), Some(new)) = (&mut task.law, &new.law)
            && std::mem::discriminant(law) == std::mem::discriminant(new)
            && law.integrates()
        {
            law.clone_from(new);
        }
    }
    changed
}

fn as_value(controller: &wire::Controller) -> Result<Value> {
    serde_json::to_value(controller).map_err(|_| ApiError::internal())
}

/// Returns the JSON pointer to the first difference of two values.
fn difference(a: &Value, b: &Value) -> Option<String> {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            keys.map(|key| (key, a.get(key).unwrap_or(&Value::Null), b.get(key).unwrap_or(&Value::Null)))
                .find_map(|(key, a, b)| Some(format!("/{}{}", escape_pointer(key), difference(a, b)?)))
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).enumerate().find_map(|(i, (a, b))| Some(format!("/{i}{}", difference(a, b)?)))
        }
        _ => (a != b).then(String::new),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::difference;

    #[test]
    fn difference_points_to_the_first_different_value() {
        let a = json!({"a": [1, {"b/c": 2}], "d": 3});
        assert_eq!(difference(&a, &a), None);
        assert_eq!(difference(&a, &json!({"a": [1, {"b/c": 4}], "d": 3})).as_deref(), Some("/a/1/b~1c"));
        assert_eq!(difference(&a, &json!({"a": [1], "d": 3})).as_deref(), Some("/a"));
        assert_eq!(difference(&json!({}), &json!({"e": 1})).as_deref(), Some("/e"));
    }
}
