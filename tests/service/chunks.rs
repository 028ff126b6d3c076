//! Chunks of actions through the service.

use serde_json::{Value, json};

use crate::harness::{Service, example, numbers, without};
use crate::stream::Client;

/// A controller with a task for each kind of action.
fn controller() -> Value {
    let still = json!({"kind": "constant", "value": 0.0});
    json!({"robot": "sawyer_dh", "period_s": 0.004, "tasks": [
        {"name": "hand", "axes": ["x", "y", "z"], "law": {"kind": "pose", "gain": 5}, "streaming": {"fade_s": 0.2}},
        {"name": "touch", "axes": ["rx", "ry"], "law": {"kind": "hybrid", "inertia": 15, "damping": 150, "stiffness": 100,
            "position_controlled": [true, false], "target_force": still}},
        {"name": "elbow", "law": {"kind": "posture", "gain": 2, "joints": ["j2", "j4"], "target_position": still}}]})
}

/// Returns actions at 30 Hz from `start` on.
fn actions(start: f64, count: u32, action: impl Fn(f64) -> Value) -> Value {
    let action = |k| {
        let time_s = start + f64::from(k) / 30.0;
        let mut action = action(time_s);
        action["time_s"] = json!(time_s);
        action
    };
    (0..count).map(action).collect()
}

/// Chunks of all tasks every 0.4 s that are 0.2 s old; one of them is lost.
fn targets(sequence: u64) -> Value {
    if !sequence.is_multiple_of(100) || sequence == 300 {
        return json!({});
    }
    let look = 0.004 * sequence as f64 - 0.2;
    let bias = 0.02 * ((sequence / 100) % 2) as f64;
    let turned = |time: f64| json!({"w": (0.1 * time).cos(), "x": (0.1 * time).sin(), "y": 0.0, "z": 0.0});
    json!({
        "hand": {"align": "progress", "chunk": actions(look, 50, |time| json!({"position": [0.5, 0.1 * time + bias, 0.1]}))},
        "touch": {"chunk": actions(look, 30, |time| json!({"pose": {"orientation": turned(time)}, "force": [0.0, time]}))},
        "elbow": {"chunk": actions(look, 16, |time| json!({"joint_position": {"j4": 2.1 - time, "j2": -0.4 + time}}))},
    })
}

/// Runs a closed loop of an ideal arm with chunks. Returns the answers without their times.
fn closed_loop(mut step: impl FnMut(Value) -> Value) -> Vec<Value> {
    let mut position = numbers(&example("state.json")["joint_position"]);
    let period = |sequence: u64| {
        let wrench = json!({"force": [0.0, 0.0, 0.0], "torque": [0.1, 0.0, 0.0]});
        let mut state = json!({"sequence": sequence, "time_s": sequence as f64 * 0.004, "joint_position": position,
            "wrench": wrench});
        let targets = targets(sequence);
        if targets != json!({}) {
            state["targets"] = targets;
        }
        let answer = without(step(state), &["elapsed_us"]);
        let velocity = numbers(&answer["joint_velocity"]);
        position.iter_mut().zip(velocity).for_each(|(q, qdot)| *q += 0.004 * qdot);
        answer
    };
    (0..600).map(period).collect()
}

#[test]
fn sessions_streams_and_stateless_steps_give_the_same_bytes_with_chunks() {
    let service = Service::start();
    let address = format!("{}/step", service.open(&controller()));
    let session = closed_loop(|state| service.call(&address, &state));
    let mut memory = Value::Null;
    let stateless = closed_loop(|state| {
        let answer = service.call("/v1/step", &json!({"controller": controller(), "state": state, "memory": memory}));
        memory = answer["memory"].clone();
        without(answer, &["memory"])
    });
    assert_eq!(memory["target_streams"].as_array().unwrap().len(), 4);
    let mut stream = Client::open(&service, &service.open(&controller()), None);
    let streamed = closed_loop(|state| stream.call(&state.to_string()));
    for (other, name) in [(stateless, "stateless"), (streamed, "stream")] {
        let different = session.iter().zip(&other).find(|(a, b)| a.to_string() != b.to_string());
        assert_eq!(different, None, "{name}");
    }
    let chunk = |period: usize, task: usize| session[period]["tasks"][task]["chunk"].clone();
    assert!(chunk(0, 0)["shift_s"].as_f64().unwrap() > 0.0, "{}", chunk(0, 0));
    assert_eq!(chunk(100, 1)["dropped"], 7);
    assert_eq!(chunk(101, 1), json!({"actions_left": 23, "ends_in_s": chunk(101, 1)["ends_in_s"]}));
    // 16 actions of 30 Hz that are 0.2 s old end before the next chunk comes.
    assert_eq!(session[190]["tasks"][2]["target_state"], "holding");
    assert_eq!(session[101]["tasks"][2]["target_state"], "following");
}

