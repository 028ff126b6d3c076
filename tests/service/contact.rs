//! The law `contact` over HTTP: sessions and stateless steps, what an answer tells, and what is refused.

use serde_json::{Value, json};

use crate::harness::{Service, without};

const START: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];

fn controller(law: &Value) -> Value {
    json!({"robot": "sawyer_dh", "period_s": 0.002, "drive": {"lag_s": 0, "delay_periods": 0}, "tasks": [
        {"name": "press", "axes": ["z"], "law": law},
        {"name": "hold", "axes": ["x", "y", "rx", "ry", "rz"], "law": {"kind": "pose", "gain": 3}}
    ]})
}

fn law() -> Value {
    json!({"kind": "contact", "target_force": {"kind": "constant", "value": -15}, "approach_speed": 0.01})
}

fn state(sequence: u64, q: &[f64], force: f64) -> Value {
    json!({"sequence": sequence, "time_s": sequence as f64 * 0.002, "joint_position": q,
        "wrench": {"force": [0, 0, force], "torque": [0, 0, 0]}})
}

#[test]
fn sessions_and_stateless_steps_press_with_the_same_bytes_and_tell_the_contact() {
    let service = Service::start();
    let controller = controller(&law());
    let session = service.open(&controller);
    let (mut q, mut memory, mut depth, mut states) = (START.to_vec(), Value::Null, -0.002, Vec::new());
    for sequence in 0..600 {
        // A spring 2 mm below the start.
        let state = state(sequence, &q, -(2e4 * f64::max(depth, 0.0)));
        let by_session = service.call(&format!("{session}/step"), &state);
        let stateless = service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": memory}));
        memory = stateless["memory"].clone();
        let velocity: Vec<f64> = serde_json::from_value(by_session["joint_velocity"].clone()).unwrap();
        q.iter_mut().zip(&velocity).for_each(|(q, v)| *q += 0.002 * v);
        depth -= 0.002 * by_session["tasks"][0]["achieved"][0].as_f64().unwrap();
        let contact = by_session["tasks"][0]["contact"][0].clone();
        assert_eq!(by_session["tasks"][1].get("contact"), None);
        let answer = |answer: Value| without(answer, &["elapsed_us", "memory"]).to_string();
        assert_eq!(answer(by_session), answer(stateless));
        if states.last() != Some(&contact["state"]) {
            states.push(contact["state"].clone());
        }
        if sequence == 599 {
            let stiffness = contact["stiffness"].as_f64().unwrap();
            assert!((stiffness / 2e4 - 1.0).abs() < 0.1, "{contact}");
            assert!((contact["predicted_force"].as_f64().unwrap() - 15.0).abs() < 0.5, "{contact}");
        }
    }
    assert_eq!(states, ["approach", "contact"]);
    assert!((2e4 * depth - 15.0).abs() < 0.1, "{depth}");
    assert_eq!(memory["contacts"][0]["state"], "contact");
    // A memory from before the filters has none of them, and a place where the velocity of the surface is now.
    assert_eq!(memory["contacts"][0]["followed"].as_array().map(Vec::len), Some(8));
    for place in ["/contacts/0", "/contacts/0/measured"] {
        memory.pointer_mut(place).and_then(Value::as_object_mut).unwrap().remove("followed");
    }
    memory["contacts"][0].as_object_mut().unwrap().remove("mean_target_force");
    memory["contacts"][0]["measured"]["surface_motion"] = json!([0.01, 0.0, 0.0]);
    let state = state(600, &q, -(2e4 * depth));
    let answer = service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": memory}));
    let contact = &answer["tasks"][0]["contact"][0];
    assert!(contact["state"] == "contact" && contact["surface_velocity"] == 0.0, "{contact}");
}

