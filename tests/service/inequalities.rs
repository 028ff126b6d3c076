//! Inequalities in addition to the limits, and tasks that are scaled down.

use serde_json::{Value, json};

use crate::harness::{Service, example, numbers, without};

fn names(list: &Value) -> Vec<&str> {
    list.as_array().map(|list| list.iter().map(|entry| entry["name"].as_str().unwrap()).collect()).unwrap_or_default()
}

#[test]
fn an_active_ceiling_scales_a_task_and_is_reported() {
    let service = Service::start();
    let request = example("resolve_limits.json");
    let answer = service.call("/v1/resolve", &request);
    let scale = answer["tasks"][0]["scale"].as_f64().unwrap();
    let achieved = numbers(&answer["tasks"][0]["achieved"]);
    assert!(scale > 0.0 && scale < 1.0, "{answer}");
    for (achieved, requested) in achieved.iter().zip([0.4, 0.2, 0.1]) {
        assert!((achieved - scale * requested).abs() < 1e-12, "{answer}");
    }
    let active = &answer["active_inequalities"];
    assert!(!names(active).is_empty() && active[0]["multiplier"].as_f64().unwrap() > 0.0, "{answer}");

    let mut free = request.clone();
    free.as_object_mut().unwrap().remove("inequalities");
    let free = service.call("/v1/resolve", &free);
    assert!(free["tasks"][0]["scale"].as_f64().unwrap() > scale && free.get("active_inequalities").is_none());

    let mut bent = request;
    bent["tasks"][0]["scale"] = json!(false);
    let bent = service.call("/v1/resolve", &bent);
    assert!(bent["tasks"][0].get("scale").is_none());
    let achieved = numbers(&bent["tasks"][0]["achieved"]);
    assert!(
        achieved[0] / 0.4 > achieved[2] / 0.1 + 0.01 && achieved[2] < scale * 0.1 + 1e-9,
        "without scaling, the ceiling changes the direction: {bent}"
    );
}

#[test]
fn the_closed_form_lists_violated_inequalities() {
    let service = Service::start();
    let mut request = example("resolve_limits.json");
    request["solver"] = json!("closed_form");
    request["inequalities"][0]["offset_m"] = json!(-2);
    let answer = service.call("/v1/resolve", &request);
    assert!(names(&answer["violated_inequalities"]).contains(&"ceiling"), "{answer}");
    let broken = &answer["violated_inequalities"][0];
    assert!(broken["value"].as_f64().unwrap() > broken["bound"].as_f64().unwrap());
}

/// A joint that moves at 1.5 rad/s cannot obey a bound of 0.2 rad/s at once.
#[test]
fn an_inequality_that_is_not_kept_is_not_called_at_its_bound() {
    let service = Service::start();
    let law = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": [1.5]}});
    let tasks = json!([{"name": "go", "jacobian": [[1, 0, 0, 0, 0, 0, 0]], "law": law}]);
    let mut controller = json!({"robot": "panda", "period_s": 0.008, "why": true, "tasks": tasks});
    let session = service.open(&controller);
    let mut joints = [0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.8];
    let (mut was_broken, mut was_kept) = (false, false);
    for sequence in 0..60 {
        if sequence == 30 {
            controller["inequalities"] =
                json!([{"kind": "joints", "name": "slow", "coefficients": [1, 0, 0, 0, 0, 0, 0], "upper": 0.2}]);
            let json = [("content-type", "application/json")];
            service.send("PUT", &session, &json, &controller.to_string()).accepted();
        }
        let state = json!({"sequence": sequence, "time_s": 0.008 * f64::from(sequence), "joint_position": joints});
        let answer = service.call(&format!("{session}/step"), &state);
        for (q, u) in joints.iter_mut().zip(numbers(&answer["joint_velocity"])) {
            *q += 0.008 * u;
        }
        let why = answer["why"].to_string();
        let is_broken = names(&answer["violated_inequalities"]).contains(&"slow");
        let is_active = names(&answer["active_inequalities"]).contains(&"slow");
        assert_eq!(why.contains("`slow` is not kept"), is_broken, "{answer}");
        assert_eq!(why.contains("`slow` is at its bound"), is_active && !is_broken, "{answer}");
        (was_broken, was_kept) = (was_broken || is_broken && is_active, was_kept || is_active && !is_broken);
    }
    assert!(was_broken && was_kept);
}

