//! Inequality tasks: tasks with bounds of their velocity, and constant rows in controllers.

use std::ops::ControlFlow;

use revprio_api::Client;
use revprio_lab::simulator::{CallMode, Scenario, run};
use serde_json::{Value, json};

use crate::harness::{Service, example, numbers, without};

const METHODS: [&str; 3] = ["reverse_priority", "strict_reverse_priority", "task_priority"];

/// Two joints: the first one is bounded, then both have a velocity.
fn bounded(lower: &Value, upper: &Value, velocity: f64) -> Value {
    json!({"tasks": [
        {"name": "slow", "jacobian": [[1, 0]], "lower": lower, "upper": upper},
        {"name": "go", "jacobian": [[1, 0], [0, 1]], "velocity": [velocity, 0.2]}
    ]})
}

fn assert_near(value: &Value, expected: &[f64]) {
    let found = numbers(value);
    let near = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(near, "{found:?} is not {expected:?}");
}

#[test]
fn a_task_inside_its_bounds_leaves_lower_tasks_alone() {
    let service = Service::start();
    for method in METHODS {
        let mut request = bounded(&json!([-1]), &json!([1]), 0.5);
        request["method"] = json!(method);
        let answer = service.call("/v1/resolve", &request);
        assert_near(&answer["joint_velocity"], &[0.5, 0.2]);
        let task = &answer["tasks"][0];
        assert_near(&task["requested"], &[0.5]);
        assert!(task["residual_norm"].as_f64().unwrap() < 1e-12 && task.get("active_rows").is_none(), "{answer}");
        assert!(answer.get("contradictions").is_none(), "{answer}");
    }
}