/// A plane that rises along y, with friction.
#[test]
fn a_surface_is_followed_with_the_same_bytes_by_sessions_and_stateless_steps() {
    let service = Service::start();
    let mut controller = controller(&law());
    controller["tasks"][0]["law"]["surface"] = json!({"max_tilt_rad": 0.5});
    let way = json!({"kind": "ramp", "start": [0, 0, 0, 0, 0], "end": [0, 0.02, 0, 0, 0], "start_time_s": 0.8, "duration_s": 0.8});
    controller["tasks"][1]["law"]["target_displacement"] = way;
    let session = service.open(&controller);
    let (tilt, friction) = (0.3_f64, 0.3);
    let (mut q, mut memory, mut at, mut surface) = (START.to_vec(), Value::Null, [0.0; 2], Value::Null);
    for sequence in 0..800 {
        // The plane is 2 mm below the start; its normal is (−sin, cos) of the tilt along y and z.
        let depth = -(at[1] * tilt.cos() - at[0] * tilt.sin()) - 0.002;
        let pressed = 1e4 * f64::max(depth, 0.0);
        let slides = if at[0] > 1e-4 { friction } else { 0.0 };
        let force = [0.0, pressed * (tilt.sin() + slides * tilt.cos()), pressed * (slides * tilt.sin() - tilt.cos())];
        let mut state = state(sequence, &q, 0.0);
        state["wrench"]["force"] = json!(force);
        let by_session = service.call(&format!("{session}/step"), &state);
        let stateless = service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": memory}));
        memory = stateless["memory"].clone();
        surface = by_session["tasks"][0]["contact"][0]["surface"].clone();
        let velocity: Vec<f64> = serde_json::from_value(by_session["joint_velocity"].clone()).unwrap();
        let model = &revprio_robot::built_in()[0];
        let place = |q: &[f64]| {
            let tool = revprio_robot::kinematics::Configuration::new(model, q).unwrap();
            [tool.tool_pose().translation.vector.y, tool.tool_pose().translation.vector.z]
        };
        let before = place(&q);
        q.iter_mut().zip(&velocity).for_each(|(q, v)| *q += 0.002 * v);
        let after = place(&q);
        at = [at[0] + after[0] - before[0], at[1] + after[1] - before[1]];
        let answer = |answer: Value| without(answer, &["elapsed_us", "memory"]).to_string();
        assert_eq!(answer(by_session), answer(stateless));
    }
    let number = |value: &Value| value.as_f64().unwrap();
    assert!((number(&surface["normal"][1]) - tilt.sin()).abs() < 0.05, "{surface}");
    assert!((number(&surface["friction"]) - friction).abs() < 0.05 && surface["is_limited"] == false, "{surface}");
    assert!(memory["contacts"][0]["normal"].is_object(), "{memory}");
}

#[test]
fn a_surface_without_a_meaning_is_refused() {
    let service = Service::start();
    let refused = |controller: &Value, pointer: &str| {
        service.post("/v1/controllers", &controller.to_string()).assert_refused(422, Some(pointer));
    };
    for tilt in [json!(0), json!(-0.1), json!(1.5), json!(1e15)] {
        let mut controller = controller(&law());
        controller["tasks"][0]["law"]["surface"] = json!({"max_tilt_rad": tilt});
        refused(&controller, "/tasks/0/law/surface/max_tilt_rad");
    }
    let mut list = controller(&law());
    list["tasks"][0]["law"]["surface"] = json!([]);
    refused(&list, "/tasks/0/law");
    let mut rotation = controller(&law());
    rotation["tasks"][0]["law"]["surface"] = json!({});
    rotation["tasks"][0]["axes"] = json!(["rz"]);
    rotation["tasks"][1]["axes"] = json!(["x", "y", "z", "rx", "ry"]);
    refused(&rotation, "/tasks/0/law/surface");
    let mut twice = controller(&law());
    twice["tasks"][0]["law"]["surface"] = json!({});
    twice["tasks"][1] = json!({"name": "again", "axes": ["x"], "law": twice["tasks"][0]["law"]});
    refused(&twice, "/tasks/1/law/surface");
}

#[test]
fn a_task_that_does_not_turn_with_a_surface_is_warned_of() {
    let service = Service::start();
    let mut controller = controller(&law());
    controller["tasks"][0]["law"]["surface"] = json!({});
    let warned = |controller: &Value| {
        let created = service.call("/v1/controllers", controller);
        created["warnings"].to_string().contains("does not turn with the surface")
    };
    assert!(!warned(&controller));
    // The same axes, written in another way, are another frame.
    let pose = json!({"position": [0, 0, 0], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}});
    for frame in [json!("tool"), pose] {
        controller["tasks"][1]["frame"] = frame;
        assert!(warned(&controller), "{controller}");
    }
    // Rotations have no part in the slide.
    controller["tasks"][1]["axes"] = json!(["rx", "ry", "rz"]);
    assert!(!warned(&controller));
}

