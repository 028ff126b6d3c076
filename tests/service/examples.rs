//! The main routes, with the bodies of `api/examples`.

use serde_json::{Value, json};

use crate::harness::{Service, example, numbers};

/// Asserts that the joint velocities of the example arm are finite and inside `limit`.
fn assert_command(answer: &Value, limit: f64) {
    let velocity = numbers(&answer["joint_velocity"]);
    assert_eq!(velocity.len(), 7);
    assert!(velocity.iter().all(|v| v.abs() <= limit), "{velocity:?}");
    assert_eq!(answer["solver"]["status"], "optimal");
    assert!(answer["elapsed_us"].as_f64().unwrap() > 0.0);
}

#[test]
fn one_problem_is_resolved_and_explained() {
    let answer = Service::start().call("/v1/resolve", &example("resolve.json"));
    assert_command(&answer, 1.0);
    let push = &answer["tasks"][0];
    assert_eq!(push["name"], "push");
    assert!((numbers(&push["achieved"])[0] - 0.05).abs() < 1e-9, "{push}");
    assert_eq!((&push["rank"], &answer["tasks"][1]["rank"]), (&json!(1), &json!(5)));
    assert!(answer["singularity"]["smallest_singular_value"].as_f64().unwrap() > 0.0);
}

#[test]
fn one_period_is_stepped_without_a_session() {
    let answer = Service::start().call("/v1/step", &example("step.json"));
    assert_command(&answer, 10.0);
    assert_eq!(answer["sequence"], 17);
    assert_eq!(answer["memory"]["sequence"], 17);
    assert_eq!(answer["valid_for_ms"], 100);
    assert_eq!(answer["tasks"][0]["target_force"], json!([30.0]));
    assert_eq!(answer["tasks"][1]["target_force"], json!([null, null, null, null, null]));
    // Eq. (41): xdot = T (F_d - F_e) / M_d from rest.
    let requested = numbers(&answer["tasks"][0]["requested"])[0];
    assert!((requested - 0.001 * (30.0 - 12.5) / 15.0).abs() < 1e-15, "{requested}");
}

#[test]
fn a_session_is_opened_stepped_shown_and_ended() {
    let service = Service::start();
    let created = service.post("/v1/controllers", &example("controller.json").to_string());
    assert_eq!(created.status, 201);
    let session = created.location.clone().unwrap();
    let body = created.accepted();
    assert_eq!(session, format!("/v1/controllers/{}", body["id"].as_str().unwrap()));
    assert_eq!(body["joints"], json!(["j1", "j2", "j3", "j4", "j5", "j6", "j7"]));

    let answer = service.call(&format!("{session}/step"), &example("state.json"));
    assert_command(&answer, 10.0);
    assert_eq!(answer.get("memory"), None);

    let shown = service.get(&session).accepted();
    assert_eq!((&shown["id"], &shown["last_sequence"], &shown["steps"]), (&body["id"], &json!(17), &json!(1)));
    assert_eq!(shown["controller"]["damping"], json!({"threshold": 0.15, "max_factor": 0.15}));

    let ended = service.delete(&session);
    assert_eq!((ended.status, ended.text.as_str()), (204, ""));
    for answer in [service.get(&session), service.delete(&session)] {
        answer.assert_refused(404, None);
    }
    service.post(&format!("{session}/step"), &example("state.json").to_string()).assert_refused(404, None);
}

#[test]
fn a_shown_controller_can_be_created_again() {
    let service = Service::start();
    let shown = |session: &str| service.get(session).accepted()["controller"].clone();
    let first = shown(&service.open(&example("controller.json")));
    assert_eq!(shown(&service.open(&first)), first);
}

#[test]
fn the_margins_of_an_unstable_contact_make_it_stable() {
    let service = Service::start();
    let lagging = service.call("/v1/stability", &example("stability.json"));
    assert_eq!(lagging["stable"], false);
    let (lag, damping) = (&lagging["largest_lag_s"], &lagging["smallest_damping"]);
    let is_stable_with = |field: &str, value: f64| {
        let mut request = example("stability.json");
        request[field] = json!(value);
        service.call("/v1/stability", &request)["stable"] == true
    };
    assert!(
        is_stable_with("lag_s", 0.99 * lag.as_f64().unwrap()) && !is_stable_with("lag_s", 1.01 * lag.as_f64().unwrap())
    );
    assert!(
        is_stable_with("damping", 1.01 * damping.as_f64().unwrap())
            && !is_stable_with("damping", 0.99 * damping.as_f64().unwrap())
    );
}

#[test]
fn robots_are_listed_and_shown_with_their_limits() {
    let service = Service::start();
    let list = service.get("/v1/robots").accepted();
    let sawyer = service.get("/v1/robots/sawyer_dh").accepted();
    assert!(list["robots"].as_array().unwrap().contains(&sawyer));
    assert_eq!(sawyer["joints"].as_array().unwrap().len(), 7);
    let first = &sawyer["joints"][0];
    assert_eq!((&first["name"], &first["kind"]), (&json!("j1"), &json!("revolute")));
    assert_eq!((&first["velocity_limit"], &first["acceleration_limit"]), (&json!(1.74), &json!(8.0)));
    assert_eq!(first["unit"], "rad");
    assert_eq!(first["denavit_hartenberg"]["d_m"], json!(0.317));
    service.get("/v1/robots/puma").assert_refused(404, None);
}

#[test]
fn the_liveness_probe_is_answered() {
    Service::start().assert_alive();
}