#[test]
fn an_active_inequality_is_remembered_in_sessions_and_stateless_steps() {
    let service = Service::start();
    let mut controller = example("controller.json");
    controller["inequalities"] = json!([
        {"kind": "plane", "name": "wall", "normal": [1, 0, 0], "offset_m": -9, "point": "j4", "rate_per_s": 0.001},
        {"kind": "joints", "coefficients": [1, 0, 1, 0, 0, 0, 0], "upper": 0}
    ]);
    let session = service.open(&controller);
    let mut memory = Value::Null;
    let mut remembered = false;
    for sequence in 0..20 {
        let mut state = example("state.json");
        state["sequence"] = json!(sequence);
        state["time_s"] = json!(0.001 * f64::from(sequence));
        let by_session = service.call(&format!("{session}/step"), &state);
        let body = json!({"controller": controller, "state": state, "memory": memory});
        let stateless = service.call("/v1/step", &body);
        memory = stateless["memory"].clone();
        remembered |= memory["active_set"].to_string().contains("inequality");
        let answer = |answer: Value| without(answer, &["elapsed_us", "memory"]).to_string();
        assert_eq!(answer(by_session), answer(stateless));
    }
    assert!(remembered, "no inequality was ever active: {memory}");
}

#[test]
fn wrong_inequalities_are_refused_with_a_pointer() {
    let service = Service::start();
    let plane = json!({"kind": "plane", "normal": [0, 0, 1], "offset_m": 0.4});
    let joints = json!({"kind": "joints", "coefficients": [1, 0, 0, 0, 0, 0, 0], "upper": 0.1});
    let with = |base: &Value, field: &str, value: Value| {
        let mut inequality = base.clone();
        inequality[field] = value;
        json!([inequality])
    };
    let rows: Vec<(Value, &str, &str)> = vec![
        (json!(7), "/inequalities", "give a list, not 7"),
        (json!([7]), "/inequalities/0", "give an object, not 7"),
        (json!([{"kind": "sphere"}]), "/inequalities/0/kind", "there is no value `sphere`; known: `joints`, `plane`"),
        (with(&joints, "coefficients", json!([1, 0])), "/inequalities/0/coefficients", "one per joint"),
        (
            with(&joints, "coefficients", json!([0, 0, 0, 0, 0, 0, 0])),
            "/inequalities/0/coefficients",
            "differ from zero",
        ),
        (with(&joints, "upper", json!(1e300)), "/inequalities/0/upper", "out of range"),
        (with(&plane, "normal", json!([0, 0, 0])), "/inequalities/0/normal", "differ from zero"),
        (with(&plane, "normal", json!([0, 0, 1e10])), "/inequalities/0/normal/2", "out of range"),
        (with(&plane, "point", json!("elbow")), "/inequalities/0/point", "j4"),
        (with(&plane, "rate_per_s", json!(0)), "/inequalities/0/rate_per_s", "positive"),
        (with(&plane, "rate_per_s", json!(-3)), "/inequalities/0/rate_per_s", "positive"),
        (with(&plane, "offset", json!(1)), "/inequalities/0", "there is no field `offset`; did you mean `offset_m`?"),
        (
            json!([plane, {"kind": "joints", "name": "inequality 1", "coefficients": [1, 0, 0, 0, 0, 0, 0], "upper": 0}]),
            "/inequalities/1/name",
            "own name",
        ),
        (Value::Array(vec![joints; 513]), "/inequalities", "at most 512"),
    ];
    for (inequalities, pointer, word) in rows {
        let mut request = example("resolve.json");
        request["inequalities"] = inequalities;
        let answer = service.post("/v1/resolve", &request.to_string());
        answer.assert_refused(422, Some(pointer));
        assert!(answer.text.contains(word), "{word} is not in {}", answer.text);
        let mut controller = example("controller.json");
        controller["inequalities"] = request["inequalities"].clone();
        service.post("/v1/controllers", &controller.to_string()).assert_refused(422, Some(pointer));
    }
    let mut nowhere = example("resolve.json");
    nowhere["tasks"] = json!([{"jacobian": [[1, 0]], "velocity": [1]}]);
    for field in ["robot", "joint_position", "limits"] {
        nowhere.as_object_mut().unwrap().remove(field);
    }
    nowhere["inequalities"] = json!([{"kind": "plane", "normal": [0, 0, 1], "offset_m": 0.4}]);
    service.post("/v1/resolve", &nowhere.to_string()).assert_refused(422, Some("/inequalities/0/point"));
}
