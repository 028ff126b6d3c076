//! Paths of fields in a scenario: `controller.tasks.0.law.inertia`, `contacts.*.stiffness`.

use serde_json::Value;

/// Abbreviations and the paths that they stand for.
const ABBREVIATIONS: [(&str, &str); 5] = [
    ("environment.", "contacts.*."),
    ("loop.", "velocity_loop."),
    ("method", "controller.method"),
    ("solver", "controller.solver"),
    ("limits", "controller.limits"),
];

/// Sets every field that matches the path. The error of an unknown path lists the known names.
pub fn set(scenario: &mut Value, path: &str, value: &Value) -> Result<(), String> {
    let path = expand(path);
    let steps: Vec<&str> = path.split('.').collect();
    descend(scenario, &steps, value).map_err(|problem| format!("`{path}` {problem}"))
}

/// Returns whether two paths lead to the same field, or one to a part of what the other sets.
pub fn overlap(a: &str, b: &str) -> bool {
    let (a, b) = (expand(a), expand(b));
    a.split('.').zip(b.split('.')).all(|(a, b)| a == b || a == "*" || b == "*")
}

fn expand(path: &str) -> String {
    let short = ABBREVIATIONS.iter().find(|(short, _)| match short.strip_suffix('.') {
        Some(_) => path.starts_with(short),
        None => path == *short,
    });
    short.map_or_else(|| path.to_owned(), |(short, long)| path.replacen(short, long, 1))
}

fn descend(place: &mut Value, steps: &[&str], value: &Value) -> Result<(), String> {
    let Some((step, rest)) = steps.split_first() else {
        *place = value.clone();
        return Ok(());
    };
    match place {
        Value::Array(items) if *step == "*" => {
            if items.is_empty() {
                return Err("is a path in an empty list".to_owned());
            }
            items.iter_mut().try_for_each(|item| descend(item, rest, value))
        }
        Value::Array(items) => {
            let count = items.len();
            let item = step.parse().ok().and_then(|i: usize| items.get_mut(i));
            descend(
                item.ok_or_else(|| {
                    format!("has no item `{step}`; the list has {count} items, from 0; `*` selects all")
                })?,
                rest,
                value,
            )
        }
        // The last field of a path may be missing. Unknown fields are rejected when the scenario is parsed.
        Value::Object(fields) if rest.is_empty() => {
            fields.insert((*step).to_owned(), value.clone());
            Ok(())
        }
        Value::Object(fields) => {
            let known = fields.keys().cloned().collect::<Vec<_>>().join(", ");
            descend(
                fields.get_mut(*step).ok_or_else(|| format!("has no field `{step}`; the fields are {known}"))?,
                rest,
                value,
            )
        }
        _ => Err(format!("has `{step}` after a value that has no fields")),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn abbreviations_select_the_same_fields_as_full_paths() {
        let scenario =
            || json!({"contacts": [{"stiffness": 1}, {"stiffness": 2}], "velocity_loop": {}, "controller": {}});
        let changed = |path: &str, value: Value| {
            let mut scenario = scenario();
            set(&mut scenario, path, &value).map(|()| scenario)
        };
        let stiff = changed("environment.stiffness", json!(7)).unwrap();
        assert_eq!(stiff, changed("contacts.*.stiffness", json!(7)).unwrap());
        assert_eq!(stiff["contacts"], json!([{"stiffness": 7}, {"stiffness": 7}]));
        assert_eq!(changed("contacts.1.stiffness", json!(7)).unwrap()["contacts"][0]["stiffness"], 1);
        assert_eq!(changed("loop.lag_s", json!(0.1)).unwrap()["velocity_loop"]["lag_s"], 0.1);
        assert_eq!(changed("method", json!("qp")).unwrap()["controller"]["method"], "qp");
        assert!(changed("contacts.2.stiffness", json!(1)).unwrap_err().contains("no item `2`; the list has 2 items"));
        assert!(changed("wall.stiffness", json!(1)).unwrap_err().contains("no field `wall`"));
    }
}
