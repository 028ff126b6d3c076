//! The optional `why` of answers: sentences about what restricts a command, and what its tasks give up.

use serde_json::{Value, json};

use crate::harness::{Service, example};

fn sentences(answer: &Value) -> Vec<&str> {
    answer["why"].as_array().into_iter().flatten().map(|sentence| sentence.as_str().unwrap()).collect()
}

/// Asks joint 1 of `planar_3r` to move at `velocity` (rad/s) from `position` (rad), and returns the sentences.
fn of_joint_1(service: &Service, position: f64, velocity: f64, limits: &Value) -> Vec<String> {
    let request = json!({
        "robot": "planar_3r", "joint_position": [position, 0.5, 0.4], "joint_velocity": [0, 0, 0], "period_s": 0.01,
        "limits": limits, "why": true,
        "tasks": [{"name": "turn", "jacobian": [[1, 0, 0]], "velocity": [velocity]}],
    });
    let answer = service.call("/v1/resolve", &request);
    sentences(&answer).into_iter().map(str::to_owned).collect()
}

#[test]
fn the_limit_of_a_joint_is_named() {
    let service = Service::start();
    let (all, behind) = (json!("position_velocity_acceleration"), json!("position_velocity"));
    let fixed = json!({"lower": [-1, -1, -1], "upper": [0.25, 1, 1]});
    for (position, velocity, limits, limit) in [
        (0.0, 5.0, json!("velocity"), "joint `shoulder` is at its speed limit of 2.0 rad/s"),
        (0.0, -5.0, behind.clone(), "joint `shoulder` is at its speed limit of 2.0 rad/s"),
        (2.799, 5.0, json!("velocity"), "joint `shoulder` is at its speed limit of 2.0 rad/s"),
        (2.8, 1.0, behind.clone(), "joint `shoulder` is at its upper limit"),
        (-2.8, -1.0, all.clone(), "joint `shoulder` is at its lower limit"),
        (2.85, 0.0, behind.clone(), "joint `shoulder` is beyond its upper limit and must move back"),
        // At full speed, which is a speed limit as well.
        (3.3, 0.0, behind.clone(), "joint `shoulder` is beyond its upper limit and must move back"),
        (0.0, 1.0, all, "joint `shoulder` is at its acceleration limit"),
        (2.7, 2.0, behind, "joint `shoulder` brakes before its upper limit, at 1.2 rad/s"),
        (0.0, 1.0, fixed, "joint `shoulder` is at its upper velocity bound of 0.25 rad/s"),
    ] {
        let sentences = of_joint_1(&service, position, velocity, &limits);
        assert_eq!(sentences[0], limit, "{position} {velocity} {limits}: {sentences:?}");
        assert!(sentences[1].starts_with("task `turn` gives up "), "{sentences:?}");
    }
}

#[test]
fn the_velocity_limit_near_an_end_is_named() {
    let service = Service::start();
    for (position, limit) in [
        (1.6, "joint `fr3_joint2` is at its velocity limit near the upper end of its range, 0.76 rad/s"),
        (-1.6, "joint `fr3_joint2` is at its velocity limit near the lower end of its range, 0.76 rad/s"),
        (1.78, "joint `fr3_joint2` is as near to its upper limit as its velocity envelope allows"),
        (1.79, "joint `fr3_joint2` is nearer to its upper limit than its velocity envelope allows and must move back"),
        (1.8, "joint `fr3_joint2` is beyond its upper limit and must move back"),
    ] {
        let turn = json!([0, f64::signum(position), 0, 0, 0, 0, 0]);
        let request = json!({
            "robot": "fr3", "joint_position": [0, position, 0, -1.5, 0, 1.5, 0], "period_s": 0.01, "why": true,
            "tasks": [{"name": "turn", "jacobian": [turn], "velocity": [2.0]}],
        });
        let answer = service.call("/v1/resolve", &request);
        assert_eq!(sentences(&answer)[0], limit, "{answer}");
    }
}

