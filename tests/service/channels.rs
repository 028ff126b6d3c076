//! Channels besides the joints through the service.

use serde_json::{Value, json};

use crate::harness::{Service, example, without};
use crate::stream::Client;

fn controller() -> Value {
    json!({"robot": "sawyer_dh", "period_s": 0.01,
        "tasks": [{"name": "hand", "axes": ["x", "y", "z"], "law": {"kind": "pose", "gain": 5},
            "streaming": {"delay_s": 0.02}}],
        "channels": [
            {"name": "gripper", "kind": "position", "lower": 0, "upper": 0.08, "max_rate": 0.5},
            {"name": "grip force", "kind": "force", "lower": 0, "upper": 40, "max_rate": 200,
                "target": {"kind": "constant", "value": 10}}]})
}

/// The state of a period: a measured gripper first, then a chunk that closes it, then a single target.
fn state(sequence: u64) -> Value {
    let mut state = json!({"sequence": sequence, "time_s": 0.01 * sequence as f64,
        "joint_position": example("state.json")["joint_position"]});
    let action = |k: u32| {
        let time_s = 0.1 + 0.1 * f64::from(k);
        let mut action = json!({"time_s": time_s, "position": [0.5, 0.0, 0.1], "gripper": 0.08 - 0.02 * f64::from(k)});
        if k == 2 {
            action["channels"] = json!({"grip force": 30.0});
        }
        action
    };
    match sequence {
        0 => state["channels"] = json!({"gripper": {"measured": 0.07}}),
        10 => state["targets"] = json!({"hand": {"chunk": (0..5).map(action).collect::<Value>()}}),
        80 => state["channels"] = json!({"gripper": {"target": 1.0}}),
        _ => {}
    }
    state
}

fn run(mut step: impl FnMut(Value) -> Value) -> Vec<Value> {
    (0..200).map(|sequence| without(step(state(sequence)), &["elapsed_us"])).collect()
}

#[test]
fn sessions_streams_and_stateless_steps_give_the_same_bytes_with_channels() {
    let service = Service::start();
    let address = format!("{}/step", service.open(&controller()));
    let session = run(|state| service.call(&address, &state));
    let mut memory = Value::Null;
    let stateless = run(|state| {
        let answer = service.call("/v1/step", &json!({"controller": controller(), "state": state, "memory": memory}));
        memory = answer["memory"].clone();
        without(answer, &["memory"])
    });
    let mut stream = Client::open(&service, &service.open(&controller()), None);
    let streamed = run(|state| stream.call(&state.to_string()));
    for (other, name) in [(stateless, "stateless"), (streamed, "stream")] {
        let different = session.iter().zip(&other).find(|(a, b)| a.to_string() != b.to_string());
        assert_eq!(different, None, "{name}");
    }
    let number = |period: usize, name: &str| session[period]["channels"][name].as_f64().unwrap();
    assert_eq!((number(0, "gripper"), number(0, "grip force")), (0.07, 10.0));
    // Due 0.02 s later than sent, as the actions of the task.
    assert!((number(32, "gripper") - 0.04).abs() < 2e-3, "{}", number(32, "gripper"));
    assert_eq!((number(60, "gripper"), number(60, "grip force")), (0.0, 30.0));
    assert_eq!(number(199, "gripper"), 0.08);
    for period in 1..200 {
        let change = (number(period, "gripper") - number(period - 1, "gripper")).abs();
        assert!(change <= 0.005 + 1e-12, "{change} at {period}");
    }
}

#[test]
fn wrong_channels_are_refused_with_a_pointer() {
    let service = Service::start();
    let refused = |change: Value, pointer: &str| {
        let mut controller = controller();
        controller["channels"][1].as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
        service.post("/v1/controllers", &controller.to_string()).assert_refused(422, Some(pointer));
    };
    refused(json!({"name": "gripper"}), "/channels/1/name");
    refused(json!({"upper": 0}), "/channels/1/upper");
    refused(json!({"max_rate": 0}), "/channels/1/max_rate");
    refused(json!({"target": {"kind": "constant", "value": [1, 2]}}), "/channels/1/target/value");
    let address = format!("{}/step", service.open(&controller()));
    let refused = |fields: Value, pointer: &str, part: &str| {
        let mut state = state(1);
        state.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        let answer = service.post(&address, &state.to_string());
        answer.assert_refused(422, Some(pointer));
        assert!(answer.json()["detail"].as_str().unwrap().contains(part), "{}", answer.json()["detail"]);
    };
    refused(json!({"channels": {"claw": {"target": 1}}}), "/channels/claw", "`gripper`, `grip force`");
    let chunk = |action: Value| json!({"targets": {"hand": {"chunk": [action]}}});
    let action = |fields: Value| {
        let mut action = json!({"time_s": 0.1, "position": [0.5, 0.0, 0.1]});
        action.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        chunk(action)
    };
    refused(action(json!({"channels": {"claw": 1}})), "/targets/hand/chunk/0/channels/claw", "no channel `claw`");
    let twice = json!({"gripper": 0.1, "channels": {"gripper": 0.1}});
    refused(action(twice), "/targets/hand/chunk/0/channels/gripper", "given twice");
}

#[test]
fn a_target_outside_the_range_of_a_channel_has_a_warning() {
    let service = Service::start();
    let warnings = |fields: Value| {
        let mut state =
            json!({"sequence": 1, "time_s": 0.1, "joint_position": example("state.json")["joint_position"]});
        state.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        let address = format!("{}/step", service.open(&controller()));
        service.call(&address, &state)["warnings"].to_string()
    };
    let action = |gripper: f64| {
        let action = |k: u32| json!({"time_s": 0.1 * f64::from(k), "position": [0.5, 0.0, 0.1], "gripper": gripper});
        json!({"targets": {"hand": {"chunk": [action(1), action(2)]}}})
    };
    let outside = "channel `gripper`: the target 1 is outside its range 0 … 0.08";
    assert_eq!(warnings(action(1.0)).matches(outside).count(), 1, "one for all actions");
    assert!(warnings(json!({"channels": {"gripper": {"target": 1}}})).contains(outside));
    assert!(warnings(json!({"channels": {"grip force": {"target": -5}}})).contains("the target -5 is outside"));
    let measured = |gripper: f64| warnings(json!({"channels": {"gripper": {"measured": gripper}}}));
    assert!(measured(40.0).contains("channel `gripper`: the measured number 40 is outside its range 0 … 0.08"));
    for inside in [0.0, 0.08, 0.0805] {
        assert!(!warnings(action(inside)).contains("gripper"), "{inside}");
        assert!(!measured(inside).contains("gripper"), "{inside}");
    }
}

#[test]
fn a_damaged_memory_of_channels_is_refused() {
    let service = Service::start();
    let body =
        |memory: Value, sequence: u64| json!({"controller": controller(), "state": state(sequence), "memory": memory});
    let memory = service.call("/v1/step", &body(Value::Null, 10))["memory"].clone();
    service.call("/v1/step", &body(memory.clone(), 11));
    for (at, value, pointer) in [
        ("/channels/0/channel", json!("claw"), "/memory/channels/0/channel"),
        ("/channels/0/targets/1/time_s", json!(-5.0), "/memory"),
        ("/channels/1/targets/0/value", json!(1e308), "/memory/channels/1/targets/0/value"),
    ] {
        let mut damaged = memory.clone();
        *damaged.pointer_mut(at).unwrap_or_else(|| panic!("{at} in {memory}")) = value;
        service.post("/v1/step", &body(damaged, 11).to_string()).assert_refused(422, Some(pointer));
    }
}