#[test]
fn a_bound_holds_lower_tasks_back_and_is_reported() {
    let service = Service::start();
    for method in METHODS {
        for (velocity, kept, side) in [(2.0, 1.0, "upper"), (-2.0, -1.0, "lower")] {
            let mut request = bounded(&json!([-1]), &json!([1]), velocity);
            request["method"] = json!(method);
            let answer = service.call("/v1/resolve", &request);
            assert_near(&answer["joint_velocity"], &[kept, 0.2]);
            let (slow, go) = (&answer["tasks"][0], &answer["tasks"][1]);
            assert!(slow["residual_norm"].as_f64().unwrap() < 1e-9, "{answer}");
            assert!((go["residual_norm"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{answer}");
            let active = &slow["active_rows"];
            assert_eq!((active.as_array().unwrap().len(), &active[0]["row"]), (1, &json!(0)), "{answer}");
            assert_eq!(active[0]["side"], side);
            assert!(active[0]["multiplier"].as_f64().unwrap() > 0.0, "{answer}");
        }
    }
}

#[test]
fn a_side_without_a_bound_is_null_or_omitted() {
    let service = Service::start();
    let velocity = |lower: Value, upper: Value, velocity: f64| {
        let mut request = bounded(&lower, &upper, velocity);
        for side in ["lower", "upper"] {
            if request["tasks"][0][side].is_null() {
                request["tasks"][0].as_object_mut().unwrap().remove(side);
            }
        }
        numbers(&service.call("/v1/resolve", &request)["joint_velocity"])[0]
    };
    for none in [json!([null]), json!(null)] {
        assert!((velocity(none.clone(), json!([1]), -5.0) + 5.0).abs() < 1e-9);
        assert!((velocity(none.clone(), json!([1]), 5.0) - 1.0).abs() < 1e-9);
        assert!((velocity(json!([-1]), none.clone(), 5.0) - 5.0).abs() < 1e-9);
        assert!((velocity(json!([-1]), none, -5.0) + 1.0).abs() < 1e-9);
    }
}

#[test]
fn bounds_that_contradict_a_limit_are_violated_least_and_reported() {
    let service = Service::start();
    let answer = service.call(
        "/v1/resolve",
        &json!({
            "tasks": [{"name": "fast", "jacobian": [[1, 0]], "lower": [1]}],
            "limits": {"lower": [-0.5, -0.5], "upper": [0.5, 0.5]}
        }),
    );
    let task = &answer["tasks"][0];
    assert_near(&task["achieved"], &[0.5]);
    assert_near(&task["requested"], &[1.0]);
    assert!((task["residual_norm"].as_f64().unwrap() - 0.5).abs() < 1e-9, "{answer}");
    let contradiction = &answer["contradictions"][0];
    assert_eq!(contradiction["task"], "fast");
    let members = contradiction["members"].as_array().unwrap();
    assert_eq!(members.len(), 2, "{answer}");
    assert!(members.contains(&json!({"task": "fast", "row": 0, "side": "lower"})), "{answer}");
    assert!(members.contains(&json!({"joint": "j1", "side": "upper"})), "{answer}");
}

#[test]
fn inequalities_that_contradict_the_limits_are_reported_without_a_task() {
    let service = Service::start();
    let answer = service.call(
        "/v1/resolve",
        &json!({
            "tasks": [{"jacobian": [[1, 0]], "velocity": [0]}],
            "limits": {"lower": [-1, -1], "upper": [1, 1]},
            "inequalities": [{"kind": "joints", "name": "wall", "coefficients": [1, 0], "upper": -2}]
        }),
    );
    let contradiction = &answer["contradictions"][0];
    assert_eq!(contradiction.get("task"), Some(&Value::Null), "{answer}");
    let members = contradiction["members"].as_array().unwrap();
    assert_eq!(members.len(), 2, "{answer}");
    assert!(members.contains(&json!({"inequality": "wall", "side": "upper"})), "{answer}");
    assert!(members.contains(&json!({"joint": "j1", "side": "lower"})), "{answer}");
}

#[test]
fn a_higher_task_that_contradicts_bounds_is_named() {
    let service = Service::start();
    let answer = service.call(
        "/v1/resolve",
        &json!({"method": "strict_reverse_priority", "tasks": [
            {"name": "go", "jacobian": [[1, 0]], "velocity": [2]},
            {"name": "slow", "jacobian": [[1, 0]], "upper": [1]}
        ]}),
    );
    assert_near(&answer["tasks"][0]["achieved"], &[2.0]);
    assert!((answer["tasks"][1]["residual_norm"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{answer}");
    let contradiction = &answer["contradictions"][0];
    assert_eq!(contradiction["task"], "slow");
    let members = contradiction["members"].as_array().unwrap();
    let rows: Vec<_> = members.iter().map(|member| (&member["task"], &member["row"])).collect();
    assert!(rows.contains(&(&json!("go"), &json!(0))) && rows.contains(&(&json!("slow"), &json!(0))), "{answer}");
}

#[test]
fn the_closed_form_ignores_bounds_and_reports_their_violation() {
    let service = Service::start();
    let mut request = bounded(&json!([-1]), &json!([1]), 2.0);
    request["solver"] = json!("closed_form");
    let answer = service.call("/v1/resolve", &request);
    assert_near(&answer["joint_velocity"], &[2.0, 0.2]);
    assert!((answer["tasks"][0]["residual_norm"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{answer}");
    assert_near(&answer["tasks"][0]["requested"], &[1.0]);
}

#[test]
fn a_batch_resolves_bounds_as_single_problems() {
    let service = Service::start();
    let items = [bounded(&json!([-1]), &json!([1]), 2.0), bounded(&json!([1]), &json!([-1]), 2.0)];
    let batch = service.call("/v1/resolve/batch", &json!({"items": items}));
    let single = service.call("/v1/resolve", &items[0]);
    assert_eq!(without(batch["items"][0].clone(), &["elapsed_us"]), without(single, &["elapsed_us"]));
    assert_eq!(batch["items"][1]["pointer"], "/items/1/tasks/0/lower/0");
}

/// Returns a controller with bounds on a tool axis, bounds on constant rows, and constant rows with a velocity.
fn controller() -> Value {
    let constant = |value: f64| json!({"kind": "constant", "value": value});
    json!({"robot": "sawyer_dh", "period_s": 0.001, "limits": "position_velocity", "method": "strict_reverse_priority", "damping": null, "tasks": [
        {"name": "height", "axes": ["z"], "lower": [-0.02], "upper": [0.02]},
        {"name": "elbow", "jacobian": [[0, 0, 0, 1, 0, 1, 0], [0, 0, 0, 1, 0, -1, 0]], "lower": [null, -0.01],
            "upper": [0.05, null]},
        {"name": "lift", "axes": ["x", "z"], "law": {"kind": "velocity", "target_velocity": constant(0.1)}},
        {"name": "roll", "jacobian": [[0, 0, 0, 0, 0, 0, 2]],
            "law": {"kind": "velocity", "target_velocity": constant(0.4)}}
    ]})
}

fn state(sequence: u64) -> Value {
    let mut state = example("state.json");
    state["sequence"] = json!(sequence);
    state["time_s"] = json!(0.001 * sequence as f64);
    state
}

#[test]
fn a_controller_keeps_the_bounds_of_its_tasks() {
    let service = Service::start();
    let session = service.open(&controller());
    let answer = service.call(&format!("{session}/step"), &state(1));
    let velocity = numbers(&answer["joint_velocity"]);
    let tasks = &answer["tasks"];
    assert_near(&tasks[0]["achieved"], &[0.02]);
    assert_near(&tasks[0]["requested"], &[0.02]);
    assert_eq!(tasks[0]["active_rows"][0]["side"], "upper", "{answer}");
    assert!(velocity[3] + velocity[5] <= 0.05 + 1e-9 && velocity[3] - velocity[5] >= -0.01 - 1e-9, "{velocity:?}");
    assert!((2.0 * velocity[6] - 0.4).abs() < 1e-9, "{velocity:?}");
    assert_eq!(tasks[3]["requested"], json!([0.4]));
    assert_eq!(tasks[3]["target_force"], json!([null]));
    let shown = service.get(&session).accepted()["controller"].clone();
    let elbow = &shown["tasks"][1];
    assert_eq!((&elbow["lower"], &elbow["upper"]), (&json!([null, -0.01]), &json!([0.05, null])));
    assert_near(&elbow["jacobian"][1], &[0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0]);
    service.open(&shown);
}

#[test]
fn sessions_and_stateless_steps_with_bounds_give_the_same_bytes() {
    let service = Service::start();
    let session = service.open(&controller());
    let mut memory = Value::Null;
    let mut remembered = false;
    for sequence in 0..20 {
        let by_session = service.call(&format!("{session}/step"), &state(sequence));
        let body = json!({"controller": controller(), "state": state(sequence), "memory": memory});
        let stateless = service.call("/v1/step", &body);
        memory = stateless["memory"].clone();
        let rows = memory["active_set"].as_array().unwrap().iter().flat_map(|set| set.as_array().unwrap());
        remembered |= rows.into_iter().any(|limit| limit["task"] == "height" && limit["row"] == 0);
        let answer = |answer: Value| without(answer, &["elapsed_us", "memory"]).to_string();
        assert_eq!(answer(by_session), answer(stateless));
    }
    assert!(remembered, "no active row was remembered: {memory}");
}

#[test]
fn a_memory_can_name_rows_of_tasks() {
    let service = Service::start();
    let mut request = json!({"controller": controller(), "state": state(1)});
    request["memory"] = service.call("/v1/step", &request)["memory"].clone();
    request["state"] = state(2);
    let mut send = |active_set: Value| {
        request["memory"]["active_set"] = active_set;
        service.post("/v1/step", &request.to_string())
    };
    let row = |task: &str, row: usize| json!({"task": task, "row": row, "side": "upper"});
    send(json!([[{"joint": "j1", "side": "upper"}, row("height", 0), row("elbow", 0), row("elbow", 1)]])).accepted();
    for wrong in [
        row("elbow", 2),
        row("wrist", 0),
        json!({"task": "elbow", "side": "upper"}),
        json!({"row": 0, "side": "upper"}),
        json!({"task": "elbow", "row": 0, "joint": "j1", "side": "upper"}),
        json!({"side": "upper"}),
    ] {
        send(json!([[wrong]])).assert_refused(422, Some("/memory/active_set"));
    }
    send(json!([[row("elbow", 0), row("height", 0)]])).assert_refused(422, Some("/memory"));
    send(json!([[{"task": "elbow", "row": -1, "side": "upper"}]]))
        .assert_refused(422, Some("/memory/active_set/0/0/row"));
}

const SLOW_LIFT: &str = r#"
name = "slow_lift"
description = "move up faster than the bound permits"
duration_s = 0.1
start_joint_position = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]

[controller]
robot = "sawyer_dh"
period_s = 0.001
limits = "position_velocity"
method = "strict_reverse_priority"
damping = { threshold = 0.05, max_factor = 0.0 }

[[controller.tasks]]
name = "height"
axes = ["x", "z"]
lower = [-inf, -0.02]
upper = [inf, 0.02]

[[controller.tasks]]
name = "move"
axes = ["x", "y", "z"]
law = { kind = "velocity", target_velocity = { kind = "constant", value = [0.05, 0.0, 0.1] } }

[[controller.tasks]]
name = "wrist"
jacobian = [[0, 0, 0, 0, 0, 1, 1]]
law = { kind = "velocity", target_velocity = { kind = "constant", value = 0.0 } }
"#;

#[test]
fn a_scenario_has_bounds_and_constant_rows() {
    let service = Service::start();
    let scenario = Scenario::parse(SLOW_LIFT, "slow_lift.toml").unwrap();
    let recording =
        run(&scenario, &Client::new(&service.url()), CallMode::Session, |_| ControlFlow::Continue(())).unwrap();
    let [start, end] = [recording.samples.first(), recording.samples.last()].map(|sample| sample.unwrap().position);
    let lifted = end[2] - start[2];
    assert!((lifted - 0.02 * 0.099).abs() < 1e-5, "{lifted}");
    let moved = end[0] - start[0];
    assert!((moved - 0.05 * 0.099).abs() < 1e-5, "{moved}");
    let json = serde_json::to_string(&scenario).unwrap();
    assert_eq!(Scenario::parse(&json, "slow_lift.json").unwrap(), scenario);
}

#[test]
fn an_infinite_bound_on_the_wrong_side_is_refused_in_a_scenario() {
    for (from, to) in
        [("lower = [-inf", "lower = [inf"), ("upper = [inf", "upper = [-inf"), ("lower = [-inf", "lower = [nan")]
    {
        let refusal = Scenario::parse(&SLOW_LIFT.replace(from, to), "slow_lift.toml").unwrap_err().to_string();
        assert!(refusal.contains("allows no velocity"), "{refusal}");
    }
}