#[test]
fn a_pull_ends_in_a_fault_that_another_controller_ends() {
    let service = Service::start();
    let session = service.open(&controller(&law()));
    let step = |sequence, force| service.call(&format!("{session}/step"), &state(sequence, &START, force));
    assert_eq!(step(0, 0.0)["tasks"][0]["contact"][0]["state"], "approach");
    let contact = step(1, 3.0)["tasks"][0]["contact"][0].clone();
    assert_eq!((&contact["state"], &contact["fault"]), (&json!("fault"), &json!("pull")));
    assert_eq!(step(2, 0.0)["tasks"][0]["contact"][0]["state"], "fault");
    service.send("PUT", &session, &[("content-type", "application/json")], &controller(&law()).to_string()).accepted();
    assert_eq!(step(3, 0.0)["tasks"][0]["contact"][0]["state"], "approach");
}

#[test]
fn wrong_numbers_of_the_law_are_refused_with_their_place() {
    let service = Service::start();
    let refused = |field: &str, value: Value| {
        let mut law = law();
        law[field] = value;
        let pointer = format!("/tasks/0/law/{field}");
        service.post("/v1/controllers", &controller(&law).to_string()).assert_refused(422, Some(&pointer));
    };
    refused("approach_speed", json!(0));
    refused("max_force", json!(0.1));
    refused("stiffest", json!(10));
    refused("noise", json!(-1));
    refused("bias", json!(-1));
    refused("sensor_lag_s", json!(-1));
    // 5 ms in a wrong unit.
    refused("sensor_lag_s", json!(5));
    refused("target_force", json!({"kind": "constant", "value": 0}));
    let mut list = law();
    list["noise"] = json!([0.2, 0.2]);
    service.post("/v1/controllers", &controller(&list).to_string()).assert_refused(422, Some("/tasks/0/law/noise"));
    let mut raw = controller(&law());
    raw["tasks"][0] = json!({"name": "press", "jacobian": [[1, 0, 0, 0, 0, 0, 0]], "law": law()});
    service.post("/v1/controllers", &raw.to_string()).assert_refused(422, Some("/tasks/0/law/kind"));
}

#[test]
fn a_memory_whose_contacts_do_not_fit_is_refused() {
    let service = Service::start();
    let mut request = json!({"controller": controller(&law()), "state": state(0, &START, 0.0), "memory": null});
    let memory = service.call("/v1/step", &request)["memory"].clone();
    request["state"] = state(1, &START, 0.0);
    let mut refused = |pointer: &str, change: &dyn Fn(&mut Value)| {
        request["memory"] = memory.clone();
        change(&mut request["memory"]["contacts"]);
        service.post("/v1/step", &request.to_string()).assert_refused(422, Some(pointer));
    };
    refused("/memory/contacts/0/fault", &|contacts| contacts[0]["fault"] = json!("pull"));
    refused("/memory", &|contacts| contacts[0]["spent_j"] = json!(-1));
    refused("/memory/contacts", &|contacts| *contacts = json!([contacts[0], contacts[0]]));
}

#[test]
fn numbers_that_contradict_each_other_are_warned_about() {
    let service = Service::start();
    let warned = |fields: Value| {
        let mut law = law();
        law.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        let answer = service.call("/v1/controllers", &controller(&law));
        let warnings = answer["warnings"].as_array().unwrap().iter().map(|text| text.as_str().unwrap().to_owned());
        warnings.filter(|text| text.starts_with("task `press`, axis z:")).collect::<Vec<_>>()
    };
    assert_eq!(warned(json!({"max_force": 30})), [""; 0]);
    for (fields, part) in [
        (json!({"max_force": 10}), "is below the target force 15"),
        (json!({"max_force": 16}), "is less than 1.2 times the target force 15"),
        (json!({"noise": 4}), "so the tool presses with 20"),
    ] {
        let found = warned(fields);
        assert!(found.len() == 1 && found[0].contains(part), "{found:?}");
    }
    let mut deaf = controller(&law());
    deaf["wrench_sensor"] = json!({"deadband_n": 0.7});
    let answer = service.call("/v1/controllers", &deaf);
    assert!(answer["warnings"].to_string().contains("the deadband 0.7 of `wrench_sensor` is above 0.65"), "{answer}");
    service
        .post(
            "/v1/controllers",
            &controller(&json!({"kind": "contact", "target_force": {"kind": "constant", "value": -15},
        "stiffest": 1}))
            .to_string(),
        )
        .assert_refused(422, Some("/tasks/0/law/stiffest"));
}

