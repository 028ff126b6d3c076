//! Sessions and stateless steps give the same answers to the last bit.

use std::ops::ControlFlow;

use revprio_api::Client;
use revprio_lab::simulator::{CallMode, Scenario, run};
use serde_json::{Value, json};

use crate::harness::{Service, example, numbers, without};

const PERIODS: u64 = 200;

/// Runs a closed loop of an ideal arm under a varying wrench, with `step` as the service. Some states come late.
fn closed_loop(mut step: impl FnMut(Value) -> Value) -> Vec<String> {
    let mut position = numbers(&example("state.json")["joint_position"]);
    let mut passed = 0.0_f64;
    let period = |sequence: u64| {
        let time_s: f64 = passed * 0.001;
        let wrench = json!({"force": [40.0 * (50.0 * time_s).sin(), 7.0, -3.0 * time_s], "torque": [0.1, 0.0, -0.7]});
        let state = json!({"sequence": sequence, "time_s": time_s, "joint_position": position, "wrench": wrench});
        let answer = without(step(state), &["elapsed_us"]);
        let velocity = numbers(&answer["joint_velocity"]);
        let periods = if sequence % 20 == 19 { 3.0 } else { 1.0 };
        passed += periods;
        position.iter_mut().zip(velocity).for_each(|(q, qdot)| *q += 0.001 * periods * qdot);
        answer.to_string()
    };
    (0..PERIODS).map(period).collect()
}

fn by_session(service: &Service, controller: &Value) -> Vec<String> {
    let address = format!("{}/step", service.open(controller));
    closed_loop(|state| service.call(&address, &state))
}

/// Sends the memory with each request. It passes through JSON twice per period: in the service and in this client.
fn by_memory(service: &Service, controller: &Value) -> Vec<String> {
    let mut memory = Value::Null;
    closed_loop(|state| {
        let answer = service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": memory}));
        memory = answer["memory"].clone();
        without(answer, &["memory"])
    })
}

#[test]
fn sessions_and_stateless_steps_give_the_same_bytes() {
    let service = Service::start();
    let narrow = json!({"lower": vec![-0.005; 7], "upper": vec![0.005; 7]});
    for (solver, limits) in [("auto", json!("position_velocity")), ("auto", narrow.clone()), ("qp", narrow)] {
        let mut controller = example("controller.json");
        (controller["solver"], controller["limits"]) = (json!(solver), limits);
        let (session, memory) = (by_session(&service, &controller), by_memory(&service, &controller));
        let different = session.iter().zip(&memory).find(|(a, b)| a != b);
        assert_eq!(different, None, "{solver}");
    }
}

/// Returns a controller with everything a period can depend on: moving targets, frames, joints, null space.
fn general_controller() -> Value {
    let path = json!({"kind": "waypoints", "points": [{"time_s": 0.0, "value": 0.0},
        {"time_s": 0.1, "value": [0.01, -0.02]}, {"time_s": 0.2, "value": 0.005}]});
    json!({"robot": "sawyer_dh", "period_s": 0.001, "wrench_frame": "tool",
        "tool_offset": {"position": [0.0, 0.02, 0.1], "orientation": {"w": 0.8, "x": 0.0, "y": 0.6, "z": 0.0}},
        "null_space_velocity": {"kind": "joint_limits", "gain": 2.5},
        "tasks": [
            {"name": "yield", "axes": ["x", "rz"], "frame": "tool", "reference_point": [0.0, 0.01, 0.2], "law":
                {"kind": "impedance", "inertia": 15, "damping": 150, "stiffness": [1000, 200], "target_displacement": path}},
            {"name": "go", "axes": ["y"], "frame": {"position": [0.1, 0.2, 0.3], "orientation":
                {"w": 0.6, "x": 0.0, "y": 0.0, "z": 0.8}}, "law": {"kind": "pose", "gain": 3.7}},
            {"name": "rest", "law": {"kind": "posture", "gain": 1.3, "target_position": "mid_range"}}]})
}

#[test]
fn moving_targets_frames_and_postures_give_the_same_bytes_without_a_session() {
    let service = Service::start();
    let (session, memory) = (by_session(&service, &general_controller()), by_memory(&service, &general_controller()));
    assert_eq!(session.iter().zip(&memory).find(|(a, b)| a != b), None);
    let shown = service.get(&service.open(&general_controller())).accepted()["controller"].clone();
    assert_eq!(by_session(&service, &shown), session, "the shown controller differs");
}

