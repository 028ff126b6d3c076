//! The interface description: it equals the committed file, describes every field, and its examples are real answers.

use std::collections::BTreeSet;
use std::path::PathBuf;

use revprio::service::{asyncapi_document, openapi_document};
use serde_json::{Map, Value, json};

use crate::harness::{Service, example};

fn document() -> Value {
    serde_json::from_str(&openapi_document()).unwrap()
}

fn committed(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("api").join(name)
}

#[test]
fn the_committed_documents_equal_those_of_the_program() {
    for (name, command, text) in
        [("openapi.json", "openapi", openapi_document()), ("asyncapi.json", "asyncapi", asyncapi_document())]
    {
        let is_equal = std::fs::read_to_string(committed(name)).unwrap() == text;
        assert!(is_equal, "api/{name} is out of date; write it again: cargo run -- {command} > api/{name}");
    }
}

#[test]
fn the_service_serves_its_description() {
    let service = Service::start();
    for (path, text) in [("/openapi.json", openapi_document()), ("/asyncapi.json", asyncapi_document())] {
        let served = service.get(path).text;
        let document: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(served, document.to_string(), "{path} is not compact or differs");
    }
}

#[test]
fn descriptions_are_compressed_and_sent_once() {
    let service = Service::start();
    let get = |headers: &str| {
        let request = format!("GET /openapi.json HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n{headers}\r\n");
        service.raw_bytes(request.as_bytes())
    };
    let head = |answer: &[u8]| String::from_utf8_lossy(answer).split("\r\n\r\n").next().unwrap().to_owned();
    let plain = get("");
    assert!(!head(&plain).contains("content-encoding") && plain.len() > 200_000, "{}", head(&plain));
    let compressed = get("accept-encoding: gzip, br\r\n");
    assert!(
        head(&compressed).contains("content-encoding: gzip") && head(&compressed).contains("vary: accept-encoding")
    );
    assert!(5 * compressed.len() < plain.len(), "{} bytes", compressed.len());
    let version = head(&plain).lines().find_map(|line| line.strip_prefix("etag: ").map(str::to_owned)).unwrap();
    let known = get(&format!("if-none-match: {version}\r\n"));
    assert!(head(&known).starts_with("HTTP/1.1 304 ") && known.len() < 1000, "{}", head(&known));
    let other = get("if-none-match: W/\"0\"\r\n");
    assert!(head(&other).starts_with("HTTP/1.1 200 ") && other.len() == plain.len());
}

#[test]
fn the_reference_loads_nothing_from_other_servers() {
    let service = Service::start();
    for file in ["", "index.css", "swagger-ui.css", "swagger-ui-bundle.js", "swagger-initializer.js"] {
        let answer = service.get(&format!("/docs/{file}"));
        assert_eq!(answer.status, 200, "{file}");
        assert!(!answer.text.contains("src=\"http") && !answer.text.contains("href=\"http"), "{file}");
    }
    assert!(service.get("/docs/swagger-initializer.js").text.contains("/openapi.json"));
    assert_eq!(service.get("/docs").status, 200, "it redirects to the page");
    for none in ["/docs/none.js", "/docs/..%2fCargo.toml", "/docs/%00"] {
        service.get(none).assert_refused(404, None);
    }
}

/// Calls `act` with the pointer and the value of every schema of the components.
fn each_schema(act: &mut impl FnMut(&str, &Value)) {
    fn visit(place: &str, schema: &Value, act: &mut impl FnMut(&str, &Value)) {
        act(place, schema);
        for (name, part) in schema["properties"].as_object().into_iter().flatten() {
            visit(&format!("{place}/{name}"), part, act);
        }
        for (i, part) in schema["oneOf"].as_array().into_iter().flatten().enumerate() {
            visit(&format!("{place}/{i}"), part, act);
        }
        for key in ["items", "additionalProperties"] {
            if schema[key].is_object() {
                visit(&format!("{place}/{key}"), &schema[key], act);
            }
        }
    }
    for (name, schema) in document()["components"]["schemas"].as_object().unwrap() {
        visit(name, schema, act);
    }
}

#[test]
fn every_schema_and_field_is_described_and_every_field_of_a_body_has_an_example() {
    let mut errors = Vec::new();
    each_schema(&mut |place, schema| {
        if !place.contains('/') && schema["description"].as_str().is_none_or(str::is_empty) {
            errors.push(format!("{place} has no description"));
        }
        for (name, field) in schema["properties"].as_object().into_iter().flatten() {
            if field["description"].as_str().is_none_or(str::is_empty) {
                errors.push(format!("{place}/{name} has no description"));
            }
            if field.get("examples").is_none() {
                errors.push(format!("{place}/{name} has no example"));
            }
        }
    });
    assert!(errors.is_empty(), "{} errors\n{}", errors.len(), errors.join("\n"));
}