#[test]
fn a_target_that_changes_its_sign_is_warned_about() {
    let service = Service::start();
    let warnings = |target: Value| {
        let mut law = law();
        law["target_force"] = target;
        service.call("/v1/controllers", &controller(&law))["warnings"].to_string()
    };
    let sine = |offset: f64, amplitude: f64| {
        warnings(json!({"kind": "sine", "offset": offset, "amplitude": amplitude, "angular_frequency_rad_s": 2}))
    };
    let ends = |last: f64| {
        let points = json!([{"time_s": 0, "value": 0}, {"time_s": 1, "value": -20}, {"time_s": 2, "value": last}]);
        warnings(json!({"kind": "waypoints", "points": points}))
    };
    let part =
        "the target force changes its sign, from -20 to 5, and the tool presses with 1 in the direction of -20 instead";
    for warned in [sine(-7.5, 12.5), ends(5.0)] {
        assert!(warned.contains(part), "{warned}");
    }
    for quiet in [sine(-10.0, 10.0), ends(0.0), ends(-5.0)] {
        assert!(!quiet.contains("changes its sign"), "{quiet}");
    }
}

#[test]
fn a_task_that_takes_the_row_of_a_press_is_warned_of() {
    let service = Service::start();
    let warned = |tasks: &Value| {
        let controller = json!({"robot": "panda", "period_s": 0.002, "tasks": tasks});
        service.call("/v1/controllers", &controller)["warnings"].to_string()
    };
    let press = json!({"name": "press", "axes": ["z"], "law": law()});
    let hold = json!({"name": "hold", "axes": ["x", "z"], "law": {"kind": "pose", "gain": 3}});
    let with = |field: &str, value: Value| {
        let mut task = hold.clone();
        task[field] = value;
        task
    };
    let text = warned(&json!([hold, press]));
    assert!(text.contains("task `press` cannot press along z, which `hold` before it moves already"), "{text}");
    let slow = json!({"name": "slow", "axes": ["z"], "upper": [0.1]});
    for tasks in [
        json!([press, hold]),
        json!([with("axes", json!(["x", "rz"])), press]),
        json!([with("frame", json!("tool")), press]),
        json!([with("link", json!("panda_link4")), press]),
        json!([slow, press]),
    ] {
        let text = warned(&tasks);
        assert!(!text.contains("cannot press"), "{text}");
    }
}

#[test]
fn a_target_beyond_the_bounds_of_the_states_is_warned_of() {
    let service = Service::start();
    let warned = |bound: f64| {
        let mut controller = controller(&law());
        controller["state_checks"] = json!({"max_force_n": bound});
        service.call("/v1/controllers", &controller)["warnings"].to_string()
    };
    assert!(warned(14.0).contains("presses with up to 15 N, and states above `state_checks.max_force_n`, 14 N"));
    assert!(!warned(15.0).contains("state_checks"));
}

#[test]
fn an_answer_tells_the_force_and_what_begins() {
    let service = Service::start();
    let session = service.open(&controller(&law()));
    let contact = |sequence, force| {
        service.call(&format!("{session}/step"), &state(sequence, &START, force))["tasks"][0]["contact"][0].clone()
    };
    assert_eq!(contact(1, 0.0).get("event"), None);
    let touch = contact(2, -3.0);
    assert_eq!(
        (&touch["event"], &touch["force"], &touch["target_force"]),
        (&json!("contact"), &json!(3.0), &json!(15.0))
    );
    assert_eq!(contact(3, -3.0).get("event"), None);
    // One reading without a force may be noise.
    let lost = (4..20).find(|&sequence| contact(sequence, 0.0)["event"] == "loss").unwrap();
    assert!((5..10).contains(&lost), "{lost}");
    assert_eq!(contact(lost + 1, 9.0)["event"], "fault");
}
