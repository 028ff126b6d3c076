//! `POST /v1/controllers/{id}/step`, and the same object inside `POST /v1/step`.

use super::{NO_POINTER, OMITTED, Row, assert_all_refused};
use crate::harness::{Service, example};

/// The task has five axes, not six.
const POSE_WITH_TWIST: &str = r#"{"hold": {"velocity": [0, 0, 0, 0, 0, 0], "pose":
    {"position": [0.6, 0, 0.4], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}}}"#;
const POSE_OF_WRONG_LENGTH: &str =
    r#"{"hold": {"pose": {"position": [0.6, 0, 0.4], "orientation": {"w": 2, "x": 0, "y": 0, "z": 0}}}}"#;
const POSE_AS_LISTS: &str = r#"{"hold": {"pose": {"position": [0.6, 0, 0.4], "orientation": [1, 0, 0, 0]}}}"#;

const STATE: [Row; 56] = [
    ("/sequence", OMITTED, 422, ""),
    ("/sequence", "-1", 422, "/sequence"),
    ("/sequence", "1.5", 422, "/sequence"),
    ("/sequence", r#""17""#, 422, "/sequence"),
    ("/sequence", "9007199254740992", 422, "/sequence"),
    ("/sequence", "18446744073709551616", 422, "/sequence"),
    ("/time_s", OMITTED, 422, ""),
    ("/time_s", "null", 422, "/time_s"),
    ("/time_s", "1e308", 422, "/time_s"),
    ("/time_s", "NaN", 400, NO_POINTER),
    ("/time_s", "17, \"time_s\": 17", 422, ""),
    ("/joint_position", OMITTED, 422, ""),
    ("/joint_position", "[]", 422, "/joint_position"),
    ("/joint_position", "[1, 2, 3]", 422, "/joint_position"),
    ("/joint_position", r#"{"j1": 1}"#, 422, "/joint_position"),
    ("/joint_position", r#"{"elbow": 1}"#, 422, "/joint_position/elbow"),
    ("/joint_position/6", "1e308", 422, "/joint_position/6"),
    ("/joint_position/6", "Infinity", 400, NO_POINTER),
    ("/joint_position/6", "[1]", 422, "/joint_position/6"),
    ("/joint_velocity", "[1]", 422, "/joint_velocity"),
    ("/joint_velocity/0", "-1e308", 422, "/joint_velocity/0"),
    ("/joint_velocity/0", "1e999", 400, NO_POINTER),
    ("/wrench", OMITTED, 422, "/wrench"),
    ("/wrench", "null", 422, "/wrench"),
    ("/wrench", "[0, 0, 0, 0, 0, 0]", 422, "/wrench"),
    ("/wrench", "[[0, 0, 0], [0, 0, 0]]", 422, "/wrench"),
    ("/wrench", "{}", 422, "/wrench"),
    ("/wrench/torque", OMITTED, 422, "/wrench"),
    ("/wrench/force", "[1, 2]", 422, "/wrench/force"),
    ("/wrench/force", "[1, 2, 3, 4]", 422, "/wrench/force"),
    ("/wrench/force/0", "1e308", 422, "/wrench/force/0"),
    ("/wrench/torque/2", "-Infinity", 400, NO_POINTER),
    ("/wrench/frame", r#""tool""#, 422, "/wrench/frame"),
    ("/memory", "null", 422, "/memory"),
    ("/targets", "null", 422, "/targets"),
    ("/targets", "[]", 422, "/targets"),
    ("/targets", r#"{"hand": {"force": [1]}}"#, 422, "/targets/hand"),
    ("/targets", r#"{"push": {}}"#, 422, "/targets/push"),
    ("/targets", r#"{"push": [1]}"#, 422, "/targets/push"),
    ("/targets", r#"{"push": {"wrench": [1]}}"#, 422, "/targets/push/wrench"),
    ("/targets", r#"{"push": {"pose": {"position": [0, 0, 0]}}}"#, 422, "/targets/push/pose"),
    ("/targets", r#"{"push": {"joint_position": [1]}}"#, 422, "/targets/push/joint_position"),
    ("/targets", r#"{"push": {"velocity": [1]}}"#, 422, "/targets/push/velocity"),
    ("/targets", r#"{"push": {"force": [1], "velocity": [1]}}"#, 422, "/targets/push/velocity"),
    ("/targets", r#"{"push": {"force": [1, 2]}}"#, 422, "/targets/push/force"),
    ("/targets", r#"{"push": {"force": [1e308]}}"#, 422, "/targets/push/force/0"),
    ("/targets", r#"{"push": {"force": [NaN]}}"#, 400, NO_POINTER),
    ("/targets", r#"{"push": {"force": [1], "time_s": 1.018}}"#, 422, "/targets/push/time_s"),
    ("/targets", r#"{"push": {"force": [1], "time_s": -1e308}}"#, 422, "/targets/push/time_s"),
    ("/targets", r#"{"push": {"force": [1]}, "push": {"force": [1]}}"#, 422, "/targets"),
    ("/targets", r#"{"hold": {"pose": {"position": [0.6, 0, 0.4]}}}"#, 422, "/targets/hold/pose"),
    ("/targets", r#"{"hold": {"pose": {"orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}}}"#, 422, "/targets/hold/pose"),
    ("/targets", POSE_OF_WRONG_LENGTH, 422, "/targets/hold/pose/orientation"),
    ("/targets", POSE_AS_LISTS, 422, "/targets/hold/pose/orientation"),
    ("/targets", POSE_WITH_TWIST, 422, "/targets/hold/velocity"),
    ("/q", "[]", 422, "/q"),
];

#[test]
fn wrong_states_are_refused_by_a_session() {
    let service = Service::start();
    let address = format!("{}/step", service.open(&example("controller.json")));
    assert_all_refused(&service, &address, &example("state.json"), &STATE);
    assert_eq!(service.get(address.trim_end_matches("/step")).accepted()["steps"], 1);
}

#[test]
fn wrong_states_are_refused_in_a_step_with_the_whole_pointer() {
    let inside =
        |text: &'static str| -> &'static str { if text == NO_POINTER { text } else { format!("/state{text}").leak() } };
    let rows: Vec<Row> = STATE.iter().map(|&(at, text, status, to)| (inside(at), text, status, inside(to))).collect();
    assert_all_refused(&Service::start(), "/v1/step", &example("step.json"), &rows);
}
