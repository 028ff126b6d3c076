//! The files of `api/examples` in the document.

use revprio_api::wire;
use serde_json::{Value, json};

use super::schemas::reference;

/// A request of an operation and its answer. The request is `None` if the operation has no body.
struct Example {
    path: &'static str,
    method: &'static str,
    name: &'static str,
    request: Option<&'static str>,
    answer: &'static str,
}

macro_rules! examples {
    (@request $name:literal) => { Some(include_str!(concat!("../../../api/examples/", $name, ".json"))) };
    (@request) => { None };
    ($($method:ident $path:literal $($request:literal)? => $answer:literal;)+) => {
        [$(Example {
            path: $path,
            method: stringify!($method),
            name: $answer,
            request: examples!(@request $($request)?),
            answer: include_str!(concat!("../../../api/examples/answers/", $answer, ".json")),
        }),+]
    };
}

const EXAMPLES: [Example; 43] = examples! {
    post "/v1/resolve" "resolve" => "resolve";
    post "/v1/resolve" "resolve_everything" => "resolve_everything";
    post "/v1/resolve" "resolve_limits" => "resolve_limits";
    post "/v1/resolve" "resolve_bounds" => "resolve_bounds";
    post "/v1/resolve" "resolve_closed_form" => "resolve_closed_form";
    post "/v1/resolve" "resolve_certificate" => "resolve_certificate";
    post "/v1/resolve" "resolve_link" => "resolve_link";
    post "/v1/resolve/batch" "batch" => "batch";
    post "/v1/step" "step" => "step";
    post "/v1/step" "step_inequality" => "step_inequality";
    post "/v1/step" "step_again" => "step_again";
    post "/v1/step" "step_targets" => "step_targets";
    post "/v1/step" "step_ahead" => "step_ahead";
    post "/v1/step" "step_chunk" => "step_chunk";
    post "/v1/step" "step_room" => "step_room";
    post "/v1/step" "step_straight" => "step_straight";
    post "/v1/controllers" "controller" => "controller";
    post "/v1/controllers" "controller_laws" => "controller_laws";
    post "/v1/controllers" "controller_room" => "controller_room";
    get "/v1/controllers" => "sessions";
    get "/v1/controllers/{id}" => "session";
    put "/v1/controllers/{id}" "controller_replaced" => "controller_replaced";
    post "/v1/controllers/{id}/step" "state" => "state";
    post "/v1/controllers/{id}/tare" "tare" => "tare";
    post "/v1/kinematics" "kinematics" => "kinematics";
    post "/v1/kinematics" "kinematics_link" => "kinematics_link";
    post "/v1/stability" "stability" => "stability";
    post "/v1/stability" "stability_impedance" => "stability_impedance";
    post "/v1/payload" "payload" => "payload";
    get "/v1/robots" => "robots";
    post "/v1/robots" "robot" => "robot";
    post "/v1/robots" "robot_two_arms" => "robot_two_arms";
    post "/v1/robots" "robot_shapes" => "robot_shapes";
    get "/v1/robots/{name}" => "robot_shown";
    get "/v1/scenarios" => "scenarios";
    get "/v1/scenarios/{name}" => "scenario";
    post "/v1/simulations" "simulation" => "simulation";
    post "/v1/simulations" "simulation_own" => "simulation_own";
    post "/v1/simulations" "simulation_world" => "simulation_world";
    post "/v1/simulations" "simulation_interactive" => "simulation_interactive";
    post "/v1/simulations/{id}/control" "control" => "control";
    post "/v1/simulations/{id}/control" "control_end" => "control_end";
    get "/v1/simulations/{id}" => "simulation_finished";
};

/// Example of a problem.
const PROBLEM: &str = include_str!("../../../api/examples/answers/problem.json");

/// A state of the session in the examples, and its answer.
const STATE: &str = include_str!("../../../api/examples/state.json");
const STATE_ANSWER: &str = include_str!("../../../api/examples/answers/state.json");

/// Example of a frame of an interactive simulation.
const LIVE_FRAME: &str = include_str!("../../../api/examples/answers/live_frame.json");

/// Answer to a step of an arm beside an obstacle.
const STEP_IN_A_ROOM: &str = include_str!("../../../api/examples/answers/step_room.json");

