//! Streamed targets through the service.

use serde_json::{Value, json};

use crate::harness::{Service, example, numbers, without};
use crate::stream::Client;

const PERIODS: u64 = 600;

/// A controller with a target of every kind.
fn controller() -> Value {
    let still = json!({"kind": "constant", "value": 0.0});
    json!({"robot": "sawyer_dh", "period_s": 0.001, "tasks": [
        {"name": "hand", "axes": ["x", "y", "z"], "frame": {"position": [0.1, 0.2, 0.3], "orientation":
            {"w": 0.6, "x": 0.0, "y": 0.0, "z": 0.8}}, "law": {"kind": "pose", "gain": 5}},
        {"name": "touch", "axes": ["rx", "ry"], "law": {"kind": "hybrid", "inertia": 15, "damping": 150, "stiffness": 100,
            "position_controlled": [true, false], "target_force": still}},
        {"name": "turn", "axes": ["rz"], "frame": "tool", "law": {"kind": "velocity", "target_velocity": still},
            "streaming": {"hold_after_s": 0.03, "brake_after_s": 0.06, "delay_s": 0.01, "smoothing_s": 0}},
        {"name": "elbow", "law": {"kind": "posture", "gain": 2, "joints": ["j2", "j4"], "target_position": still}}]})
}

/// Targets of all tasks at 45 Hz, 0 to 6 ms late, with an interval without targets; the last ones are out of order.
fn targets(sequence: u64) -> Value {
    let late = 2 * (sequence / 22) % 7;
    if sequence % 22 != late || (200..480).contains(&sequence) {
        return json!({});
    }
    let mut time_s = 0.001 * (sequence - late) as f64;
    if sequence > 550 {
        time_s -= 0.1;
    }
    let half: f64 = 0.1 * time_s;
    let turned = json!({"w": half.cos(), "x": half.sin(), "y": 0.0, "z": 0.0});
    json!({
        "hand": {"time_s": time_s, "pose": {"position": [0.5, 0.2 * time_s, 0.1]}, "velocity": [0.0, 0.2, 0.0]},
        "touch": {"time_s": time_s, "pose": {"orientation": turned}, "force": [0.0, 0.5 * time_s]},
        "turn": {"velocity": [0.1]},
        "elbow": {"time_s": time_s, "joint_position": {"j4": 2.1 - time_s, "j2": -0.4 + time_s}},
    })
}

/// Runs a closed loop of an ideal arm with targets. Returns the answers without their times.
fn closed_loop(mut step: impl FnMut(Value) -> Value) -> Vec<Value> {
    let mut position = numbers(&example("state.json")["joint_position"]);
    let period = |sequence: u64| {
        let wrench = json!({"force": [1.0, 2.0, -3.0], "torque": [0.1, 0.0, -0.7]});
        let mut state = json!({"sequence": sequence, "time_s": sequence as f64 * 0.001, "joint_position": position,
            "wrench": wrench});
        let targets = targets(sequence);
        if targets != json!({}) {
            state["targets"] = targets;
        }
        let answer = without(step(state), &["elapsed_us"]);
        let velocity = numbers(&answer["joint_velocity"]);
        position.iter_mut().zip(velocity).for_each(|(q, qdot)| *q += 0.001 * qdot);
        answer
    };
    (0..PERIODS).map(period).collect()
}

#[test]
fn sessions_streams_and_stateless_steps_give_the_same_bytes_with_targets() {
    let service = Service::start();
    let address = format!("{}/step", service.open(&controller()));
    let session = closed_loop(|state| service.call(&address, &state));
    let mut memory = Value::Null;
    let stateless = closed_loop(|state| {
        let answer = service.call("/v1/step", &json!({"controller": controller(), "state": state, "memory": memory}));
        memory = answer["memory"].clone();
        without(answer, &["memory"])
    });
    assert_eq!(memory["target_streams"].as_array().unwrap().len(), 5);
    let mut stream = Client::open(&service, &service.open(&controller()), None);
    let streamed = closed_loop(|state| stream.call(&state.to_string()));
    for (other, name) in [(stateless, "stateless"), (streamed, "stream")] {
        let different = session.iter().zip(&other).find(|(a, b)| a.to_string() != b.to_string());
        assert_eq!(different, None, "{name}");
    }
    for k in 0..4 {
        let state = |answer: &Value| answer["tasks"][k]["target_state"].as_str().unwrap().to_owned();
        let mut states: Vec<String> = session.iter().map(state).collect();
        states.dedup();
        for expected in ["following", "extrapolating", "holding", "braking"] {
            assert!(states.iter().any(|state| state == expected), "task {k}: {expected} is not in {states:?}");
        }
    }
}