#[test]
fn a_refusal_points_at_the_action() {
    let service = Service::start();
    let address = format!("{}/step", service.open(&controller()));
    let refusal = |targets: Value, pointer: &str, part: &str| {
        let mut state = example("state.json");
        state["targets"] = targets;
        let answer = service.post(&address, &state.to_string());
        answer.assert_refused(422, Some(pointer));
        let detail = answer.json()["detail"].as_str().unwrap().to_owned();
        assert!(detail.contains(part), "{detail}");
    };
    let hand = |chunk: Value| json!({"hand": {"chunk": chunk}});
    let at = |time_s: f64| json!({"time_s": time_s, "position": [0.5, 0.0, 0.1]});
    refusal(hand(json!([])), "/targets/hand/chunk", "needs an action");
    refusal(hand(json!([at(0.1), at(0.2), at(0.2)])), "/targets/hand/chunk/2/time_s", "and the one before it at 0.2 s");
    refusal(
        hand(json!([at(0.2), at(0.1)])),
        "/targets/hand/chunk/1/time_s",
        "due at 0.1 s, and the one before it at 0.2 s",
    );
    refusal(hand(json!([at(0.1), at(11.0)])), "/targets/hand/chunk/1/time_s", "in seconds, on the clock of the states");
    refusal(hand(json!([at(0.1), {"time_s": 0.2, "force": [1.0]}])), "/targets/hand/chunk/1/force", "task `hand`");
    refusal(
        hand(json!([at(0.1), {"time_s": 0.2}])),
        "/targets/hand/chunk/1",
        "an action of task `hand` has `position` and `orientation` as",
    );
    let orientation = json!({"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0});
    refusal(
        hand(json!([{"time_s": 0.1, "orientation": orientation}])),
        "/targets/hand/chunk/0",
        "needs the `position`",
    );
    let both = json!({"time_s": 0.1, "position": [0, 0, 0], "pose": {"position": [0, 0, 0]}});
    refusal(hand(json!([both])), "/targets/hand/chunk/0/pose", "not both");
    refusal(json!({"hand": {"time_s": 0.1, "chunk": [at(0.1)]}}), "/targets/hand/chunk", "stands alone");
    refusal(json!({"hand": {"align": "progress"}}), "/targets/hand/align", "for a `chunk`");
    let many: Value = (1..=257).map(|k| at(0.01 * f64::from(k))).collect();
    refusal(hand(many), "/targets/hand/chunk", "257 actions; give at most 256");
    let mixed =
        json!([{"time_s": 0.1, "force": [0.0, 1.0]}, {"time_s": 0.2, "force": [0.0, 1.0], "orientation": orientation}]);
    refusal(json!({"touch": {"chunk": mixed}}), "/targets/touch/chunk/1", "chunks of one kind");
    let fast = json!([{"time_s": 0.1, "velocity": [0.0, 0.0, 0.0]}]);
    refusal(hand(fast), "/targets/hand/chunk/0/velocity", "an action of task `hand` has `position`");
    let joints = json!([{"time_s": 0.1, "joint_position": [0.0]}]);
    refusal(json!({"elbow": {"chunk": joints}}), "/targets/elbow/chunk/0/joint_position", "1 numbers for 2 rows");
}

#[test]
fn a_late_chunk_is_ignored_with_a_warning() {
    let service = Service::start();
    let address = format!("{}/step", service.open(&controller()));
    let mut state = example("state.json");
    state["targets"] = json!({"hand": {"chunk": actions(-3.0, 16, |_| json!({"position": [0.5, 0.0, 0.1]}))}});
    let answer = service.call(&address, &state);
    assert!(
        answer["warnings"].to_string().contains("task `hand`: the chunk is ignored, because its last action was due")
    );
    // The task goes on with its own target.
    assert!(answer["tasks"][0].get("chunk").is_none() && answer["tasks"][0].get("target_state").is_none(), "{answer}");
}

#[test]
fn a_chunk_that_was_overtaken_is_ignored_with_a_warning() {
    let service = Service::start();
    let address = format!("{}/step", service.open(&controller()));
    let step = |sequence: u64, from: f64, x: f64| {
        let mut state = example("state.json");
        (state["sequence"], state["time_s"]) = (json!(sequence), json!(0.01 * sequence as f64));
        state["targets"] = json!({"hand": {"chunk": actions(from, 4, |_| json!({"position": [x, 0.0, 0.1]}))}});
        service.call(&address, &state)["warnings"].to_string()
    };
    assert_eq!(step(1, 0.3, 0.5), "null");
    assert_eq!(step(2, 0.3, 0.5), "null", "the same again");
    for (sequence, from) in [(3, 0.2), (4, 0.3)] {
        let warnings = step(sequence, from, 0.51);
        let expected = format!(
            "the target or chunk from {from} s on is ignored, because it is not newer than the last one, of 0.3 s"
        );
        assert!(warnings.contains(&expected) && warnings.contains("a later first action"), "{warnings}");
    }
}

#[test]
fn a_damaged_memory_of_chunks_is_refused() {
    let service = Service::start();
    let body = |memory: Value, sequence: u64| {
        let chunk = actions(0.1, 5, |time| json!({"position": [0.5, time, 0.1]}));
        let mut state = example("state.json");
        state["sequence"] = json!(sequence);
        state["targets"] = json!({"hand": {"chunk": chunk}});
        json!({"controller": controller(), "state": state, "memory": memory})
    };
    let memory = service.call("/v1/step", &body(Value::Null, 1))["memory"].clone();
    service.call("/v1/step", &body(memory.clone(), 2));
    for (at, value, pointer) in [
        ("/chunk/actions/1/time_s", json!(-5.0), "/memory"),
        ("/chunk/actions/1/pose", json!(null), "/memory/target_streams/0/chunk/actions/1"),
        ("/chunk/fade/duration_s", json!(0.0), "/memory"),
        ("/chunk/fade/offset", json!([0.0]), "/memory"),
        ("/chunk/first_s", json!(1e308), "/memory/target_streams/0/chunk/first_s"),
        ("/newest", json!(null), "/memory"),
    ] {
        let mut damaged = memory.clone();
        *damaged.pointer_mut(&format!("/target_streams/0{at}")).unwrap_or_else(|| panic!("{at} in {memory}")) = value;
        let answer = service.post("/v1/step", &body(damaged, 2).to_string());
        answer.assert_refused(422, Some(pointer));
    }
}

#[test]
fn a_channel_that_an_action_names_twice_is_refused() {
    let service = Service::start();
    let mut with_channel = controller();
    with_channel["channels"] = json!([{"name": "suction", "kind": "position", "lower": 0, "upper": 1, "max_rate": 9}]);
    let session = service.open(&with_channel);
    let state = r#"{"sequence": 1, "time_s": 0, "joint_position": [0, -0.5, 0, 1, 0, 1, 0], "targets": {"hand": {"chunk": [
        {"time_s": 0, "position": [0.5, 0, 0.1], "channels": {"suction": 1, "suction": 0}}]}}}"#;
    let refused = service.post(&format!("{session}/step"), state);
    refused.assert_refused(422, Some("/targets/hand/chunk/0/channels"));
    assert!(refused.text.contains("`suction` is given twice"), "{}", refused.text);
}
