//! Poses, Jacobians and link frames.

use serde_json::{Value, json};

use crate::harness::{Service, example, numbers};

fn jacobian(answer: &Value) -> Vec<Vec<f64>> {
    answer["jacobian"].as_array().unwrap().iter().map(numbers).collect()
}

#[test]
fn the_jacobian_is_the_derivative_of_the_pose() {
    let service = Service::start();
    let step = 1e-6;
    let at = |joint: usize, change: f64| {
        let mut request = example("kinematics.json");
        request["joint_position"][joint] = json!(request["joint_position"][joint].as_f64().unwrap() + change);
        numbers(&service.call("/v1/kinematics", &request)["pose"]["position"])
    };
    let rows = jacobian(&service.call("/v1/kinematics", &example("kinematics.json")));
    assert_eq!(rows.len(), 6);
    for joint in 0..7 {
        let (before, after) = (at(joint, -step), at(joint, step));
        for (row, (after, before)) in rows.iter().zip(after.iter().zip(before)) {
            assert!((row[joint] - (after - before) / (2.0 * step)).abs() < 1e-8, "joint {joint}");
        }
    }
}

#[test]
fn singular_values_belong_to_the_jacobian() {
    let answer = Service::start().call("/v1/kinematics", &example("kinematics.json"));
    let values = numbers(&answer["singular_values"]);
    assert_eq!(values.len(), 6);
    assert!(values.is_sorted_by(|a, b| a >= b));
    // The squares of the singular values and of the entries have the same sum.
    let (squares, entries): (f64, f64) = (
        values.iter().map(|value| value * value).sum(),
        jacobian(&answer).iter().flatten().map(|entry| entry * entry).sum(),
    );
    assert!((squares - entries).abs() < 1e-12);
    let product: f64 = values.iter().product();
    assert!((answer["manipulability"].as_f64().unwrap() - product).abs() < 1e-15);
}

#[test]
fn links_lead_from_the_base_to_the_tool() {
    let answer = Service::start().call("/v1/kinematics", &example("kinematics.json"));
    let links = answer["links"].as_array().unwrap();
    let names: Vec<&str> = links.iter().map(|link| link["joint"].as_str().unwrap()).collect();
    assert_eq!(names, ["j1", "j2", "j3", "j4", "j5", "j6", "j7"]);
    assert_eq!(links[0]["pose"]["position"], json!([0.0, 0.0, 0.0]));
    for pose in links.iter().map(|link| &link["pose"]).chain([&answer["pose"]]) {
        let length: f64 =
            ["w", "x", "y", "z"].map(|part| pose["orientation"][part].as_f64().unwrap().powi(2)).iter().sum();
        assert!((length - 1.0).abs() < 1e-12, "{pose}");
    }
}

#[test]
fn joints_may_be_named_and_wrong_names_are_refused_with_a_pointer() {
    let service = Service::start();
    let by_place = service.call("/v1/kinematics", &example("kinematics.json"));
    let named = json!({"j7": 0.2, "j1": 2.9, "j2": -0.4, "j3": 3.0, "j4": 2.1, "j5": 3.0, "j6": -0.6});
    assert_eq!(service.call("/v1/kinematics", &json!({"robot": "sawyer_dh", "joint_position": named})), by_place);
    for (body, pointer) in [
        (json!({"robot": "puma", "joint_position": [0]}), "/robot"),
        (json!({"robot": "sawyer_dh", "joint_position": [0]}), "/joint_position"),
        (json!({"robot": "sawyer_dh", "joint_position": [0, 0, 0, 1e300, 0, 0, 0]}), "/joint_position/3"),
        (json!({"robot": "sawyer_dh", "joint_position": {"j9": 0}}), "/joint_position/j9"),
        (json!({"robot": "sawyer_dh", "joint_position": [0, 0, 0, 0, 0, 0, 0], "tool": 1}), "/tool"),
        (json!({"robot": "sawyer_dh"}), ""),
    ] {
        service.post("/v1/kinematics", &body.to_string()).assert_refused(422, Some(pointer));
    }
}
