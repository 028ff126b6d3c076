//! Numbers in the wrong unit, methods that do not keep the order, missing limits: warned about in every route. Clocks of Unix.

use serde_json::{Value, json};

use crate::harness::{Service, example, numbers};

/// A period of a power of two, s, so that times are exact on every clock.
const PERIOD: f64 = 1.0 / 128.0;

/// Returns the warnings of an answer in one text.
fn warnings(answer: &Value) -> String {
    let list = answer.get("warnings").and_then(Value::as_array).cloned().unwrap_or_default();
    list.iter().map(|warning| warning.as_str().unwrap().to_owned() + "\n").collect()
}

fn pose_task(name: &str, position: &Value) -> Value {
    let pose = json!({"position": position, "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}});
    json!({"name": name, "axes": ["x", "y", "z"], "law": {"kind": "pose", "gain": 2, "target_pose": pose}})
}

/// Returns a controller of these tasks on the arm of the examples.
fn controller(tasks: &[Value]) -> Value {
    json!({"robot": "sawyer_dh", "period_s": PERIOD, "tasks": tasks})
}

fn created(service: &Service, controller: &Value) -> String {
    warnings(&service.call("/v1/controllers", controller))
}

/// Returns the warnings of the first and of the second stateless step.
fn stateless(service: &Service, controller: &Value) -> [String; 2] {
    let mut state = example("state.json");
    let first = service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": null}));
    state["sequence"] = json!(state["sequence"].as_u64().unwrap() + 1);
    state["time_s"] = json!(state["time_s"].as_f64().unwrap() + PERIOD);
    let second =
        service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": first["memory"]}));
    [warnings(&first), warnings(&second)]
}

#[test]
fn a_controller_with_numbers_in_the_wrong_unit_is_warned_about() {
    let service = Service::start();
    let posture = |q: f64| {
        json!({"name": "posture", "law": {"kind": "posture", "gain": 2, "joints": ["right_j0"],
               "target_position": {"kind": "constant", "value": q}}})
    };
    let law = |axes: Value, law: Value| json!({"name": "hand", "axes": axes, "law": law});
    let displaced = |value: f64, axis: &str| {
        let profile = json!({"kind": "ramp", "start": 0, "end": value, "duration_s": 1});
        law(json!([axis]), json!({"kind": "pose", "gain": 2, "target_displacement": profile}))
    };
    let moves = |value: f64, axis: &str| {
        law(json!([axis]), json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": value}}))
    };
    let joint = service.get("/v1/robots/sawyer_dh").accepted()["joints"][0]["name"].as_str().unwrap().to_owned();
    let named = |mut task: Value| {
        task["law"]["joints"] = json!([joint]);
        task
    };
    for (task, part) in [
        (pose_task("hand", &json!([500.0, 0.0, 0.3])), "its target is 500.0 m from the base"),
        (pose_task("hand", &json!([600, -20, 300])), "not in mm"),
        (named(posture(90.0)), "not in degrees"),
        (displaced(300.0, "x"), "not in mm"),
        (displaced(45.0, "rz"), "not in degrees"),
        (moves(100.0, "x"), "not in mm/s"),
        (moves(90.0, "rz"), "not in °/s"),
    ] {
        let controller = controller(std::slice::from_ref(&task));
        let found = created(&service, &controller);
        assert!(found.contains(part) && found.lines().count() == 1, "{task}: {found}");
        let [first, second] = stateless(&service, &controller);
        assert_eq!((first, second), (found, String::new()), "{task}");
    }
    for task in [
        pose_task("hand", &json!([2.0, 0.0, 0.3])),
        named(posture(1.0)),
        displaced(0.5, "x"),
        displaced(3.0, "rz"),
        moves(2.0, "x"),
        moves(6.0, "rz"),
    ] {
        assert_eq!(created(&service, &controller(&[task])), "");
    }
}

#[test]
fn speeds_of_contacts_and_of_sines_in_millimetres_are_warned_about() {
    let service = Service::start();
    let pressing = |changes: Value| {
        let mut law = json!({"kind": "contact", "target_force": {"kind": "constant", "value": -10}});
        law.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
        json!({"name": "push", "axes": ["z"], "law": law})
    };
    let sweeping = |rate: f64| {
        let way = json!({"kind": "sine", "offset": 0.05, "amplitude": 0.05, "angular_frequency_rad_s": rate});
        json!({"name": "wipe", "axes": ["x"], "law": {"kind": "pose", "gain": 2, "target_displacement": way}})
    };
    for (task, part) in [
        (pressing(json!({"approach_speed": 20})), "an approach with 20 m/s hits hard"),
        (pressing(json!({"retreat_speed": 50})), "a retreat with 50 m/s hits hard"),
        (sweeping(1000.0), "50 m/s along x is faster than arms are"),
    ] {
        let found = created(&service, &controller(&[task]));
        assert!(found.contains(part), "{part}: {found}");
    }
    for task in [pressing(json!({"approach_speed": 0.1, "retreat_speed": 0.3})), sweeping(20.0)] {
        let found = created(&service, &controller(&[task]));
        assert!(!found.contains("mm/s"), "{found}");
    }
}

#[test]
fn a_frame_and_a_posture_of_the_null_space_are_checked_too() {
    let service = Service::start();
    let mut task = pose_task("hand", &json!([0.1, 0.0, 0.0]));
    let frame = |x: f64| json!({"position": [x, 0, 0], "orientation": {"w": 0, "x": 0, "y": 0, "z": 1}});
    task["frame"] = frame(0.5);
    assert_eq!(created(&service, &controller(&[task.clone()])), "");
    task["frame"] = frame(400.0);
    assert!(created(&service, &controller(&[task.clone()])).contains("399.9 m from the base"));
    let mut far = controller(&[pose_task("hand", &json!([0.5, 0.0, 0.3]))]);
    let degrees: Vec<f64> = numbers(&example("state.json")["joint_position"]).iter().map(|q| q.to_degrees()).collect();
    far["null_space_velocity"] = json!({"kind": "posture", "gain": 1, "joint_position": degrees});
    assert!(created(&service, &far).contains("null-space velocity"));
}

#[test]
fn a_streamed_target_in_the_wrong_unit_is_warned_about_when_it_arrives() {
    let service = Service::start();
    let task = json!({"name": "hand", "axes": ["x", "y", "z"], "law": {"kind": "pose", "gain": 2}});
    let path = service.open(&controller(&[task])) + "/step";
    let mut state = example("state.json");
    let mut send = |sequence: u64, position: Value, velocity: f64| {
        (state["sequence"], state["time_s"]) = (json!(sequence), json!(PERIOD * sequence as f64));
        state["targets"] = json!({"hand": {"pose": {"position": position}, "velocity": [0, velocity, 0]}});
        warnings(&service.call(&path, &state))
    };
    assert_eq!(send(1, json!([0.6, 0.1, 0.4]), 0.2), "");
    assert!(send(2, json!([600, 100, 400]), 0.2).contains("not in mm"));
    let fast = send(3, json!([0.6, 0.1, 0.4]), 200.0);
    assert!(fast.contains("task `hand`: its target moves: 200 m/s in row 2") && fast.contains("not in mm/s"), "{fast}");
}

#[test]
fn streamed_velocities_in_the_wrong_unit_are_warned_about() {
    let service = Service::start();
    let hand = json!({"name": "hand", "axes": ["x", "rz"], "law": {"kind": "velocity", "target_velocity": {"kind": "constant", "value": 0}}});
    let elbow = json!({"name": "elbow", "law": {"kind": "posture", "gain": 1, "joints": ["j3"], "target_position": {"kind": "constant", "value": 0.2}}});
    let path = service.open(&controller(&[hand, elbow])) + "/step";
    let mut state = example("state.json");
    state["targets"] = json!({
        "hand": {"velocity": [0.1, 90]},
        "elbow": {"joint_position": [0.2], "velocity": [30]},
    });
    let found = warnings(&service.call(&path, &state));
    assert!(found.contains("not in °/s") && found.contains("joint `j3` moves at 30 rad/s"), "{found}");
}

#[test]
fn a_target_ahead_in_the_wrong_unit_is_warned_about_when_it_arrives() {
    let service = Service::start();
    let task = json!({"name": "hand", "axes": ["x", "y", "z"], "law": {"kind": "pose", "gain": 2, "path": "joint"}});
    let path = service.open(&controller(&[task])) + "/step";
    let mut state = example("state.json");
    let pose = |position: Value| json!({"position": position});
    let ahead = json!([{"after_s": 0.1, "pose": pose(json!([600, 100, 400]))}]);
    state["targets"] = json!({"hand": {"pose": pose(json!([0.6, 0.1, 0.4])), "ahead": ahead}});
    assert!(warnings(&service.call(&path, &state)).contains("not in mm"));
}

/// Late on the clock of Unix, times that differ by 1 µs are equal. The cubic through the targets would have an interval of zero.
#[test]
fn targets_ahead_with_equal_times_on_the_clock_are_taken_once() {
    let service = Service::start();
    let task = json!({"name": "hand", "axes": ["x", "y", "z"], "law": {"kind": "pose", "gain": 2, "path": "joint"}});
    let path = service.open(&controller(&[task])) + "/step";
    let mut state = example("state.json");
    for period in 1..20_u32 {
        (state["sequence"], state["time_s"]) = (json!(period), json!(9.5e9 + PERIOD * f64::from(period)));
        let ahead: Vec<Value> = [1e-6, 2e-6, 0.1, 0.1 + 1.1e-6, 0.1 + 2.2e-6, 0.5]
            .map(|after_s| json!({"after_s": after_s, "pose": {"position": [0.6 + 0.1 * after_s, 0.1, 0.4]}}))
            .to_vec();
        state["targets"] = json!({"hand": {"pose": {"position": [0.6, 0.1, 0.4]}, "ahead": ahead}});
        let command = numbers(&service.call(&path, &state)["joint_velocity"]);
        assert!(command.iter().all(|velocity| velocity.abs() < 2.0), "{command:?}");
    }
}

#[test]
fn a_problem_with_numbers_in_the_wrong_unit_is_warned_about_alone_and_in_a_batch() {
    let service = Service::start();
    let q = numbers(&example("state.json")["joint_position"]);
    let problem = |velocity: Value, scale: f64| {
        json!({"robot": "sawyer_dh", "joint_position": q.iter().map(|q| q * scale).collect::<Vec<_>>(),
               "tasks": [{"axes": ["x", "rz"], "velocity": velocity}], "period_s": 0.01})
    };
    let idle = |motion: Value| {
        let mut problem = problem(json!([0.1, 0]), 1.0);
        problem["null_space_velocity"] = motion;
        problem
    };
    let degrees: Vec<f64> = q.iter().map(|q| q.to_degrees()).collect();
    for (problem, part) in [
        (
            idle(json!({"kind": "posture", "joint_position": degrees, "gain": 1})),
            "null-space velocity: its target of joint",
        ),
        (idle(json!([0, 90, 0, 0, 0, 0, 0])), "null-space velocity: joint `j2` moves at 90 rad/s"),
        (problem(json!([300, 0]), 1.0), "task `task 1`: 300 m/s along x"),
        (problem(json!([0, 90]), 1.0), "not in °/s"),
        (problem(json!([0.1, 0]), 57.3), "not in degrees or mm"),
    ] {
        let found = warnings(&service.call("/v1/resolve", &problem));
        assert!(found.contains(part), "{problem}: {found}");
        let batch = service.call("/v1/resolve/batch", &json!({"items": [problem]}));
        assert_eq!(warnings(&batch["items"][0]), found);
    }
    let plain = service.call("/v1/resolve", &problem(json!([0.1, 0.2]), 1.0));
    assert!(plain.get("warnings").is_none(), "{plain}");
}

#[test]
fn without_a_method_the_order_is_strict_and_reverse_priority_says_that_it_is_not() {
    let service = Service::start();
    let task = |name: &str, axis: &str| json!({"name": name, "axes": [axis], "velocity": [0.1]});
    let tasks = [task("a", "x"), task("b", "y"), task("c", "rz")];
    let q = &example("state.json")["joint_position"];
    let mut problem = json!({"robot": "sawyer_dh", "joint_position": q, "tasks": tasks});
    let default = service.call("/v1/resolve", &problem);
    problem["method"] = json!("strict_reverse_priority");
    let strict = service.call("/v1/resolve", &problem);
    assert_eq!(default["joint_velocity"], strict["joint_velocity"]);
    assert!(default.get("warnings").is_none());
    problem["method"] = json!("reverse_priority");
    assert!(warnings(&service.call("/v1/resolve", &problem)).contains("does not keep the order of 3 tasks"));
    problem["tasks"].as_array_mut().unwrap().pop();
    assert!(service.call("/v1/resolve", &problem).get("warnings").is_none());

    let hold = |name: &str, axis: &str| json!({"name": name, "axes": [axis], "law": {"kind": "pose", "gain": 2}});
    let mut three = controller(&[hold("a", "x"), hold("b", "y"), hold("c", "rz")]);
    assert_eq!(created(&service, &three), "");
    three["method"] = json!("reverse_priority");
    assert!(created(&service, &three).contains("use `strict_reverse_priority`"));
    let [first, second] = stateless(&service, &three);
    assert!(first.contains("use `strict_reverse_priority`") && second.is_empty(), "{first} {second}");
}

#[test]
fn limits_without_accelerations_are_warned_about_if_the_robot_states_accelerations() {
    let service = Service::start();
    let mut request = controller(&[pose_task("hand", &json!([0.6, 0.1, 0.4]))]);
    for (limits, warns) in
        [("position_velocity", true), ("velocity", true), ("position_velocity_acceleration", false), ("none", false)]
    {
        request["limits"] = json!(limits);
        assert_eq!(created(&service, &request).contains("a drive may trip"), warns, "{limits}");
    }
}

/// On the clock of Unix, a loop gets the commands of the same loop from time zero: with a profile, streamed targets and late
/// states, in a session and without one. The times are exact on both clocks.
#[test]
fn on_the_clock_of_unix_the_commands_are_the_same() {
    let service = Service::start();
    let profile = json!({"kind": "sine", "offset": 0, "amplitude": 0.05, "angular_frequency_rad_s": 3});
    let path =
        json!({"name": "path", "axes": ["z"], "law": {"kind": "pose", "gain": 2, "target_displacement": profile}});
    let hand = json!({"name": "hand", "axes": ["x", "y"], "law": {"kind": "pose", "gain": 2}});
    let controllers = [None, Some("joint"), Some("straight")].map(|path_kind| {
        let mut controller = controller(&[path.clone(), hand.clone()]);
        for task in controller["tasks"].as_array_mut().unwrap() {
            if let Some(kind) = path_kind {
                task["law"]["path"] = json!(kind);
            }
        }
        controller
    });
    let run = |controller: &Value, start: f64, in_session: bool| {
        let session = in_session.then(|| service.open(controller) + "/step");
        let (mut q, mut memory, mut commands) =
            (numbers(&example("state.json")["joint_position"]), Value::Null, Vec::new());
        for period in 0..60_u32 {
            // A state is missing now and then.
            if period % 17 == 5 {
                continue;
            }
            let time = start + PERIOD * f64::from(period);
            let mut state = json!({"sequence": period + 1, "time_s": time, "joint_position": q});
            if period % 4 == 0 {
                let target =
                    |after: f64| json!({"position": [0.6 + 0.001 * f64::from(period) + 0.01 * after, 0.1, 0.4]});
                let ahead = json!([{"after_s": 0.25, "pose": target(0.25)}, {"after_s": 0.5, "pose": target(0.5)}]);
                state["targets"] =
                    json!({"hand": {"time_s": time - 2.0 * PERIOD, "pose": target(0.0), "ahead": ahead}});
            }
            let answer = match &session {
                Some(path) => service.call(path, &state),
                None => service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": memory})),
            };
            let command = numbers(&answer["joint_velocity"]);
            q.iter_mut().zip(&command).for_each(|(q, v)| *q += PERIOD * v);
            commands.push(command);
            memory = answer["memory"].clone();
        }
        commands
    };
    for controller in &controllers {
        let expected = run(controller, 0.0, true);
        assert!(expected.iter().flatten().any(|v| v.abs() > 0.01));
        for (start, in_session) in
            [(0.0, false), (0.0, true), (1_700_000_000.0, true), (1_700_000_000.0, false), (9_000_000_000.0, true)]
        {
            let found = run(controller, start, in_session);
            // The times ahead of laws with `path` are rounded to those of the clock, 0.2 to 2 µs.
            let looks_ahead = controller["tasks"][0]["law"].get("path").is_some();
            let pairs = found.iter().flatten().zip(expected.iter().flatten());
            let difference = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert_eq!(found.len(), expected.len());
            assert!(difference <= if looks_ahead { 1e-4 } else { 0.0 }, "{start} {in_session}: {difference:e}");
        }
    }
    let mut state = example("state.json");
    state["time_s"] = json!(1.7e12);
    let refused = service.post(&(service.open(&controllers[0]) + "/step"), &state.to_string());
    refused.assert_refused(422, Some("/time_s"));
    assert!(refused.text.contains("milliseconds"), "{}", refused.text);
}

/// A target beyond reach that the arm would come nearer to if it tilted its tool.
#[test]
fn a_first_task_whose_position_gives_way_to_its_orientation_says_so() {
    let service = Service::start();
    let q = numbers(&example("state.json")["joint_position"]);
    let tool = &service.call("/v1/kinematics", &json!({"robot": "sawyer_dh", "joint_position": q}))["pose"];
    let found = |axes: &[&str]| {
        let pose = json!({"position": [1.6, 0.3, 0.6], "orientation": tool["orientation"]});
        let task = json!({"name": "hand", "axes": axes, "law": {"kind": "pose", "gain": 2, "target_pose": pose}});
        let mut controller = controller(&[task]);
        controller["leave_local_minima"] = json!(false);
        controller["drive"] = json!({"lag_s": 0, "delay_periods": 0});
        let (path, mut q, mut found) = (service.open(&controller) + "/step", q.clone(), String::new());
        for period in 0..1500_u32 {
            let state = json!({"sequence": period, "time_s": PERIOD * f64::from(period), "joint_position": q});
            let answer = service.call(&path, &state);
            q.iter_mut().zip(numbers(&answer["joint_velocity"])).for_each(|(q, v)| *q += PERIOD * v);
            found += &warnings(&answer);
        }
        found
    };
    let both = found(&["x", "y", "z", "rx", "ry", "rz"]);
    assert!(both.contains("keeps its orientation rather than its position"), "{both}");
    assert_eq!(found(&["x", "y", "z"]), "");
}

#[test]
fn a_profile_that_ended_before_the_first_state_is_reported() {
    let service = Service::start();
    let point = |time_s: f64, value: f64| json!({"time_s": time_s, "value": [value]});
    for (profile, end_s) in [
        (json!({"kind": "waypoints", "points": [point(0.0, 0.0), point(2.0, 0.1)]}), 2.0),
        (json!({"kind": "steps", "points": [point(0.0, 0.0), point(3.0, 0.1)]}), 3.0),
        (json!({"kind": "ramp", "start": [0.0], "end": [0.1], "start_time_s": 1.0, "duration_s": 4.0}), 5.0),
    ] {
        let law = json!({"kind": "pose", "gain": 2, "target_pose": "initial", "target_displacement": profile});
        let controller = controller(&[json!({"name": "go", "axes": ["x"], "law": law})]);
        let first = |time_s: f64| {
            let mut state = example("state.json");
            state["time_s"] = json!(time_s);
            let answer =
                service.call("/v1/step", &json!({"controller": controller, "state": state.clone(), "memory": null}));
            state["sequence"] = json!(state["sequence"].as_u64().unwrap() + 1);
            let later = json!({"controller": controller, "state": state, "memory": answer["memory"]});
            let then = warnings(&service.call("/v1/step", &later));
            assert!(!then.contains("profile"), "{time_s}");
            assert_eq!(then.contains("`time_s` stands still"), time_s < end_s || time_s > 1e9, "{time_s}: {then}");
            warnings(&answer)
        };
        let report = format!("task `go`: its profile ended at {end_s} s, before the first state");
        assert!(first(5000.0).contains(&report), "{}", first(5000.0));
        // At its end, and on a clock with which profiles begin at the first state.
        for time_s in [0.0, end_s, 1.7e9] {
            assert!(!first(time_s).contains("profile"), "{time_s}");
        }
    }
}

#[test]
fn a_period_in_milliseconds_is_reported() {
    let service = Service::start();
    let law = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": [0.0]}});
    let with_period = |period_s: f64| {
        let tasks = [json!({"name": "go", "axes": ["x"], "law": law})];
        created(&service, &json!({"robot": "sawyer_dh", "period_s": period_s, "tasks": tasks}))
    };
    assert!(with_period(8.0).contains("`period_s` is 8 s") && !with_period(1.0).contains("`period_s` is"));
    assert!(with_period(0.0005).contains("counts whole milliseconds") && !with_period(0.001).contains("`period_s` is"));
}
