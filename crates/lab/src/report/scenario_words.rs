//! A scenario in words, made from its fields; a field that has no sentence of its own is listed by its name.

use revprio_api::wire;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::simulator::Scenario;

/// Sentences that say what is run: arm, contacts, tasks, limits.
#[must_use]
pub fn of_scenario(scenario: &Scenario, robot: &wire::Robot) -> Vec<String> {
    let mut sentences = vec![start(scenario, robot)];
    sentences.extend(scenario.contacts.iter().map(contact));
    sentences.push(velocity_loop(scenario));
    let tasks = scenario.controller.tasks.iter().enumerate();
    sentences.extend(tasks.map(|(k, of_task)| task(k, of_task)));
    sentences.extend(controller(&scenario.controller));
    let told = [
        "name",
        "description",
        "expectation",
        "duration_s",
        "start_joint_position",
        "velocity_loop",
        "contacts",
        "controller",
    ];
    let fields = object(scenario);
    sentences.extend(rest(&fields, &told).map(|rest| format!("Further: {rest}.")));
    let expectation = fields.get("expectation").and_then(Value::as_str).filter(|text| !text.is_empty());
    sentences.extend(expectation.map(|text| format!("Expected: {}.", text.trim_end_matches('.'))));
    sentences.push("All in m, rad, s, N, N·m, kg and their products.".to_owned());
    sentences
}

fn start(scenario: &Scenario, robot: &wire::Robot) -> String {
    let posture = scenario.start_joint_position.iter().map(|q| number(*q)).collect::<Vec<_>>().join(", ");
    format!(
        "{}. The arm, {} ({} joints), starts at rest from q = ({posture}) and is commanded every {} ms for {} s.",
        scenario.description.trim_end_matches('.'),
        robot.name,
        robot.joints.len(),
        number(1e3 * scenario.period_s()),
        number(scenario.duration_s)
    )
}

fn contact(contact: &impl Serialize) -> String {
    let fields = object(contact);
    let text = |key: &str| fields.get(key).and_then(Value::as_str).unwrap_or_default().replace('_', " ");
    let offset = fields.get("offset_m").and_then(Value::as_f64).unwrap_or(0.0);
    let place = if offset == 0.0 {
        "where the tool starts".to_owned()
    } else {
        format!("{} mm from where the tool starts", number(1e3 * offset))
    };
    let more = rest(&fields, &["axis", "kind", "offset_m"]).map(|rest| format!(": {rest}")).unwrap_or_default();
    let along = fields.get("axis").and_then(Value::as_str).map(|axis| format!(" along {axis}")).unwrap_or_default();
    format!("The tool meets a {}{along}, {place}{more}.", text("kind"))
}

fn velocity_loop(scenario: &Scenario) -> String {
    let fields = object(&scenario.velocity_loop);
    match rest(&fields, &[]) {
        None => "The joints move exactly as commanded.".to_owned(),
        Some(fields) => format!("The joints follow their commands with {fields}."),
    }
}

fn task(k: usize, task: &wire::ControllerTask) -> String {
    let fields = object(task);
    let law = fields.get("law").and_then(Value::as_object).cloned().unwrap_or_default();
    let kind = law.get("kind").and_then(Value::as_str).unwrap_or_default();
    let axes = fields.get("axes").map(|axes| format!(" on {}", value(axes))).unwrap_or_default();
    let priority = if k == 0 { ", the highest priority" } else { "" };
    let parameters = in_order(&law, &["inertia", "damping", "stiffness", "gain", "position_controlled"])
        .map(|rest| format!(": {rest}"))
        .unwrap_or_default();
    let more = rest(&fields, &["name", "axes", "law"]).map(|rest| format!("; {rest}")).unwrap_or_default();
    format!("Task {}{priority}, {}: {kind} law{axes}{parameters}{more}.", k + 1, task.name)
}

fn controller(controller: &wire::Controller) -> Option<String> {
    let told = ["robot", "period_s", "method", "solver", "tasks"];
    rest(&object(controller), &told).map(|rest| format!("Controller: {rest}."))
}

/// The fields of a law: these first, as far as it has them.
fn in_order(law: &Map<String, Value>, first: &[&str]) -> Option<String> {
    let leading = first.iter().filter_map(|key| Some(named(key, law.get(*key)?)));
    let told: Vec<&str> = first.iter().copied().chain(["kind"]).collect();
    let texts: Vec<String> = leading.chain(rest(law, &told)).collect();
    (!texts.is_empty()).then(|| texts.join(", "))
}

