//! Places in a scenario: `controller.tasks.0.law.inertia`, `contacts.*.stiffness`.

use serde_json::Value;

/// Short names and what they stand for.
const SHORT: [(&str, &str); 5] = [
    ("environment.", "contacts.*."),
    ("loop.", "velocity_loop."),
    ("method", "controller.method"),
    ("solver", "controller.solver"),
    ("limits", "controller.limits"),
];

/// Puts a value at every place that the path names; says what is there instead if it names none.
pub fn put(scenario: &mut Value, path: &str, value: &Value) -> Result<(), String> {
    let path = long(path);
    let steps: Vec<&str> = path.split('.').collect();
    descend(scenario, &steps, value).map_err(|problem| format!("`{path}` {problem}"))
}

fn long(path: &str) -> String {
    let short = SHORT.iter().find(|(short, _)| match short.strip_suffix('.') {
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
                return Err("is in an empty list".to_owned());
            }
            items.iter_mut().try_for_each(|item| descend(item, rest, value))
        }
        Value::Array(items) => {
            let count = items.len();
            let item = step.parse().ok().and_then(|i: usize| items.get_mut(i));
            descend(
                item.ok_or_else(|| format!("has no item `{step}`; there are {count}, from 0, or all: `*`"))?,
                rest,
                value,
            )
        }
        // Fields that are left out are those at the end of the path; unknown ones are refused when it is read.
        Value::Object(fields) if rest.is_empty() => {
            fields.insert((*step).to_owned(), value.clone());
            Ok(())
        }
        Value::Object(fields) => {
            let known = fields.keys().cloned().collect::<Vec<_>>().join(", ");
            descend(
                fields.get_mut(*step).ok_or_else(|| format!("has no part `{step}`; there are {known}"))?,
                rest,
                value,
            )
        }
        _ => Err(format!("goes on with `{step}` below a plain value")),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn short_and_long_paths_lead_to_the_same_places() {
        let scenario =
            || json!({"contacts": [{"stiffness": 1}, {"stiffness": 2}], "velocity_loop": {}, "controller": {}});
        let changed = |path: &str, value: Value| {
            let mut scenario = scenario();
            put(&mut scenario, path, &value).map(|()| scenario)
        };
        let stiff = changed("environment.stiffness", json!(7)).unwrap();
        assert_eq!(stiff, changed("contacts.*.stiffness", json!(7)).unwrap());
        assert_eq!(stiff["contacts"], json!([{"stiffness": 7}, {"stiffness": 7}]));
        assert_eq!(changed("contacts.1.stiffness", json!(7)).unwrap()["contacts"][0]["stiffness"], 1);
        assert_eq!(changed("loop.lag_s", json!(0.1)).unwrap()["velocity_loop"]["lag_s"], 0.1);
        assert_eq!(changed("method", json!("qp")).unwrap()["controller"]["method"], "qp");
        assert!(changed("contacts.2.stiffness", json!(1)).unwrap_err().contains("no item `2`; there are 2"));
        assert!(changed("wall.stiffness", json!(1)).unwrap_err().contains("no part `wall`"));
    }
}
