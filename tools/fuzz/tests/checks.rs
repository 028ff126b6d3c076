//! The checks find each kind of defect.

use std::time::Duration;

use revprio_api::wire::{KinematicsAnswer, ResolveAnswer, ResolveRequest};
use revprio_fuzz::Target;
use revprio_fuzz::answers::{command, decode, value};
use revprio_fuzz::budget::Work;
use revprio_fuzz::connection::Answer;
use revprio_fuzz::limits::of_problem;
use revprio_fuzz::mutation::mutate;
use revprio_fuzz::seeds::seeds;
use serde_json::{Value, json};

const ANSWER: &str = include_str!("../../../api/examples/answers/resolve_limits.json");
const REQUEST: &str = include_str!("../../../api/examples/resolve_limits.json");

fn answer(status: u16, media_type: &str, body: &Value) -> Answer {
    Answer { status, media_type: media_type.to_owned(), body: body.to_string().into_bytes() }
}

#[test]
fn a_server_error_is_a_defect_unless_long_work_is_late() {
    let problem = |status: u16, kind: &str| {
        let body = json!({"type": format!("/problems/{kind}"), "title": "t", "status": status, "detail": "d"});
        answer(status, "application/problem+json", &body)
    };
    let is_defect = |answer: &Answer, may_be_late| value::<ResolveAnswer>(answer, may_be_late).is_err();
    assert!(is_defect(&problem(500, "internal"), true));
    assert!(is_defect(&problem(503, "deadline"), false));
    assert!(!is_defect(&problem(503, "deadline"), true));
    assert!(!is_defect(&problem(422, "invalid"), false));
    assert!(is_defect(&answer(422, "text/plain", &json!("no")), false));
    assert!(is_defect(&answer(200, "application/json", &json!({"joint_velocity": [1]})), false));
}

#[test]
fn a_number_that_is_not_finite_is_a_defect_in_both_formats() {
    let text = include_str!("../../../api/examples/answers/kinematics.json");
    let mut value: Value = serde_json::from_str(text).unwrap();
    let mut typed: KinematicsAnswer = decode("application/json", value.to_string().as_bytes()).unwrap();
    value["manipulability"] = Value::Null;
    assert!(decode::<KinematicsAnswer>("application/json", value.to_string().as_bytes()).is_err());
    let binary = |answer: &KinematicsAnswer| rmp_serde::to_vec_named(answer).unwrap();
    assert!(decode::<KinematicsAnswer>("application/msgpack", &binary(&typed)).is_ok());
    typed.jacobian[0][0] = f64::INFINITY;
    assert!(decode::<KinematicsAnswer>("application/msgpack", &binary(&typed)).is_err());
}

#[test]
fn a_command_outside_its_speed_limits_is_a_defect() {
    let request: ResolveRequest = serde_json::from_str(REQUEST).unwrap();
    let limits = of_problem(&request);
    let mut answer: ResolveAnswer = serde_json::from_str(ANSWER).unwrap();
    assert!(limits.is_some() && command(&answer, limits.as_ref()).is_ok());
    answer.joint_velocity[0] = 1e3;
    assert!(command(&answer, limits.as_ref()).is_err());
    answer.joint_velocity.pop();
    assert!(command(&answer, limits.as_ref()).is_err());
}

#[test]
fn an_arm_has_50_ms_and_a_larger_request_more() {
    let request: ResolveRequest = serde_json::from_str(REQUEST).unwrap();
    let arm = Work::of_problem(&request);
    assert_eq!(arm.budget(), Duration::from_millis(50));
    let mut larger = request;
    larger.tasks = vec![larger.tasks[0].clone(); 64];
    assert!(Work::of_problem(&larger).budget() > arm.budget() && Work::of_problem(&larger).exceeds_arm());
    assert_eq!(Work { bytes: 128 << 10, ..arm }.budget(), Duration::from_millis(100));
}

#[test]
fn a_mutated_body_is_still_json_and_mostly_another_one() {
    let seed = seeds(Target::Json).swap_remove(0);
    let mutated = |random| mutate(Target::Json, &seed, &mut fastrand::Rng::with_seed(random)).unwrap();
    let bodies: Vec<Vec<u8>> = (0..100).map(mutated).collect();
    for body in &bodies {
        let text = body.splitn(2, |byte| *byte == b'\n').nth(1).unwrap();
        assert!(serde_json::from_slice::<Value>(text).is_ok(), "{}", String::from_utf8_lossy(body));
    }
    assert!(bodies.iter().filter(|body| **body != seed).count() > 80);
}