#[test]
fn every_number_of_a_request_and_every_whole_number_is_bounded() {
    let mut errors = Vec::new();
    let mut bounded = 0;
    each_schema(&mut |place, schema| {
        let is =
            |kind: &str| schema["type"] == kind || schema["type"].as_array().is_some_and(|k| k.contains(&kind.into()));
        if is("integer")
            && !(schema["minimum"].is_number()
                && schema["maximum"].as_f64().is_some_and(|most| most <= 9_007_199_254_740_991.0))
        {
            errors.push(place.to_owned());
        }
        bounded += usize::from(is("number") && schema["maximum"].is_number());
    });
    assert!(errors.is_empty(), "{}", errors.join("\n"));
    assert!(bounded > 50, "{bounded}");
}

#[test]
fn every_operation_and_every_answer_is_described() {
    let mut names = BTreeSet::new();
    for (path, item) in document()["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap().iter().filter(|(key, _)| *key != "parameters") {
            let place = format!("{method} {path}");
            for field in ["summary", "description", "operationId"] {
                assert!(operation[field].as_str().is_some_and(|text| !text.is_empty()), "{place}: {field}");
            }
            assert!(operation["tags"].as_array().is_some_and(|tags| tags.len() == 1), "{place}: tags");
            assert!(names.insert(operation["operationId"].to_string()), "{place}: operationId");
            for (status, response) in operation["responses"].as_object().unwrap() {
                assert!(response["description"].as_str().is_some_and(|text| !text.is_empty()), "{place} {status}");
                if status.as_str() >= "400" {
                    assert!(response["content"]["application/problem+json"].is_object(), "{place} {status}");
                }
            }
        }
    }
    assert!(names.len() >= 23, "{names:?}");
}

/// Fields that differ from call to call.
const VOLATILE: [&str; 6] = ["elapsed_us", "id", "idle_s", "request_id", "calls_per_second", "progress"];

fn stable(value: Value) -> Value {
    match value {
        Value::Object(fields) => {
            let kept = fields.into_iter().map(|(name, value)| {
                let value = if VOLATILE.contains(&name.as_str()) { Value::Null } else { stable(value) };
                (name, value)
            });
            Value::Object(kept.collect::<Map<_, _>>())
        }
        Value::Array(values) => values.into_iter().map(stable).collect(),
        other => other,
    }
}

/// Returns the first place where two values differ by more than rounding.
fn difference(place: &str, a: &Value, b: &Value) -> Option<String> {
    let differs = || Some(format!("{place}: {a:.200} is not {b:.200}"));
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            if a.keys().ne(b.keys()) {
                return differs();
            }
            a.iter().find_map(|(name, value)| difference(&format!("{place}/{name}"), value, &b[name]))
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).enumerate().find_map(|(i, (a, b))| difference(&format!("{place}/{i}"), a, b))
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            ((a - b).abs() > 1e-9 * (1.0 + b.abs())).then(differs).flatten()
        }
        (a, b) if a == b => None,
        _ => differs(),
    }
}

/// Asserts that an answer equals the committed file. With `REVPRIO_WRITE_ANSWERS=1`, writes the file instead.
fn assert_committed(name: &str, answer: &Value) {
    let path = committed("examples").join("answers").join(format!("{name}.json"));
    if std::env::var_os("REVPRIO_WRITE_ANSWERS").is_some() {
        std::fs::write(&path, format!("{answer:#}\n")).unwrap();
        return;
    }
    let committed: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let difference = difference("", &stable(answer.clone()), &stable(committed));
    let advice = "if it is meant so: REVPRIO_WRITE_ANSWERS=1 cargo test --test service examples";
    assert_eq!(difference, None, "{name}: {advice}");
}

/// Shows a run that was told to end as it is before it ends: it ends on a thread of its own, before or after the
/// answer is written.
fn as_if_running(status: &mut Value) {
    if status["state"] == "finished" {
        assert!(status.as_object_mut().unwrap().remove("metrics").is_some());
        status["state"] = json!("running");
    }
}