/// Adds the examples to their operations. Adds to each field its first value in an example.
pub fn complete(document: &mut Value) {
    // No profile of the examples has a start.
    document["components"]["schemas"]["Profile"]["oneOf"][1]["properties"]["start_time_s"]["examples"] = json!([2.0]);
    // No registration of the examples states one.
    let stated = &mut document["components"]["schemas"]["StatedLimits"]["properties"];
    stated["velocity_envelope"]["examples"] = json!([{"deceleration_limit": 6.0, "velocity_offset": 0.3}]);
    // No step of the examples has jerk limits that bind. The derive has no example for a field that is an object or null.
    let memory = &mut document["components"]["schemas"]["Memory"]["properties"];
    memory["jerk"]["examples"] = json!([{"acceleration": [0.1], "requested": [0.5]}]);
    memory["contacts"]["examples"] = json!([[{
        "state": "contact", "position": 0.012, "sensed_position": 0.012, "force": 29.9, "surface": 0.01,
        "contact_time_s": 0.4, "lack": 0.0, "hold_time_s": 0.3, "return_speed": 0.012, "spent_j": 0.02, "before_retreat": 0.012, "force_before_retreat": 30.1,
        "fault_position": 0.0, "stiffness": [15_300.0, 12_000.0, 130.0], "means": [0.011, 28.0],
        "sums": [1e-6, 0.012, 144.0, 80.0], "surface_motion": [0.01, 12_000.0, 0.0], "followed": [0.012, 29.9, 0.0, 0.1, 1e-7, 0.1, 1e-7, 0.2],
        "mean_target_force": 30.0, "swing": [1.0, 0.2, 0.3],
        "is_above": false, "unchanged": [29.9, 0.012, 0.0], "reading_change": 0.2, "reading_step": 0.01,
        "following": [0.012, 1e-5, 0.2, 0.001, 0.001, 0.0], "measured": measured_contact()
    }]]);
    let wrench = json!({"force": [0.0, 0.0, 14.9], "torque": [0.1, 0.0, 0.0]});
    let schemas = &mut document["components"]["schemas"];
    schemas["StepAnswer"]["properties"]["wrench"]["examples"] = json!([wrench]);
    schemas["WrenchSensorMemory"]["properties"]["filtered"]["examples"] = json!([wrench]);
    for schema in ["WrenchSensor", "PayloadRequest"] {
        schemas[schema]["properties"]["pose"]["examples"] =
            json!([{"position": [0.0, 0.0, 0.05], "orientation": {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}}]);
    }
    document["components"]["schemas"]["RobotRegistration"]["properties"]["shapes"]["examples"] = json!(["fit"]);
    let report = &parsed(STEP_IN_A_ROOM)["collisions"];
    document["components"]["schemas"]["LiveRoom"]["properties"]["report"]["examples"] = json!([report]);
    document["components"]["schemas"]["LiveSample"]["properties"]["room"]["examples"] = json!([{"report": report, "obstacles": [{"name": "ball", "position": [0.3, 1.0, 0.5], "velocity": [0.0, 0.1, 0.0]}]}]);
    follow_surface(&mut document["components"]["schemas"]);
    for schema in ["ContactReport", "ContactMemory", "LiveContact"] {
        document["components"]["schemas"][schema]["properties"]["fault"]["examples"] = json!(["force_limit"]);
        document["components"]["schemas"][schema]["properties"]["state"]["examples"] = json!(["contact"]);
    }
    {
        document["components"]["schemas"]["ContactReport"]["properties"]["event"]["examples"] = json!(["contact"]);
    }
    document["components"]["schemas"]["ObstacleMotion"]["properties"]["displacement"]["examples"] =
        json!([{"kind": "constant", "value": [0.0, 0.1, 0.0]}]);
    for Example { path, method, name, request, answer } in EXAMPLES {
        let operation = &document["paths"][path][method];
        let body = "/requestBody/content/application~1json";
        if let Some(request) = request {
            let pointer = format!("/paths/{}/{method}{body}", path.replace('/', "~1"));
            add(document, &pointer, name, &parsed(request));
        } else if operation.is_null() {
            continue;
        }
        let responses = document["paths"][path][method]["responses"].as_object();
        let success = responses.and_then(|all| all.keys().find(|status| status.starts_with('2')).cloned());
        let Some(status) = success else { continue };
        let pointer =
            format!("/paths/{}/{method}/responses/{status}/content/application~1json", path.replace('/', "~1"));
        add(document, &pointer, name, &parsed(answer));
    }
    let pointer = "/paths/~1v1~1resolve/post/responses/422/content/application~1problem+json";
    add(document, pointer, "problem", &parsed(PROBLEM));
    let watched = json!({"state": parsed(STATE), "answer": parsed(STATE_ANSWER)});
    let schemas = &mut document["components"]["schemas"];
    add_values(schemas, &reference::<wire::WatchedStep>(), "", &watched);
    add_values(schemas, &reference::<wire::LiveFrame>(), "", &parsed(LIVE_FRAME));
    copy_values(schemas);
}

/// Gives fields without an example the value of a field with the same name and type in another schema.
fn copy_values(schemas: &mut Value) {
    let known = schemas.clone();
    let fields = || known.as_object().into_iter().flatten().filter_map(|(_, schema)| schema["properties"].as_object());
    let same = |name: &str, field: &Value| {
        let others = fields().filter_map(|fields| fields.get(name));
        let alike = |other: &&Value| other["type"] == field["type"] && other["items"] == field["items"];
        others.filter(alike).find_map(|other| other.get("examples").cloned())
    };
    for (_, schema) in schemas.as_object_mut().into_iter().flatten() {
        for (name, field) in schema.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten() {
            if let Some(examples) = same(name, field).filter(|_| field.get("examples").is_none()) {
                field["examples"] = examples;
            }
        }
    }
}

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_default()
}