/// The virtual arm, its line and the targets ahead are in the memory.
#[test]
fn laws_that_look_ahead_give_the_same_bytes_without_a_session() {
    let service = Service::start();
    for path in ["joint", "straight"] {
        let pose =
            |displacement: Value| json!({"kind": "pose", "gain": 5, "path": path, "target_displacement": displacement});
        let steps =
            json!({"kind": "steps", "points": [{"time_s": 0, "value": 0}, {"time_s": 0.05, "value": [0.1, 0, -0.1]}]});
        let sine = json!({"kind": "sine", "offset": 0, "amplitude": 0.1, "angular_frequency_rad_s": 3, "phase_rad": 0});
        for displacement in [steps, sine] {
            let tasks = json!([{"name": "hand", "axes": ["x", "y", "z"], "law": pose(displacement)}]);
            let controller = json!({"robot": "sawyer_dh", "period_s": 0.001, "tasks": tasks});
            let (session, memory) = (by_session(&service, &controller), by_memory(&service, &controller));
            assert_eq!(session.iter().zip(&memory).find(|(a, b)| a != b), None, "{path}");
        }
    }
    let request = example("step_straight.json");
    let memory = service.call("/v1/step", &request)["memory"].clone();
    for (pointer, value) in [
        ("/virtual_arm/postures/0", json!([0.0])),
        ("/virtual_arm/next", json!(0)),
        ("/virtual_arm/line/progress", json!(2)),
        ("/virtual_arm/line/speeds", json!([])),
    ] {
        let mut again = request.clone();
        (again["memory"], again["state"]["sequence"]) = (memory.clone(), json!(1));
        *again["memory"].pointer_mut(pointer).unwrap() = value;
        let answer = service.post("/v1/step", &again.to_string()).json();
        assert_eq!((&answer["status"], &answer["pointer"]), (&json!(422), &json!("/memory")), "{pointer}: {answer}");
    }
}

#[test]
fn simulations_with_and_without_a_session_are_equal() {
    let service = Service::start();
    let mut scenario = Scenario::find("stiff_wall").unwrap();
    scenario.duration_s = 0.45;
    let client = Client::new(&service.url());
    let samples = |mode| format!("{:?}", run(&scenario, &client, mode, |_| ControlFlow::Continue(())).unwrap().samples);
    assert!(samples(CallMode::Session) == samples(CallMode::Stateless), "the two runs differ");
}

#[test]
fn two_sessions_do_not_share_their_memory() {
    let service = Service::start();
    let alone = by_session(&service, &example("controller.json"));
    let sessions = [(); 2].map(|()| format!("{}/step", service.open(&example("controller.json"))));
    let together = closed_loop(|state| {
        service.call(&sessions[0], &state);
        service.call(&sessions[1], &state)
    });
    assert_eq!(alone, together);
}

#[test]
fn a_modified_memory_is_refused_or_harmless() {
    let service = Service::start();
    let mut request = example("step.json");
    let memory = service.call("/v1/step", &request)["memory"].clone();
    request["state"]["sequence"] = json!(18);
    let mut send = |pointer: &str, value: Value| {
        request["memory"] = memory.clone();
        *request["memory"].pointer_mut(pointer).unwrap() = value;
        service.post("/v1/step", &request.to_string())
    };
    for (pointer, value, status, expected) in [
        ("/sequence", json!(-1), 422, "/memory/sequence"),
        ("/task_velocities", json!([[0.0]]), 422, "/memory"),
        ("/task_velocities/0", json!([0.0, 0.0]), 422, "/memory"),
        ("/task_velocities/1/4", json!(1e300), 422, "/memory/task_velocities/1/4"),
        ("/last_command", json!([0.0]), 422, "/memory/last_command"),
        ("/drive/velocity", json!([0.0]), 422, "/memory/drive/velocity"),
        ("/drive/pending", json!([]), 422, "/memory"),
        ("/drive/pending/1", json!([0.0]), 422, "/memory/drive/pending/1"),
        ("/initial_pose/position/0", json!(1e300), 422, "/memory/initial_pose/position/0"),
        ("/initial_pose/rotation/0/0", json!(2.0), 422, "/memory/initial_pose/rotation"),
        ("/initial_pose/rotation/0", json!([1.0]), 422, "/memory/initial_pose/rotation/0"),
        ("/active_set", json!([[{"joint": "j9", "side": "upper"}]]), 422, "/memory/active_set"),
        ("/active_set", json!([[{"joint": "j1", "side": "up"}]]), 422, "/memory/active_set/0/0/side"),
        ("/sequence", json!(18), 409, "/state/sequence"),
    ] {
        send(pointer, value).assert_refused(status, Some(expected));
    }
    let all_joints: Vec<_> = (1..=7).map(|joint| json!({"joint": format!("j{joint}"), "side": "lower"})).collect();
    let many_levels = vec![all_joints; 40];
    for (pointer, value) in [("/active_set", json!(many_levels)), ("/last_command/0", json!(1e9))] {
        let velocity = numbers(&send(pointer, value).accepted()["joint_velocity"]);
        assert!(velocity.iter().all(|v| v.abs() < 5.0), "{velocity:?}");
    }
}

