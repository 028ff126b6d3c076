//! Changes of the controller of an interactive run.

use revprio_api::wire;
use serde_json::Value;

use crate::convert;
use crate::error::{ApiError, escape_pointer};
use crate::robots::Robots;

/// Returns the controller that a command selects; `None` if the command changes none. The new controller continues from
/// the memory of the `current` one.
pub fn changed_controller(
    command: &wire::SimulationControl,
    current: &wire::Controller,
    robots: &Robots,
) -> Result<Option<wire::Controller>, ApiError> {
    if command.controller.is_none() && command.method.is_none() && command.solver.is_none() {
        return Ok(None);
    }
    let mut new = command.controller.clone().unwrap_or_else(|| current.clone());
    new.method = command.method.unwrap_or(new.method);
    new.solver = command.solver.unwrap_or(new.solver);
    convert::controller(&new, robots).map_err(|error| error.inside("/controller"))?;
    match difference(&as_value(&with_allowed_changes(current, &new))?, &as_value(&new)?) {
        None => Ok(Some(new)),
        Some(pointer) => Err(ApiError::invalid(
            format!("/controller{pointer}"),
            "cannot change during the run, because the command would jump; start another run",
        )),
    }
}

/// Returns the current controller with the allowed changes of the new one: method, solver, and parameters of laws that
/// read the wrench.
fn with_allowed_changes(current: &wire::Controller, new: &wire::Controller) -> wire::Controller {
    let mut changed = wire::Controller { method: new.method, solver: new.solver, why: new.why, ..current.clone() };
    for (task, new) in changed.tasks.iter_mut().zip(&new.tasks) {
        if let (Some(law), Some(new)) = (&mut task.law, &new.law)
            && std::mem::discriminant(law) == std::mem::discriminant(new)
            && law.reads_wrench()
        {
            law.clone_from(new);
        }
    }
    changed
}

fn as_value(controller: &wire::Controller) -> Result<Value, ApiError> {
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
