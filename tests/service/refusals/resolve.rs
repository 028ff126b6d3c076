//! `POST /v1/resolve`.

use serde_json::{Value, json};

use super::{NO_POINTER, OMITTED, Row, assert_all_refused};
use crate::harness::{Service, example};

const WITH_ROBOT: &[Row] = &[
    ("/robot", r#""puma""#, 422, "/robot"),
    ("/robot", r#""""#, 422, "/robot"),
    ("/robot", "7", 422, "/robot"),
    ("/robot", "[]", 422, "/robot"),
    ("/robot", OMITTED, 422, "/robot"),
    ("/joint_position", OMITTED, 422, "/tasks/0/axes"),
    ("/joint_position", "[]", 422, "/joint_position"),
    ("/joint_position", "[0, 0, 0, 0, 0, 0]", 422, "/joint_position"),
    ("/joint_position", "[0, 0, 0, 0, 0, 0, 0, 0]", 422, "/joint_position"),
    ("/joint_position", "0.5", 422, "/joint_position"),
    ("/joint_position", r#""home""#, 422, "/joint_position"),
    ("/joint_position/2", "null", 422, "/joint_position/2"),
    ("/joint_position/2", r#""1.0""#, 422, "/joint_position/2"),
    ("/joint_position/2", "NaN", 400, NO_POINTER),
    ("/joint_position/2", "-Infinity", 400, NO_POINTER),
    ("/joint_position/2", "1e999", 400, NO_POINTER),
    ("/joint_position/2", "-1e999", 400, NO_POINTER),
    ("/joint_position/2", "1e308", 422, "/joint_position/2"),
    ("/joint_position/2", "-1.1e9", 422, "/joint_position/2"),
    ("/joint_position/2", "01", 400, NO_POINTER),
    ("/joint_position/2", ".5", 400, NO_POINTER),
    ("/joint_position/2", "0x10", 400, NO_POINTER),
    ("/joint_velocity", "0", 422, "/joint_velocity"),
    ("/period_s", "0", 422, "/period_s"),
    ("/period_s", "-0.001", 422, "/period_s"),
    ("/period_s", "1e-300", 422, "/period_s"),
    ("/period_s", "11", 422, "/period_s"),
    ("/period_s", "1e308", 422, "/period_s"),
    ("/period_s", r#""1 ms""#, 422, "/period_s"),
    ("/tasks", OMITTED, 422, ""),
    ("/tasks", "[]", 422, "/tasks"),
    ("/tasks", "{}", 422, "/tasks"),
    ("/tasks", "null", 422, "/tasks"),
    ("/tasks/0", "null", 422, "/tasks/0"),
    ("/tasks/0", "{}", 422, "/tasks/0"),
    ("/tasks/0", r#"{"velocity": [0.1]}"#, 422, "/tasks/0"),
    ("/tasks/0/name", "1", 422, "/tasks/0/name"),
    ("/tasks/0/axes", OMITTED, 422, "/tasks/0"),
    ("/tasks/0/axes", "[]", 422, "/tasks/0/axes"),
    ("/tasks/0/axes", r#"["w"]"#, 422, "/tasks/0/axes/0"),
    ("/tasks/0/axes", r#"["X"]"#, 422, "/tasks/0/axes/0"),
    ("/tasks/0/axes", r#""x""#, 422, "/tasks/0/axes"),
    ("/tasks/1/axes", r#"["y", "z", "y", "ry", "rz"]"#, 422, "/tasks/1/axes"),
    ("/tasks/0/jacobian", "[[1, 0, 0, 0, 0, 0, 0]]", 422, "/tasks/0"),
    ("/tasks/0/velocity", OMITTED, 422, "/tasks/0"),
    ("/tasks/0/velocity", "[]", 422, "/tasks/0/velocity"),
    ("/tasks/0/velocity", "[0.1, 0.1]", 422, "/tasks/0/velocity"),
    ("/tasks/0/velocity", "0.1", 422, "/tasks/0/velocity"),
    ("/tasks/1/velocity/4", "1e308", 422, "/tasks/1/velocity/4"),
    ("/tasks/1/velocity/4", "Infinity", 400, NO_POINTER),
    ("/tasks/0/lower", "[0]", 422, "/tasks/0"),
    ("/tasks/0/upper", "[1]", 422, "/tasks/0"),
    ("/tasks/0/velocity", "null", 422, "/tasks/0"),
    ("/tasks/0/priority", "1", 422, "/tasks/0/priority"),
    ("/method", r#""newton""#, 422, "/method"),
    ("/method", r#""ReversePriority""#, 422, "/method"),
    ("/method", "null", 422, "/method"),
    ("/solver", r#""osqp""#, 422, "/solver"),
    ("/solver", "[]", 422, "/solver"),
    ("/limits", r#""acceleration""#, 422, "/limits"),
    ("/limits", r#""position_velocity""#, 422, "/period_s"),
    ("/limits", r#"{"lower": [-1, -1, -1, -1, -1, -1, -1]}"#, 422, "/limits"),
    ("/limits", "3", 422, "/limits"),
    ("/limits/middle", "[]", 422, "/limits/middle"),
    ("/limits/lower", "[-1]", 422, "/limits/lower"),
    ("/limits/lower/3", "1.5", 422, "/limits/lower/3"),
    ("/limits/upper/3", "-1.5", 422, "/limits/lower/3"),
    ("/limits/upper/3", "1e308", 422, "/limits/upper/3"),
    ("/damping", "0.1", 422, "/damping"),
    ("/damping", "[0.05, 0.1]", 422, "/damping"),
    ("/tasks/0", r#"["push", ["x"], null, [0.05]]"#, 422, "/tasks/0"),
    ("/damping", r#"{"threshold": 0, "max_factor": 0.1}"#, 422, "/damping"),
    ("/damping", r#"{"threshold": 0.05, "max_factor": -0.1}"#, 422, "/damping"),
    ("/damping", r#"{"threshold": 0.05, "max_factor": 1e300}"#, 422, "/damping/max_factor"),
    ("/null_space_velocity", "[1]", 422, "/null_space_velocity"),
    ("/null_space_velocity", r#"{"kind": "joint_limits", "gain": -1}"#, 422, "/null_space_velocity/gain"),
    ("/null_space_velocity", r#"{"kind": "joint_limits", "gain": 1e10}"#, 422, "/null_space_velocity/gain"),
    ("/null_space_velocity", r#"{"kind": "joint_limits", "gain": "1"}"#, 422, "/null_space_velocity"),
    ("/null_space_velocity", r#"{"kind": "posture", "gain": 1}"#, 422, "/null_space_velocity"),
    ("/null_space_velocity", WRONG_POSTURE, 422, "/null_space_velocity/joint_position/j9"),
    ("/tool_offset", r#"{"position": [0, 0, 0]}"#, 422, "/tool_offset"),
    ("/tool_offset", r#"{"position": [0, 0, 0], "orientation": [1, 0, 0, 0]}"#, 422, "/tool_offset/orientation"),
    ("/tool_offset", NO_ORIENTATION, 422, "/tool_offset/orientation"),
    ("/tasks/0/frame", r#""world""#, 422, "/tasks/0/frame"),
    ("/tasks/0/frame", NO_ORIENTATION, 422, "/tasks/0/frame/orientation"),
    ("/tasks/0/reference_point", "[0, 0]", 422, "/tasks/0/reference_point"),
    ("/tasks/0/reference_point", "[0, 0, 1e308]", 422, "/tasks/0/reference_point/2"),
    ("/tasks/0/reference_point", "[0, 0, NaN]", 400, NO_POINTER),
    ("/speed", "1", 422, "/speed"),
];

const WITH_EXPLICIT_ROWS: &[Row] = &[
    ("/robot", r#""sawyer_dh""#, 422, "/tasks/0/jacobian"),
    ("/joint_position", "[0, 0, 0]", 422, "/robot"),
    ("/tasks/0/axes", r#"["x"]"#, 422, "/tasks/0"),
    ("/tasks/0/jacobian", "[]", 422, "/tasks/0/jacobian"),
    ("/tasks/0/jacobian", "[[]]", 422, "/tasks/0/jacobian"),
    ("/tasks/0/jacobian", "[1, 2, 3]", 422, "/tasks/0/jacobian/0"),
    ("/tasks/0/jacobian", "[[1, 2, 3], [1, 2]]", 422, "/tasks/0/jacobian/1"),
    ("/tasks/0/jacobian", "[[1, 2, 3], [4, 5, 6]]", 422, "/tasks/0/velocity"),
    ("/tasks/0/jacobian/0/1", "1e10", 422, "/tasks/0/jacobian/0/1"),
    ("/tasks/0/jacobian/0/1", "NaN", 400, NO_POINTER),
    ("/tasks/1/jacobian", "[[1, 2]]", 422, "/tasks/1/jacobian"),
    ("/limits", r#""velocity""#, 422, "/limits"),
    ("/limits", r#"{"lower": [0, 0], "upper": [1, 1]}"#, 422, "/limits/lower"),
    ("/limits", r#"{"lower": [0, 0, 0], "upper": [1, 1, 1], "lower": [0, 0, 0]}"#, 422, "/limits"),
    ("/null_space_velocity", r#"{"j1": 1, "j2": 1, "j3": 1}"#, 422, "/null_space_velocity"),
    ("/null_space_velocity/1", "1e10", 422, "/null_space_velocity/1"),
    ("/null_space_velocity", r#"{"kind": "joint_limits", "gain": 1}"#, 422, "/robot"),
    ("/tasks/0/frame", r#""tool""#, 422, "/tasks/0/frame"),
    ("/tasks/0/reference_point", "[0, 0, 0.1]", 422, "/tasks/0/reference_point"),
    ("/tool_offset", r#"{"position": [0, 0, 0], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}"#, 422, "/robot"),
];

const WITH_BOUNDS: &[Row] = &[
    ("/tasks/0/velocity", "[0]", 422, "/tasks/0"),
    ("/tasks/0/scale", "true", 422, "/tasks/0/scale"),
    ("/tasks/0/lower", "[]", 422, "/tasks/0/lower"),
    ("/tasks/0/lower", "[0, 0]", 422, "/tasks/0/lower"),
    ("/tasks/0/lower", "0", 422, "/tasks/0/lower"),
    ("/tasks/0/lower", r#"["0"]"#, 422, "/tasks/0/lower/0"),
    ("/tasks/0/lower/0", "0.11", 422, "/tasks/0/lower/0"),
    ("/tasks/0/lower/0", "1e10", 422, "/tasks/0/lower/0"),
    ("/tasks/0/lower/0", "-1e10", 422, "/tasks/0/lower/0"),
    ("/tasks/0/lower/0", "NaN", 400, NO_POINTER),
    ("/tasks/0/lower/0", "-Infinity", 400, NO_POINTER),
    ("/tasks/0/upper", "[0, 0, 0]", 422, "/tasks/0/upper"),
    ("/tasks/0/upper/0", "-0.11", 422, "/tasks/0/lower/0"),
    ("/tasks/0/upper/0", "true", 422, "/tasks/0/upper/0"),
    ("/tasks/0/axes", r#"["y", "z"]"#, 422, "/tasks/0/lower"),
    ("/tasks/1/upper/2", "0.1", 422, "/tasks/1/lower/2"),
    ("/tasks/1/jacobian", "[[1, 0, 0, 0, 0, 0, 0]]", 422, "/tasks/1/lower"),
];

const WRONG_POSTURE: &str = r#"{"kind": "posture", "joint_position": {"j9": 0}, "gain": 1}"#;
const NO_ORIENTATION: &str = r#"{"position": [0, 0, 0], "orientation": {"w": 0.5, "x": 0, "y": 0, "z": 0}}"#;

fn bounds() -> Value {
    let mut request = example("resolve.json");
    request["tasks"] = json!([
        {"axes": ["z"], "lower": [-0.1], "upper": [0.1]},
        {"jacobian": [[1, 0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0, 0]],
            "lower": [null, -0.1, 0.2], "upper": [0.3, null, 0.2]},
        {"axes": ["x"], "velocity": [0.1]}
    ]);
    request
}

fn explicit_rows() -> Value {
    let task = |row: [f64; 3]| json!({"jacobian": [row], "velocity": [0.1]});
    let tasks = [task([1.0, 0.0, 0.0]), task([0.0, 1.0, 1.0])];
    json!({"tasks": tasks, "null_space_velocity": [0.0, 0.1, 0.2]})
}

#[test]
fn wrong_problems_are_refused() {
    assert_all_refused(&Service::start(), "/v1/resolve", &example("resolve.json"), WITH_ROBOT);
}

#[test]
fn wrong_problems_with_explicit_rows_are_refused() {
    assert_all_refused(&Service::start(), "/v1/resolve", &explicit_rows(), WITH_EXPLICIT_ROWS);
}

#[test]
fn wrong_bounds_are_refused() {
    assert_all_refused(&Service::start(), "/v1/resolve", &bounds(), WITH_BOUNDS);
}

/// Rows of a certificate name their tasks. Other answers list them in order, so that names need not differ.
#[test]
fn certificates_need_tasks_of_different_names() {
    let service = Service::start();
    let mut problem = explicit_rows();
    problem["tasks"][0]["name"] = json!("task 2");
    problem["tasks"][1].as_object_mut().unwrap().remove("name");
    assert_all_refused(&service, "/v1/resolve", &problem, &[("/certificate", "true", 422, "/tasks/1/name")]);
}

#[test]
fn problems_above_the_maximum_size_are_refused() {
    let service = Service::start();
    let refused = |tasks: Value, pointer: &str| {
        service.post("/v1/resolve", &json!({"tasks": tasks}).to_string()).assert_refused(422, Some(pointer));
    };
    let task =
        |rows: usize, columns: usize| json!({"jacobian": vec![vec![0.5; columns]; rows], "velocity": vec![0.1; rows]});
    refused(json!([task(1, 129)]), "/tasks/0/jacobian");
    refused(json!([task(513, 3)]), "/tasks");
    refused(json!(vec![task(1, 3); 513]), "/tasks");
    refused(json!(vec![json!({"jacobian": [], "velocity": []}); 10_000]), "/tasks/0/jacobian");
}
