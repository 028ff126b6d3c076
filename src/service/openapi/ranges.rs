//! The ranges that the service enforces, from the constants with which it does.

use std::collections::BTreeSet;

use revprio_core::controller::MAX_DELAY_PERIODS;
use serde_json::{Value, json};

use super::schemas::{variants, visit};
use crate::service::convert::{
    FASTEST, LARGEST, LARGEST_SEQUENCE, LONGEST_PERIOD_S, LONGEST_STATED_DELAY, MOST_INEQUALITIES, MOST_JOINTS,
    MOST_POINTS, MOST_ROWS, MOST_STEPS, MOST_TASKS, SHORTEST_PERIOD_S, SLOWEST,
};
use crate::service::resolve::MOST_ITEMS;
use crate::service::robots::LONGEST_NAME;

/// What a field may hold.
enum Range {
    /// Numbers above zero.
    Positive,
    /// Numbers from zero on.
    NotNegative,
    /// Numbers.
    Between(f64, f64),
    /// Whole numbers from zero on.
    UpTo(usize),
    /// As many items.
    Items(usize, usize),
    /// As many items, each once.
    UniqueItems(usize, usize),
    /// Lists of so many items, each of so many.
    Rows([usize; 2], [usize; 2]),
}

use Range::{Between, Items, NotNegative, Positive, Rows, UniqueItems, UpTo};

/// As far as a component of a unit quaternion may be from zero.
const UNIT: f64 = 1.0 + revprio_robot::kinematics::UNIT_LENGTH_TOLERANCE;