#[test]
fn the_velocity_that_a_task_gives_up_has_its_unit() {
    let service = Service::start();
    let fast = json!({
        "robot": "sawyer_dh", "joint_position": [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2], "limits": "velocity", "why": true,
        "tasks": [{"name": "fly", "axes": ["x", "y", "z", "rx", "ry", "rz"], "velocity": [5, 0, 0, 0, 0, 9]}],
    });
    let answer = service.call("/v1/resolve", &fast);
    let outcome = &answer["tasks"][0];
    let missing = |rows: std::ops::Range<usize>| {
        let square = |row: usize| {
            (outcome["achieved"][row].as_f64().unwrap() - outcome["requested"][row].as_f64().unwrap()).powi(2)
        };
        rows.map(square).sum::<f64>().sqrt()
    };
    let last = sentences(&answer).pop().unwrap();
    let words: Vec<&str> = last.split(' ').collect();
    assert_eq!([&words[..4], &words[5..7], &words[8..]].concat().join(" "), "task `fly` gives up m/s and rad/s");
    for (word, norm) in [(words[4], missing(0..3)), (words[7], missing(3..6))] {
        let given: f64 = word.parse().unwrap();
        assert!((given - norm).abs() <= 0.05 * norm, "{last}: {norm}");
    }
}

#[test]
fn prismatic_joints_move_in_metres() {
    let service = Service::start();
    let urdf = r#"<robot name="rail"><link name="a"/><link name="b"/><joint name="slide" type="prismatic"><parent link="a"/>
        <child link="b"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="0.5" effort="9"/></joint></robot>"#;
    service.post("/v1/robots", &json!({"name": "rail", "urdf": urdf}).to_string()).accepted();
    let request = json!({
        "robot": "rail", "joint_position": [0], "limits": "velocity", "why": true,
        "tasks": [{"name": "go", "axes": ["x"], "velocity": [0.75]}],
    });
    let answer = service.call("/v1/resolve", &request);
    assert_eq!(sentences(&answer), ["joint `slide` is at its speed limit of 0.50 m/s", "task `go` gives up 0.25 m/s"]);
}

#[test]
fn conflicts_and_singular_postures_are_told_from_limits() {
    let service = Service::start();
    let planar = |position: [f64; 3], tasks: Value| {
        let request =
            json!({"robot": "planar_3r", "joint_position": position, "limits": "none", "why": true, "tasks": tasks});
        let answer = service.call("/v1/resolve", &request);
        sentences(&answer).join("; ")
    };
    let task = |name: &str, velocity: f64| json!({"name": name, "axes": ["x"], "velocity": [velocity]});
    let bent = [0.3, 0.5, 0.4];
    assert_eq!(planar(bent, json!([task("a", 0.1)])), "no limit is active; every task is achieved");
    assert_eq!(
        planar(bent, json!([task("a", 0.1), task("b", 0.3)])),
        "the tasks are in conflict; task `b` gives up 0.20 m/s"
    );
    assert_eq!(
        planar([0.0; 3], json!([{"name": "a", "axes": ["x", "y"], "velocity": [0.1, 0]}])),
        "the posture is singular: task `a` can move in 1 of 2 directions; task `a` gives up 0.10 m/s"
    );
    let damped = json!({
        "robot": "planar_3r", "joint_position": [0.3, 0.02, 0.02], "limits": "none", "why": true,
        "damping": {"threshold": 0.05, "max_factor": 0.1},
        "tasks": [{"name": "a", "axes": ["x", "y"], "velocity": [0.1, 0]}],
    });
    let answer = service.call("/v1/resolve", &damped);
    let first = sentences(&answer)[0];
    assert!(first.starts_with("the arm is near a singularity: the smallest singular value is 0.0"), "{first}");
    assert!(first.ends_with("damping starts below 0.050"), "{first}");
}