fn add(document: &mut Value, pointer: &str, name: &str, value: &Value) {
    let Some(content) = document.pointer_mut(pointer) else { return };
    content["examples"][name] = json!({"summary": name.replace('_', " "), "value": value});
    let schema = content["schema"].clone();
    let schemas = &mut document["components"]["schemas"];
    add_values(schemas, &schema, "", value);
}

/// Adds the values of an example to the fields of a schema. `place`: JSON pointer to the schema among the components, empty
/// for a reference.
fn add_values(schemas: &mut Value, schema: &Value, place: &str, value: &Value) {
    if let Some(name) = schema["$ref"].as_str().and_then(|link| link.rsplit('/').next()) {
        let schema = schemas[name].clone();
        return add_values(schemas, &schema, &format!("/{name}"), value);
    }
    for key in ["oneOf", "allOf"] {
        for (i, option) in schema[key].as_array().into_iter().flatten().enumerate() {
            if fits(schemas, option, value) {
                add_values(schemas, &option.clone(), &format!("{place}/{key}/{i}"), value);
            }
        }
    }
    for (field, part) in schema["properties"].as_object().into_iter().flatten() {
        let Some(value) = value.get(field) else { continue };
        let place = format!("{place}/properties/{field}");
        if let Some(known) = schemas.pointer_mut(&place)
            && (known.get("examples").is_none() || known["examples"][0].is_null())
        {
            known["examples"] = json!([value]);
        }
        add_values(schemas, part, &place, value);
    }
    if schema["additionalProperties"].is_object() {
        let place = format!("{place}/additionalProperties");
        for value in value.as_object().into_iter().flatten().map(|(_, value)| value) {
            add_values(schemas, &schema["additionalProperties"], &place, value);
        }
    }
    for value in value.as_array().into_iter().flatten() {
        add_values(schemas, &schema["items"], &format!("{place}/items"), value);
    }
}

/// Returns whether a variant of a schema can describe the value.
fn fits(schemas: &Value, option: &Value, value: &Value) -> bool {
    if let Some(name) = option["$ref"].as_str().and_then(|link| link.rsplit('/').next()) {
        return fits(schemas, &schemas[name], value);
    }
    if let Some(options) = option["oneOf"].as_array() {
        return options.iter().any(|option| fits(schemas, option, value));
    }
    let of_type = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    let tag = &option["properties"]["kind"]["enum"][0];
    let all_known = |fields: &serde_json::Map<String, Value>| {
        option["properties"].is_null() || fields.keys().all(|field| option["properties"].get(field).is_some())
    };
    let type_fits =
        option["type"] == of_type || option["type"].as_array().is_some_and(|types| types.iter().any(|t| t == of_type));
    type_fits && (tag.is_null() || *tag == value["kind"]) && value.as_object().is_none_or(all_known)
}

/// Returns an example of what the measured positions of a tool in contact show.
fn measured_contact() -> Value {
    json!({
        "position": [0.012, 0.012, 0.012], "stiffness": [15_300.0, 12_000.0, 130.0], "means": [0.011, 28.0],
        "sums": [1e-6, 0.012, 144.0, 80.0], "surface_motion": [0.0, 0.0, 0.0],
        "followed": [0.012, 29.9, 0.0, 0.1, 1e-7, 0.1, 1e-7, 0.2]
    })
}

/// Adds the examples of a law that follows the normal of a surface. The derive has no example for a field that is an object or null.
fn follow_surface(schemas: &mut Value) {
    schemas["ContactReport"]["properties"]["surface"]["examples"] = json!([{"normal": [0.6, 0.0, -0.8], "friction": 0.31, "uncertainty_rad": 0.01, "is_limited": false, "max_speed": 0.018}]);
    schemas["ContactMemory"]["properties"]["measured"]["examples"] = json!([measured_contact()]);
    schemas["ContactMemory"]["properties"]["normal"]["examples"] = json!([{
        "normal": [0.6, 0.0, -0.8], "mean": [0.59, 0.0, -0.79], "friction": 0.31, "variance": 1e-4, "chords": 5.0,
        "is_sliding": true, "position": [[0.5, 0.1, 0.2], [0.4995, 0.1, 0.2002]],
        "force": [[17.0, 0.0, -12.0], [17.0, 0.0, -12.0]]
    }]);
    let variants = schemas["Law"]["oneOf"].as_array_mut().into_iter().flatten();
    for law in variants.filter(|law| law["properties"]["surface"].is_object()) {
        law["properties"]["surface"]["examples"] = json!([{"max_tilt_rad": 0.6}]);
    }
}
