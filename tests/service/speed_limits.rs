//! Speed limits that hold without being asked for, and violations that are always listed.

use serde_json::{Value, json};

use crate::harness::{Service, numbers};

/// A task that no joint of the arm can follow.
fn fast(changes: &Value) -> Value {
    let mut request = json!({
        "robot": "panda", "joint_position": [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
        "tasks": [{"name": "fly", "axes": ["x", "y", "z"], "velocity": [0.0, 0.0, 40.0]}]
    });
    request.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
    request
}

/// Returns the speed limits of the arm, and the joints that exceed them in an answer.
fn excesses(service: &Service, answer: &Value) -> Vec<String> {
    let robot = service.get("/v1/robots/panda").accepted();
    let joints = robot["joints"].as_array().unwrap();
    let speeds = numbers(&answer["joint_velocity"]);
    let is_too_fast =
        |(joint, speed): &(&Value, &f64)| speed.abs() > joint["velocity_limit"].as_f64().unwrap() * (1.0 + 1e-9);
    let name = |(joint, _): (&Value, &f64)| joint["name"].as_str().unwrap().to_owned();
    joints.iter().zip(&speeds).filter(is_too_fast).map(name).collect()
}

fn listed(answer: &Value) -> Vec<String> {
    let violated = answer["violated_limits"].as_array().unwrap();
    violated.iter().map(|limit| limit["joint"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn a_resolve_with_a_robot_keeps_its_speed_limits_unless_it_says_none() {
    let service = Service::start();
    for solver in ["auto", "qp"] {
        let answer = service.call("/v1/resolve", &fast(&json!({"solver": solver})));
        assert!(excesses(&service, &answer).is_empty() && listed(&answer).is_empty(), "{solver}: {answer}");
        assert!(!answer["active_limits"].as_array().unwrap().is_empty());
    }
    for solver in ["auto", "qp", "closed_form"] {
        let answer = service.call("/v1/resolve", &fast(&json!({"solver": solver, "limits": "none"})));
        let excesses = excesses(&service, &answer);
        assert!(!excesses.is_empty() && listed(&answer) == excesses, "{solver}: {answer}");
    }
    let answer = service.call("/v1/resolve", &fast(&json!({"solver": "closed_form"})));
    assert!(!listed(&answer).is_empty() && listed(&answer) == excesses(&service, &answer), "{answer}");
}

#[test]
fn a_box_wider_than_the_robot_lists_the_joints_beyond_its_speed_limits() {
    let service = Service::start();
    let limits = json!({"lower": [-99, -99, -99, -99, -99, -99, -99], "upper": [99, 99, 99, 99, 99, 99, 99]});
    let answer = service.call("/v1/resolve", &fast(&json!({"limits": limits})));
    assert!(!listed(&answer).is_empty() && listed(&answer) == excesses(&service, &answer), "{answer}");
}