/// A memory that says for how long the command was held: afterwards the arm rests.
#[test]
fn a_memory_may_say_how_long_its_command_was_valid() {
    let service = Service::start();
    let mut controller = example("controller.json");
    controller["limits"] = json!("position_velocity_acceleration");
    let state = |sequence: u64, time_s: f64, position: &[f64]| {
        let wrench = json!({"force": [0, 0, 0], "torque": [0, 0, 0]});
        json!({"sequence": sequence, "time_s": time_s, "joint_position": position, "wrench": wrench})
    };
    let mut position = numbers(&example("state.json")["joint_position"]);
    let mut memory = Value::Null;
    for sequence in 0..30 {
        let state = state(sequence, sequence as f64 * 0.001, &position);
        let answer = service.call("/v1/step", &json!({"controller": controller, "state": state, "memory": memory}));
        memory = answer["memory"].clone();
        let velocity = numbers(&answer["joint_velocity"]);
        position.iter_mut().zip(velocity).for_each(|(q, qdot)| *q += 0.001 * qdot);
        assert_eq!(memory["valid_for_ms"], answer["valid_for_ms"]);
    }
    let last = numbers(&memory["last_command"]);
    let fastest = |values: &[f64]| values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    // The arm went on for the 100 ms for which its command was valid.
    let held: Vec<f64> = position.iter().zip(&last).map(|(q, v)| q + 0.1 * v).collect();
    let after = |memory: &Value| {
        let body = json!({"controller": controller, "state": state(31, 5.0, &held), "memory": memory});
        numbers(&service.call("/v1/step", &body)["memory"]["drive"]["velocity"])
    };
    let unknown = without(memory.clone(), &["valid_for_ms"]);
    let (known, unknown) = (after(&memory), after(&unknown));
    assert!(fastest(&known) < 0.2 * fastest(&unknown), "{known:?} {unknown:?} after {last:?}");
    memory["valid_for_ms"] = json!(10_001);
    let body = json!({"controller": controller, "state": state(31, 5.0, &held), "memory": memory});
    service.post("/v1/step", &body.to_string()).assert_refused(422, Some("/memory/valid_for_ms"));
}

/// What a sensor reads that fails is accepted, so the memory of that answer is accepted too.
#[test]
fn a_memory_after_a_huge_force_is_accepted() {
    let service = Service::start();
    let law = json!({"kind": "contact", "target_force": {"kind": "constant", "value": -15}, "surface": {}});
    let controller =
        json!({"robot": "panda", "period_s": 0.004, "tasks": [{"name": "press", "axes": ["z"], "law": law}]});
    let position = [0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8];
    for huge in [5e4, 1e7, 9e8] {
        let mut memory = Value::Null;
        for sequence in 0..120 {
            let force = [0.0, 0.0, if (40..60).contains(&sequence) { -huge } else { -12.0 }];
            let state = json!({"sequence": sequence, "time_s": f64::from(sequence) * 0.004, "joint_position": position,
                "wrench": {"force": force, "torque": [0, 0, 0]}});
            let body = json!({"controller": controller, "state": state, "memory": memory});
            let answer = service.post("/v1/step", &body.to_string()).accepted();
            assert!(numbers(&answer["joint_velocity"]).iter().all(|velocity| velocity.abs() < 3.0), "{answer}");
            memory = answer["memory"].clone();
        }
    }
}