/// Schemas with their fields, whether in the schema itself or in one of its alternatives.
const RANGES: &[(&str, &[(&str, Range)])] = &[
    ("BatchRequest", &[("items", Items(0, MOST_ITEMS))]),
    ("BatchAnswer", &[("items", Items(0, MOST_ITEMS))]),
    (
        "Controller",
        &[
            ("period_s", Between(SHORTEST_PERIOD_S, LONGEST_PERIOD_S)),
            ("tasks", Items(1, MOST_TASKS)),
            ("inequalities", Items(0, MOST_INEQUALITIES)),
        ],
    ),
    ("ControllerTask", &[("axes", UniqueItems(1, 6)), ("reference_point", Items(3, 3))]),
    ("Pose", &[("position", Items(3, 3))]),
    ("FramePose", &[("position", Items(3, 3)), ("rotation", Rows([3, 3], [3, 3]))]),
    ("Wrench", &[("force", Items(3, 3)), ("torque", Items(3, 3))]),
    (
        "ResolveRequest",
        &[
            ("period_s", Between(SHORTEST_PERIOD_S, LONGEST_PERIOD_S)),
            ("tasks", Items(1, MOST_ROWS)),
            ("inequalities", Items(0, MOST_INEQUALITIES)),
        ],
    ),
    (
        "ResolveTask",
        &[
            ("axes", UniqueItems(1, 6)),
            ("reference_point", Items(3, 3)),
            ("jacobian", Rows([1, MOST_ROWS], [1, MOST_JOINTS])),
            ("velocity", Items(1, MOST_ROWS)),
        ],
    ),
    ("Limits", &[("lower", Items(1, MOST_JOINTS)), ("upper", Items(1, MOST_JOINTS))]),
    (
        "Law",
        &[
            ("inertia", Positive),
            ("damping", NotNegative),
            ("stiffness", NotNegative),
            ("gain", NotNegative),
            ("joints", UniqueItems(1, MOST_JOINTS)),
        ],
    ),
    ("Profile", &[("duration_s", Between(1e-6, LARGEST)), ("points", Items(1, MOST_POINTS))]),
    ("Inequality", &[("coefficients", Items(1, MOST_JOINTS)), ("normal", Items(3, 3)), ("rate_per_s", Positive)]),
    ("Damping", &[("threshold", Positive), ("max_factor", NotNegative)]),
    ("NullSpaceMotion", &[("gain", NotNegative)]),
    (
        "Orientation",
        &[
            ("w", Between(-UNIT, UNIT)),
            ("x", Between(-UNIT, UNIT)),
            ("y", Between(-UNIT, UNIT)),
            ("z", Between(-UNIT, UNIT)),
        ],
    ),
    ("Environment", &[("lag_s", NotNegative), ("delay_periods", UpTo(LONGEST_STATED_DELAY))]),
    ("EnvironmentAxis", &[("stiffness", NotNegative), ("damping", NotNegative), ("inertia", NotNegative)]),
    (
        "StabilityRequest",
        &[
            ("inertia", Positive),
            ("damping", NotNegative),
            ("stiffness", NotNegative),
            ("period_s", Between(SHORTEST_PERIOD_S, LONGEST_PERIOD_S)),
            ("lag_s", NotNegative),
            ("delay_periods", UpTo(MAX_DELAY_PERIODS)),
        ],
    ),
    (
        "Memory",
        &[
            ("task_velocities", Items(0, MOST_TASKS)),
            ("last_command", Items(1, MOST_JOINTS)),
            ("active_set", Items(0, MOST_TASKS)),
        ],
    ),
    (
        "Scenario",
        &[
            ("duration_s", Positive),
            ("start_joint_position", Items(1, MOST_JOINTS)),
            ("contacts", Items(0, 100)),
            ("substeps", Between(1.0, 1000.0)),
        ],
    ),
    ("VelocityLoop", &[("lag_s", NotNegative), ("delay_periods", UpTo(10_000))]),
    (
        "Contact",
        &[("normal", Items(3, 3)), ("stiffness", NotNegative), ("damping", NotNegative), ("inertia", NotNegative)],
    ),
    ("Friction", &[("coulomb", NotNegative), ("viscous", NotNegative), ("sticking_speed_m_s", Positive)]),
    ("Sensors", &[("wrench_filter_s", NotNegative)]),
    ("Sensor", &[("noise", NotNegative), ("quantum", NotNegative)]),
    (
        "Faults",
        &[
            ("dropped", Between(0.0, 1.0)),
            ("late", Between(0.0, 1.0)),
            ("late_periods", UpTo(10_000)),
            ("repeated", Between(0.0, 1.0)),
            ("reordered", Between(0.0, 1.0)),
            ("outages", Items(0, 100)),
        ],
    ),
    ("Outage", &[("start_s", Positive), ("duration_s", NotNegative)]),
    ("TaskOutcome", &[("residual_norm", NotNegative), ("rank", UpTo(MOST_ROWS)), ("scale", Between(0.0, 1.0))]),
    ("SolverReport", &[("kkt_residual", NotNegative)]),
    ("Singularity", &[("smallest_singular_value", NotNegative), ("manipulability", NotNegative)]),
    ("ResolveAnswer", &[("elapsed_us", NotNegative), ("joint_limit_index", NotNegative)]),
    ("StepAnswer", &[("elapsed_us", NotNegative), ("joint_limit_index", NotNegative)]),
    (
        "StabilityAnswer",
        &[("spectral_radius", NotNegative), ("largest_lag_s", NotNegative), ("smallest_damping", NotNegative)],
    ),
    (
        "KinematicsAnswer",
        &[
            ("jacobian", Rows([6, 6], [1, MOST_JOINTS])),
            ("singular_values", NotNegative),
            ("manipulability", NotNegative),
        ],
    ),
    (
        "RobotJoint",
        &[
            ("velocity_limit", NotNegative),
            ("acceleration_limit", NotNegative),
            ("position_limit", Items(2, 2)),
            ("published_range", Items(2, 2)),
        ],
    ),
    ("Simulation", &[("progress", Between(0.0, 1.0))]),
    ("Interactive", &[("speed", Between(SLOWEST, FASTEST))]),
    (
        "SimulationControl",
        &[
            ("step", Between(1.0, MOST_STEPS as f64)),
            ("speed", Between(SLOWEST, FASTEST)),
            ("external_force", Items(3, 3)),
        ],
    ),
    ("Problem", &[("status", Between(400.0, 599.0))]),
];

/// Adds all ranges.
pub fn complete(document: &mut Value) {
    let asked = asked(document);
    let Some(schemas) = document["components"]["schemas"].as_object_mut() else { return };
    for (name, schema) in schemas.iter_mut() {
        visit(schema, &mut whole_numbers);
        if asked.contains(name) {
            visit(schema, &mut sensible_numbers);
        }
        if name.starts_with("PerAxis") {
            variants(schema).for_each(|variant| items(variant, 1, MOST_JOINTS));
        }
    }
    for (name, fields) in RANGES {
        let Some(schema) = schemas.get_mut(*name) else { continue };
        for (field, range) in *fields {
            apply(&mut schema["properties"][*field], range);
            variants(schema).for_each(|variant| apply(&mut variant["properties"][*field], range));
        }
    }
    tidy(schemas);
    let joints = &mut schemas["JointVector"]["oneOf"];
    items(&mut joints[0], 1, MOST_JOINTS);
    joints[1]["minProperties"] = json!(1);
    joints[1]["maxProperties"] = json!(MOST_JOINTS);
    let name = &mut schemas["RobotRegistration"]["properties"]["name"];
    name["pattern"] = json!(format!("^[A-Za-z0-9][A-Za-z0-9_.-]{{0,{}}}$", LONGEST_NAME - 1));
}

