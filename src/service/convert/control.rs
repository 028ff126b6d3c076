//! `POST /v1/simulations/{id}/control`.

use revprio_api::wire;
use revprio_core::controller::Controller;
use serde_json::Value;

use super::controller::controller;
use super::numbers::check_numbers;
use crate::service::error::{ApiError, escaped};
use crate::service::robots::Robots;

/// Slowest and fastest pace, simulated seconds per second.
pub const SLOWEST: f64 = 0.001;
/// See [`SLOWEST`].
pub const FASTEST: f64 = 1000.0;

/// Most periods of one step.
pub const MOST_STEPS: usize = 100_000;

/// Checks a pace; `pointer` is that of its speed.
fn speed(speed: f64, pointer: &str) -> Result<(), ApiError> {
    if (SLOWEST..=FASTEST).contains(&speed) {
        return Ok(());
    }
    Err(ApiError::invalid(pointer, format!("{speed} is out of range; speeds lie between {SLOWEST} and {FASTEST}")))
}

/// Checks how a run is to be paced.
pub fn interactive(interactive: Option<&wire::Interactive>) -> Result<(), ApiError> {
    interactive.map_or(Ok(()), |interactive| speed(interactive.speed, "/interactive/speed"))
}

/// Checks all numbers of an order.
pub fn control(order: &wire::SimulationControl) -> Result<(), ApiError> {
    order.speed.map_or(Ok(()), |asked| speed(asked, "/speed"))?;
    if order.step.is_some_and(|step| !(1..=MOST_STEPS as u64).contains(&step)) {
        return Err(ApiError::invalid("/step", format!("give 1 to {MOST_STEPS} control periods")));
    }
    if order.step.is_some() && order.paused == Some(false) {
        return Err(ApiError::invalid("/step", "a run pauses after a step; leave `paused` out"));
    }
    order.external_force.map_or(Ok(()), |force| check_numbers(&force, "/external_force"))
}

/// The controller that the order asks for, `None` if it asks for none; it continues from the memory of `now`.
pub fn changed_controller(
    order: &wire::SimulationControl,
    now: &wire::Controller,
    robots: &Robots,
) -> Result<Option<(wire::Controller, Controller)>, ApiError> {
    if order.controller.is_none() && order.method.is_none() && order.solver.is_none() {
        return Ok(None);
    }
    let mut asked = order.controller.clone().unwrap_or_else(|| now.clone());
    asked.method = order.method.unwrap_or(asked.method);
    asked.solver = order.solver.unwrap_or(asked.solver);
    let checked = controller(&asked, robots).map_err(|problem| problem.inside("/controller"))?;
    match difference(&as_value(&continued(now, &asked))?, &as_value(&asked)?) {
        None => Ok(Some((asked, checked))),
        Some(pointer) => Err(ApiError::invalid(
            format!("/controller{pointer}"),
            "cannot change while the run goes on: it would jump; start another run",
        )),
    }
}

/// The controller of now with what may change as it is asked for.
fn continued(now: &wire::Controller, asked: &wire::Controller) -> wire::Controller {
    let mut continued = wire::Controller { method: asked.method, solver: asked.solver, ..now.clone() };
    for (task, asked) in continued.tasks.iter_mut().zip(&asked.tasks) {
        let same_kind = std::mem::discriminant(&task.law) == std::mem::discriminant(&asked.law);
        if same_kind && task.law.integrates() {
            task.law = asked.law.clone();
        }
    }
    continued
}

fn as_value(controller: &wire::Controller) -> Result<Value, ApiError> {
    serde_json::to_value(controller).map_err(|_| ApiError::internal())
}

/// JSON pointer to the first place where two values differ.
fn difference(a: &Value, b: &Value) -> Option<String> {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            keys.map(|key| (key, a.get(key).unwrap_or(&Value::Null), b.get(key).unwrap_or(&Value::Null)))
                .find_map(|(key, a, b)| Some(format!("/{}{}", escaped(key), difference(a, b)?)))
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
    fn the_first_difference_is_named() {
        let a = json!({"a": [1, {"b/c": 2}], "d": 3});
        assert_eq!(difference(&a, &a), None);
        assert_eq!(difference(&a, &json!({"a": [1, {"b/c": 4}], "d": 3})).as_deref(), Some("/a/1/b~1c"));
        assert_eq!(difference(&a, &json!({"a": [1], "d": 3})).as_deref(), Some("/a"));
        assert_eq!(difference(&json!({}), &json!({"e": 1})).as_deref(), Some("/e"));
    }
}