#[test]
fn a_posture_below_all_other_tasks_gives_way_without_a_conflict() {
    let service = Service::start();
    let said = |tasks: Value| {
        let controller = json!({"robot": "panda", "period_s": 0.01, "why": true, "tasks": tasks});
        let state = json!({"sequence": 0, "time_s": 0, "joint_position": [0, -0.5, 0, -2, 0, 1.6, 0.7], "joint_velocity": [0, 0, 0, 0, 0, 0, 0]});
        let answer = service.call("/v1/step", &json!({"controller": controller, "state": state}));
        sentences(&answer).join("; ")
    };
    let rest = json!({"kind": "constant", "value": [0, -0.5, 0, -2, 0, 1.6, 0.702]});
    let posture = json!({"name": "rest", "law": {"kind": "posture", "gain": 1, "target_position": rest}});
    let still = json!({"name": "still", "axes": ["x", "y", "z", "rx", "ry", "rz"], "law": {"kind": "pose", "gain": 2}});
    let text = said(json!([still, posture]));
    assert!(text.starts_with("every task above is achieved; task `rest` gives up 0.00"), "{text}");
    assert!(text.ends_with(" rad/s, since it has the motion that is left"), "{text}");
    // Above other tasks, a posture makes them give way: that is a conflict.
    let moved = json!({"name": "move", "axes": ["x", "y", "z"], "law": {"kind": "velocity", "target_velocity": {"kind": "constant", "value": [0.01, 0, 0]}}});
    let text = said(json!([posture, moved]));
    assert!(text.contains("task `move` gives up") && !text.contains("every task"), "{text}");
}

#[test]
fn the_states_of_a_contact_are_told_with_their_forces() {
    let service = Service::start();
    let press = |axis: &str| {
        let law = json!({"kind": "contact", "target_force": {"kind": "constant", "value": 10}, "max_force": 40});
        let tasks = json!([{"name": "press", "axes": [axis], "law": law}]);
        service.open(&json!({"robot": "planar_3r", "period_s": 0.01, "why": true, "tasks": tasks}))
    };
    let said = |address: &str, readings: &[[f64; 2]], first: usize| {
        let mut last = String::new();
        for (k, [force, torque]) in readings.iter().enumerate() {
            let sequence = first + k;
            let state = json!({
                "sequence": sequence, "time_s": 0.01 * sequence as f64, "joint_position": [0.3, 0.5, 0.4],
                "joint_velocity": [0, 0, 0], "wrench": {"force": [force, 0, 0], "torque": [0, 0, torque]},
            });
            last = sentences(&service.call(&format!("{address}/step"), &state)).join("; ");
        }
        last
    };
    let address = press("x");
    assert_eq!(said(&address, &[[0.0; 2]; 2], 0), "task `press` approaches its surface: 0 of 10 N");
    let pressing = [[10.0, 0.0], [10.2, 0.0], [9.9, 0.0], [10.1, 0.0]].repeat(3);
    assert_eq!(said(&address, &pressing, 2), "no limit is active; every task is achieved");
    assert_eq!(said(&address, &[[8.0, 0.0]], 14), "task `press` presses: 8.0 of 10 N");
    assert_eq!(said(&address, &pressing[..1], 15), "no limit is active; every task is achieved");
    // The tool has not moved, so its stiffness is not known, and the surface is soon given up.
    let lost: Vec<_> = (16..36).map(|first| said(&address, &[[0.05, 0.0]], first)).collect();
    assert!(lost.iter().any(|text| text == "task `press` has lost its surface: 0.050 of 10 N"), "{lost:?}");
    assert_eq!(lost.last().unwrap(), "task `press` approaches its surface: 0.050 of 10 N");
    assert_eq!(said(&address, &[[60.0, 0.0]], 36), "task `press` has given its contact up: 60 of 10 N");
    assert_eq!(said(&press("rz"), &[[0.0, 0.0]], 0), "task `press` approaches its surface: 0 of 10 N·m");
}