/// Names of the schemas that bodies of requests are made of.
fn asked(document: &Value) -> BTreeSet<String> {
    let operations = document["paths"].as_object().into_iter().flatten().filter_map(|(_, item)| item.as_object());
    let bodies = operations.flatten().map(|(_, operation)| operation["requestBody"].to_string());
    let mut waiting: Vec<String> = bodies.collect();
    let mut found = BTreeSet::new();
    while let Some(text) = waiting.pop() {
        for link in text.split("#/components/schemas/").skip(1) {
            let name = link.split('"').next().unwrap_or_default();
            if found.insert(name.to_owned()) {
                waiting.push(document["components"]["schemas"][name].to_string());
            }
        }
    }
    found
}

/// Whole numbers are counts, exact in the doubles of every client.
fn whole_numbers(schema: &mut Value) {
    if is(schema, "integer") {
        schema["minimum"] = json!(0);
        let most = if schema["format"] == "int32" { i32::MAX.unsigned_abs().into() } else { LARGEST_SEQUENCE };
        schema["maximum"] = json!(most);
    }
}

/// Numbers of requests are below what overflows when squared.
fn sensible_numbers(schema: &mut Value) {
    if is(schema, "number") {
        schema["minimum"] = json!(-LARGEST);
        schema["maximum"] = json!(LARGEST);
    }
}

fn is(schema: &Value, kind: &str) -> bool {
    schema["type"] == kind || schema["type"].as_array().is_some_and(|kinds| kinds.iter().any(|known| known == kind))
}

fn apply(schema: &mut Value, range: &Range) {
    if schema.is_null() {
        return;
    }
    match range {
        Positive => numbers(schema, &[("exclusiveMinimum", json!(0))]),
        NotNegative => numbers(schema, &[("minimum", json!(0))]),
        Between(least, most) => numbers(schema, &[("minimum", json!(least)), ("maximum", json!(most))]),
        UpTo(most) => numbers(schema, &[("minimum", json!(0)), ("maximum", json!(most))]),
        Items(least, most) => items(schema, *least, *most),
        UniqueItems(least, most) => {
            items(schema, *least, *most);
            schema["uniqueItems"] = json!(true);
        }
        Rows(rows, columns) => {
            items(schema, rows[0], rows[1]);
            items(&mut schema["items"], columns[0], columns[1]);
        }
    }
}

/// Bounds the numbers of a schema, of its items where it is a list, of both where it may be either.
fn numbers(schema: &mut Value, bounds: &[(&str, Value)]) {
    let either = schema["$ref"].as_str().is_some_and(|link| link.contains("/PerAxis"));
    if either || is(schema, "number") || is(schema, "integer") {
        for (key, bound) in bounds {
            if *key == "exclusiveMinimum" {
                schema.as_object_mut().map(|fields| fields.remove("minimum"));
            }
            schema[*key] = bound.clone();
        }
    }
    if either {
        schema["items"] = bounds.iter().map(|(key, bound)| ((*key).to_owned(), bound.clone())).collect();
    } else if is(schema, "array") {
        numbers(&mut schema["items"], bounds);
    }
}

fn items(schema: &mut Value, least: usize, most: usize) {
    if is(schema, "array") {
        schema["minItems"] = json!(least);
        schema["maxItems"] = json!(most);
    }
}

/// Looking for fields that a schema does not have leaves `null` behind.
fn tidy(schemas: &mut serde_json::Map<String, Value>) {
    for (_, schema) in schemas {
        visit(schema, &mut |schema| {
            if let Some(properties) = schema["properties"].as_object_mut() {
                properties.retain(|_, property| !property.is_null());
            }
            if let Some(fields) = schema.as_object_mut() {
                fields.retain(|key, value| !(value.is_null() || key == "properties" && value == &json!({})));
            }
        });
    }
}