#[test]
fn late_and_ignored_targets_have_warnings() {
    let service = Service::start();
    let address = format!("{}/step", service.open(&controller()));
    let answers = closed_loop(|state| service.call(&address, &state));
    let warned = |from: usize, to: usize, part: &str| {
        answers[from..to].iter().any(|answer| answer["warnings"].to_string().contains(part))
    };
    assert!(warned(0, 600, "task `hand` holds its last target") && warned(0, 600, "task `hand` brakes to rest"));
    assert!(!warned(0, 200, "task `hand` brakes to rest"));
    assert!(warned(551, 600, "is ignored, because it is not newer than the last one, of"));
    let age = answers[300]["tasks"][0]["target_age_s"].as_f64().unwrap();
    assert!(age > 0.1 && age < 0.13, "{age} s");
}

#[test]
fn a_task_without_targets_reports_none_and_keeps_its_own_target() {
    let service = Service::start();
    let mut state = example("state.json");
    let step = |state: &Value| {
        let address = format!("{}/step", service.open(&example("controller.json")));
        without(service.call(&address, state), &["elapsed_us"])
    };
    let without_targets = step(&state);
    state["targets"] = json!({});
    assert_eq!(step(&state), without_targets);
    assert!(without_targets["tasks"][0].get("target_state").is_none());
    state["targets"] = json!({"push": {"force": [12.0]}});
    let answer = step(&state);
    assert_eq!(answer["tasks"][0]["target_force"], json!([12.0]));
    assert_eq!(answer["tasks"][0]["target_state"], "following");
    assert_eq!(answer["tasks"][0]["target_age_s"], 0.0);
    assert!(answer["tasks"][1].get("target_state").is_none());
}

#[test]
fn a_refusal_says_what_the_task_accepts() {
    let service = Service::start();
    let refusal = |targets: Value| {
        let mut state = example("state.json");
        state["targets"] = targets;
        let answer = service.post(&format!("{}/step", service.open(&controller())), &state.to_string());
        answer.assert_refused(422, answer.json()["pointer"].as_str());
        answer.json()["detail"].as_str().unwrap().to_owned()
    };
    assert!(refusal(json!({"head": {"force": [1]}})).contains("`hand`, `touch`, `turn`, `elbow`"));
    assert!(
        refusal(json!({"touch": {"joint_position": [1]}})).contains("`pose`, if known with its `velocity`, or `force`")
    );
    assert!(
        refusal(json!({"elbow": {"joint_position": {"j1": 0.0}}})).contains("has no joint `j1`; its joints: j2, j4")
    );
    assert!(refusal(json!({"elbow": {"joint_position": {"j2": 0.0}}})).contains("`j4` is missing"));
    assert!(refusal(json!({"turn": {"velocity": [0.1], "time_s": 2.0}})).contains("at most 1 s"));
}

#[test]
fn a_damaged_memory_of_targets_is_refused() {
    let service = Service::start();
    let body = |memory: Value, sequence: u64| {
        let targets = json!({"hand": {"pose": {"position": [0.5, 0.2, 0.1]}}, "turn": {"velocity": [0.1]}});
        let state = json!({"sequence": sequence, "time_s": 0.001 * sequence as f64, "targets": targets,
            "joint_position": example("state.json")["joint_position"],
            "wrench": {"force": [0.0, 0.0, 0.0], "torque": [0.0, 0.0, 0.0]}});
        json!({"controller": controller(), "state": state, "memory": memory})
    };
    let memory = service.call("/v1/step", &body(Value::Null, 1))["memory"].clone();
    service.call("/v1/step", &body(memory.clone(), 2));
    for (at, value, pointer) in [
        ("/target_streams/0/task", json!("head"), "/memory/target_streams/0/task"),
        ("/target_streams/0/task", json!("turn"), "/memory"),
        ("/target_streams/0/quantity", json!("force"), "/memory"),
        ("/target_streams/0/quantity", json!("colour"), "/memory/target_streams/0/quantity"),
        ("/target_streams/0/reference/velocity", json!([0.0]), "/memory"),
        ("/target_streams/0/reference/pose/orientation/w", json!(3.0), "/memory"),
        ("/target_streams/0/newest/time_s", json!(1e308), "/memory/target_streams/0/newest/time_s"),
        ("/target_streams/1/newest/values", json!([0.0, 0.0]), "/memory"),
        ("/target_streams/1/newest/values", json!(null), "/memory/target_streams/1/newest"),
        ("/target_streams/1/reference", json!([]), "/memory/target_streams/1/reference"),
    ] {
        let mut damaged = memory.clone();
        *damaged.pointer_mut(at).unwrap() = value;
        let answer = service.post("/v1/step", &body(damaged, 2).to_string());
        answer.assert_refused(422, Some(pointer));
    }
}