#[test]
fn only_callers_that_want_sentences_get_them() {
    let service = Service::start();
    let resolve = service.call("/v1/resolve", &example("resolve_limits.json"));
    let step = service.call("/v1/step", &example("step.json"));
    assert!(resolve.get("why").is_none() && step.get("why").is_none());
}

#[test]
fn sessions_and_stateless_steps_give_the_same_sentences() {
    let service = Service::start();
    let mut controller = example("controller.json");
    controller["why"] = json!(true);
    controller["tasks"][0]["law"]["target_force"]["value"] = json!([3000]);
    controller["limits"] = json!("position_velocity_acceleration");
    let state = example("state.json");
    let stateless = service.call("/v1/step", &json!({"controller": controller, "state": state}));
    let session = service.call(&format!("{}/step", service.open(&controller)), &state);
    assert_eq!(sentences(&session), sentences(&stateless));
    let joints = sentences(&session).iter().filter(|text| text.ends_with("is at its acceleration limit")).count();
    assert!(joints > 0, "{session}");
    assert!(sentences(&session).iter().any(|text| text.starts_with("task `push` gives up ")), "{session}");
    // A replacement without `why` ends the sentences.
    let address = service.open(&controller);
    controller.as_object_mut().unwrap().remove("why");
    let headers = [("content-type", "application/json")];
    assert_eq!(service.send("PUT", &address, &headers, &controller.to_string()).status, 200);
    assert!(service.call(&format!("{address}/step"), &state).get("why").is_none());
}

/// More rows than joints: a posture below is what the guides advise.
#[test]
fn a_retreat_tells_which_tasks_it_has_released() {
    let service = Service::start();
    let law = json!({"kind": "contact", "target_force": {"kind": "constant", "value": 10}, "max_force": 40});
    let rest = json!({"kind": "constant", "value": [0.3, 0.5, 0.4]});
    let posture = json!({"kind": "posture", "gain": 1, "target_position": rest});
    let tasks = json!([
        {"name": "hold", "axes": ["y"], "law": {"kind": "pose", "gain": 2}},
        {"name": "press", "axes": ["x"], "law": law},
        {"name": "rest", "law": posture},
    ]);
    let address = service.open(&json!({"robot": "planar_3r", "period_s": 0.01, "why": true, "tasks": tasks}));
    for sequence in 0..3 {
        let state = json!({
            "sequence": sequence, "time_s": 0.01 * f64::from(sequence), "joint_position": [0.3, 0.5, 0.4],
            "joint_velocity": [0, 0, 0], "wrench": {"force": [80, 0, 0], "torque": [0, 0, 0]},
        });
        let answer = service.call(&format!("{address}/step"), &state);
        let told = sentences(&answer);
        let released = "task `hold` asks for nothing, because task `press` has given its contact up";
        assert!(told.contains(&released), "{told:?}");
        assert!(told.contains(&"task `press` has given its contact up: 80 of 10 N"), "{told:?}");
        assert!(answer["singularity"]["smallest_singular_value"].as_f64().unwrap() > 0.1, "{answer}");
        assert!(answer["tasks"][1]["achieved"][0].as_f64().unwrap() < 0.0, "{answer}");
    }
}

/// Without a control period the default are the speed limits, and they do not move a joint back.
#[test]
fn the_limits_that_apply_without_a_period_are_those_of_speed() {
    let service = Service::start();
    let request = json!({
        "robot": "planar_3r", "joint_position": [3.0, 0.5, 0.4], "why": true,
        "tasks": [{"name": "turn", "jacobian": [[1, 0, 0]], "velocity": [5]}],
    });
    let answer = service.call("/v1/resolve", &request);
    assert_eq!(answer["joint_velocity"][0], json!(2.0));
    assert_eq!(sentences(&answer)[0], "joint `shoulder` is at its speed limit of 2.0 rad/s");
}