/// Sends every file of `api/examples`, and compares the answers with `api/examples/answers`.
#[test]
fn the_examples_of_the_document_get_their_committed_answers() {
    let service = Service::start();
    let mut sent = BTreeSet::new();
    let mut call = |path: &str, name: &str| {
        sent.insert(name.to_owned());
        let mut answer = service.call(path, &example(&format!("{name}.json")));
        if name == "control_end" {
            as_if_running(&mut answer);
        }
        assert_committed(name, &answer);
        answer
    };
    for name in [
        "resolve",
        "resolve_bounds",
        "resolve_certificate",
        "resolve_closed_form",
        "resolve_everything",
        "resolve_limits",
        "resolve_link",
    ] {
        call("/v1/resolve", name);
    }
    call("/v1/resolve/batch", "batch");
    call("/v1/kinematics", "kinematics");
    call("/v1/kinematics", "kinematics_link");
    call("/v1/stability", "stability");
    call("/v1/stability", "stability_impedance");
    call("/v1/payload", "payload");
    call("/v1/step", "step");
    call("/v1/step", "step_inequality");
    call("/v1/step", "step_again");
    call("/v1/step", "step_targets");
    call("/v1/step", "step_ahead");
    call("/v1/step", "step_chunk");
    call("/v1/step", "step_room");
    call("/v1/step", "step_straight");
    call("/v1/controllers", "controller_laws");
    call("/v1/controllers", "controller_room");
    let session = call("/v1/controllers", "controller")["id"].as_str().unwrap().to_owned();
    call(&format!("/v1/controllers/{session}/step"), "state");
    call("/v1/simulations", "simulation");
    let live = call("/v1/simulations", "simulation_interactive")["id"].as_str().unwrap().to_owned();
    while service.get(&format!("/v1/simulations/{live}")).accepted()["state"] == "queued" {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    call(&format!("/v1/simulations/{live}/control"), "control");
    call(&format!("/v1/simulations/{live}/control"), "control_end");
    call("/v1/simulations", "simulation_world");
    let run = call("/v1/simulations", "simulation_own")["id"].as_str().unwrap().to_owned();
    let shown = |path: &str, name: &str| assert_committed(name, &service.get(path).accepted());
    shown("/v1/robots", "robots");
    shown("/v1/robots/sawyer_dh", "robot_shown");
    call("/v1/robots", "robot");
    call("/v1/robots", "robot_two_arms");
    call("/v1/robots", "robot_shapes");
    shown("/v1/scenarios", "scenarios");
    shown("/v1/scenarios/stiff_wall", "scenario");
    shown(&format!("/v1/controllers/{session}"), "session");
    let mut sessions = service.get("/v1/controllers").accepted();
    sessions["controllers"].as_array_mut().unwrap().truncate(1);
    assert_committed("sessions", &sessions);
    call(&format!("/v1/controllers/{session}/tare"), "tare");
    let new = example("controller_replaced.json").to_string();
    sent.insert("controller_replaced".to_owned());
    let replaced =
        service.send("PUT", &format!("/v1/controllers/{session}"), &[("content-type", "application/json")], &new);
    assert_committed("controller_replaced", &replaced.accepted());
    let mut wrong = example("resolve.json");
    wrong["joint_position"] = json!([0.3, -0.6]);
    assert_committed("problem", &service.post("/v1/resolve", &wrong.to_string()).json());
    let status = || service.get(&format!("/v1/simulations/{run}")).accepted();
    while ["queued", "running"].map(Value::from).contains(&status()["state"]) {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert_committed("simulation_finished", &status());

    let files = std::fs::read_dir(committed("examples")).unwrap().map(|entry| entry.unwrap().path());
    let files = files.filter(|path| path.extension().is_some_and(|ending| ending == "json"));
    let files: BTreeSet<String> = files.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    assert_eq!(files, sent);
}

#[test]
fn the_examples_of_the_document_equal_the_files() {
    let document = document();
    let body = |path: &str, name: &str| {
        document["paths"][path]["post"]["requestBody"]["content"]["application/json"]["examples"][name]["value"].clone()
    };
    assert_eq!(body("/v1/resolve", "resolve"), example("resolve.json"));
    assert_eq!(body("/v1/robots", "robot"), example("robot.json"));
    let answer = &document["paths"]["/v1/step"]["post"]["responses"]["200"]["content"]["application/json"];
    assert_eq!(answer["examples"]["step"]["value"], example("answers/step.json"));
    assert_ne!(answer["examples"]["step"]["value"], json!(null));
}
