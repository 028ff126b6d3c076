//! The forms of a state: named joints, wrench conventions, omitted fields.

use serde_json::{Value, json};

use crate::harness::{Service, example, without};

/// Replaces the list at `field` by an object with the joint names in reverse order.
fn by_name_reversed(body: &Value, field: &str) -> String {
    let values = body[field].as_array().unwrap().iter().enumerate();
    let pairs: Vec<_> = values.rev().map(|(i, value)| format!(r#""j{}": {value}"#, i + 1)).collect();
    replaced(body, field, &format!("{{{}}}", pairs.join(", ")))
}

/// Replaces the value at `field` by another text.
fn replaced(body: &Value, field: &str, text: &str) -> String {
    let mut body = body.clone();
    body[field] = json!("@");
    body.to_string().replace(r#""@""#, text)
}

#[test]
fn joints_may_be_named_in_any_order() {
    let service = Service::start();
    let ordered = example("resolve.json");
    let named = service.post("/v1/resolve", &by_name_reversed(&ordered, "joint_position")).accepted();
    let answer = |answer: Value| without(answer, &["elapsed_us"]).to_string();
    assert_eq!(answer(named), answer(service.call("/v1/resolve", &ordered)));

    let session = || format!("{}/step", service.open(&example("controller.json")));
    let state = example("state.json");
    let named = service.post(&session(), &by_name_reversed(&state, "joint_position")).accepted();
    assert_eq!(answer(named), answer(service.call(&session(), &state)));
}

#[test]
fn names_that_do_not_fit_the_robot_are_refused() {
    let service = Service::start();
    let refusal = |joints: &str, pointer: &str| {
        let body = replaced(&example("resolve.json"), "joint_position", joints);
        service.post("/v1/resolve", &body).assert_refused(422, Some(pointer));
    };
    let six = r#""j1": 1, "j2": 1, "j3": 1, "j4": 1, "j5": 1, "j6": 1"#;
    refusal(&format!("{{{six}}}"), "/joint_position");
    refusal(&format!(r#"{{{six}, "j8": 1}}"#), "/joint_position/j8");
    refusal(&format!(r#"{{{six}, "j7": 1, "j8": 1}}"#), "/joint_position/j8");
    refusal(&format!(r#"{{{six}, "j7": 1, "j1": 1}}"#), "/joint_position");
    refusal(&format!(r#"{{{six}, "j7": 1e300}}"#), "/joint_position/j7");
    refusal(r#"{"a/b~c": 1}"#, "/joint_position/a~1b~0c");
    refusal("{}", "/joint_position");
}

#[test]
fn a_wrench_on_the_tool_is_the_negative_of_one_on_the_environment() {
    let service = Service::start();
    let answer = |convention: &str, sign: f64| {
        let mut request = example("step.json");
        request["controller"]["wrench_convention"] = json!(convention);
        request["state"]["wrench"] = json!({"force": [sign * 12.5, sign * 3.0, 0.0], "torque": [sign * 0.5, 0.0, 0.0]});
        without(service.call("/v1/step", &request), &["elapsed_us"]).to_string()
    };
    assert_eq!(answer("on_environment", 1.0), answer("on_tool", -1.0));
    assert_ne!(answer("on_environment", 1.0), answer("on_environment", -1.0));
}

#[test]
fn an_omitted_velocity_is_zero_at_the_first_step() {
    let service = Service::start();
    let mut request = example("step.json");
    let measured = service.call("/v1/step", &request);
    request["state"].as_object_mut().unwrap().remove("joint_velocity");
    let assumed = service.call("/v1/step", &request);
    assert_eq!(measured["joint_velocity"], assumed["joint_velocity"]);
}