fn object(of: &impl Serialize) -> Map<String, Value> {
    match serde_json::to_value(of) {
        Ok(Value::Object(fields)) => fields,
        _ => Map::new(),
    }
}

/// The fields that are not told yet, as `name value`; those that say nothing are left out.
fn rest(fields: &Map<String, Value>, told: &[&str]) -> Option<String> {
    let left = fields.iter().filter(|(key, value)| !told.contains(&key.as_str()) && says_something(key, value));
    let texts: Vec<_> = left.map(|(key, field)| named(key, field)).collect();
    (!texts.is_empty()).then(|| texts.join(", "))
}

/// Zeros, empty lists and the defaults of words say nothing.
fn says_something(key: &str, field: &Value) -> bool {
    match field {
        Value::Null => key == "damping",
        Value::Bool(set) => *set,
        Value::Number(number) => number.as_f64() != Some(0.0),
        Value::String(word) => !matches!(word.as_str(), "base" | "initial" | "on_environment"),
        Value::Array(items) => !items.is_empty(),
        Value::Object(fields) => !fields.is_empty(),
    }
}

/// Endings of names that are units.
const UNITS: [(&str, &str); 9] = [
    ("_rad_s2", "rad/s²"),
    ("_rad_s", "rad/s"),
    ("_per_s", "1/s"),
    ("_m_s", "m/s"),
    ("_rad", "rad"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
    ("_hz", "Hz"),
];

fn named(key: &str, field: &Value) -> String {
    let unit = UNITS.iter().find_map(|(ending, unit)| Some((key.strip_suffix(ending)?, *unit)));
    let (name, unit) = unit.unwrap_or((key, ""));
    let text = format!("{} {}", name.replace('_', " "), value(field));
    if unit.is_empty() { text } else { format!("{text} {unit}") }
}

fn value(field: &Value) -> String {
    match field {
        Value::Null => "none".to_owned(),
        Value::Bool(set) => if *set { "yes" } else { "no" }.to_owned(),
        Value::Number(n) => number(n.as_f64().unwrap_or(f64::NAN)),
        Value::String(word) => word.replace('_', " "),
        Value::Array(items) => match items.as_slice() {
            [first, rest @ ..] if rest.iter().all(|item| item == first) => value(first),
            items => format!("({})", items.iter().map(value).collect::<Vec<_>>().join(", ")),
        },
        Value::Object(fields) => match fields.get("kind").and_then(Value::as_str) {
            Some("constant") => fields.get("value").map(value).unwrap_or_default(),
            Some(kind) => format!("{} ({})", kind.replace('_', " "), rest(fields, &["kind"]).unwrap_or_default()),
            None => format!("({})", rest(fields, &[]).unwrap_or_default()),
        },
    }
}

/// At most six significant digits, without trailing zeros.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    let text = match rounded.abs() {
        0.0 => "0".to_owned(),
        size if (1e-4..1e5).contains(&size) => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sentences(change: impl FnOnce(&mut Scenario)) -> String {
        let mut scenario = Scenario::find("stiff_wall").unwrap();
        change(&mut scenario);
        let robot = wire::Robot {
            name: "sawyer_dh".to_owned(),
            description: String::new(),
            source: wire::RobotSource::DenavitHartenberg,
            joints: Vec::new(),
        };
        of_scenario(&scenario, &robot).join("\n")
    }

    #[test]
    fn arm_wall_tasks_and_limits_are_told_with_their_numbers() {
        let words = sentences(|_| ());
        for part in [
            "starts at rest from q = (2.9, −0.4, 3, 2.1, 3, −0.6, 0.2) and is commanded every 1 ms for 5 s.",
            "The tool meets a wall along x, 50 mm from where the tool starts: stiffness 1e5.",
            "The joints move exactly as commanded.",
            "Task 1, the highest priority, push x: hybrid law on x: ",
            "target force 30",
            "limits position velocity",
        ] {
            assert!(words.contains(part), "`{part}` is not in\n{words}");
        }
    }

    #[test]
    fn what_is_changed_is_told() {
        let words = sentences(|scenario| scenario.velocity_loop.lag_s = 0.005);
        assert!(words.contains("The joints follow their commands with lag 0.005 s."), "{words}");
        let words = sentences(|scenario| scenario.controller.damping = None);
        assert!(words.contains("damping none"), "{words}");
    }
}
