//! States that are not plausible: refused, or answered with a warning that names the remedy.

use serde_json::{Value, json};

use crate::harness::{Answer, Service, example, numbers};

/// A service with a session.
struct Session {
    service: Service,
    path: String,
}

impl Session {
    fn open(change: impl FnOnce(&mut Value)) -> Self {
        let service = Service::start();
        let mut controller = example("controller.json");
        change(&mut controller);
        let path = service.open(&controller);
        Self { service, path: path + "/step" }
    }

    fn send(&self, state: &Value) -> Answer {
        self.service.post(&self.path, &state.to_string())
    }

    /// Returns the upper position limit of the first joint, rad.
    fn upper(&self) -> f64 {
        let robot = self.service.get("/v1/robots/sawyer_dh").accepted();
        robot["joints"][0]["position_limit"][1].as_f64().unwrap()
    }

    /// Returns the warnings of an answer in one text.
    fn warnings(&self, state: &Value) -> String {
        warnings(&self.send(state).accepted())
    }
}

fn warnings(answer: &Value) -> String {
    let list = answer.get("warnings").and_then(Value::as_array).cloned().unwrap_or_default();
    list.iter().map(|warning| warning.as_str().unwrap().to_owned() + "\n").collect()
}

/// Returns the example state at a period, with the first joint moved.
fn state(sequence: u64, time_s: f64, moved: f64) -> Value {
    let mut state = example("state.json");
    let first = state["joint_position"][0].as_f64().unwrap();
    (state["sequence"], state["time_s"], state["joint_position"][0]) =
        (json!(sequence), json!(time_s), json!(first + moved));
    state
}

fn degrees() -> Value {
    let mut state = example("state.json");
    state["joint_position"] = numbers(&state["joint_position"]).iter().map(|q| q.to_degrees()).collect();
    state
}

#[test]
fn degrees_are_refused_and_a_field_allows_them() {
    let session = Session::open(|_| ());
    let refused = session.send(&degrees());
    refused.assert_refused(422, Some("/joint_position"));
    let problem = refused.json();
    assert_eq!(problem["type"], "/problems/implausible");
    for part in ["`j1`", "degrees", "state_checks.position_tolerance"] {
        assert!(problem["detail"].as_str().unwrap().contains(part), "{problem}");
    }
    let allowed = Session::open(|controller| controller["state_checks"] = json!({"position_tolerance": 1000}));
    let flagged = allowed.warnings(&degrees());
    assert!(flagged.contains("`j1`") && flagged.contains("outside its range"), "{flagged}");

    let mut stateless = example("step.json");
    stateless["state"] = degrees();
    let answer = session.service.post("/v1/step", &stateless.to_string());
    answer.assert_refused(422, Some("/state/joint_position"));
}

#[test]
fn the_tolerance_ends_where_it_says() {
    let session = Session::open(|_| ());
    let at = |distance: f64| {
        let mut state = example("state.json");
        state["joint_position"][0] = json!(session.upper() + distance);
        state
    };
    session.send(&at(0.1001)).assert_refused(422, Some("/joint_position"));
    assert!(session.warnings(&at(0.0999)).contains("drives it back"));
    let narrow = Session::open(|controller| controller["state_checks"] = json!({"position_tolerance": 0}));
    narrow.send(&at(1e-6)).assert_refused(422, Some("/joint_position"));
    narrow.send(&at(-1e-6)).accepted();
}

#[test]
fn without_position_limits_a_posture_outside_is_flagged() {
    for limits in [json!("none"), json!("velocity"), json!({"lower": vec![-1; 7], "upper": vec![1; 7]})] {
        let session = Session::open(|controller| controller["limits"] = limits);
        assert!(session.warnings(&degrees()).contains("does not keep positions inside"));
        assert_eq!(session.send(&state(99, 1.0, 0.0)).accepted()["valid_for_ms"], 100);
    }
}

#[test]
fn a_wrench_beyond_its_bound_is_refused() {
    let session = Session::open(|controller| {
        controller["state_checks"] = json!({"max_force_n": 200, "max_torque_nm": 20});
    });
    let with = |field: &str, value: f64| {
        let mut state = example("state.json");
        state["wrench"][field][2] = json!(value);
        state
    };
    session.send(&with("force", -200.1)).assert_refused(422, Some("/wrench/force"));
    session.send(&with("torque", 20.1)).assert_refused(422, Some("/wrench/torque"));
    session.send(&with("force", -200.0)).accepted();
    let without_bound = Session::open(|_| ());
    assert!(without_bound.warnings(&with("force", 12_500.0)).contains("state_checks.max_force_n"));
    assert!(!Session::open(|_| ()).warnings(&with("torque", -9_999.0)).contains("the wrench has"));
}

#[test]
fn time_that_goes_back_or_jumps_is_flagged() {
    let session = Session::open(|_| ());
    assert_eq!(session.warnings(&state(1, 0.5, 0.0)), "");
    assert_eq!(session.warnings(&state(2, 0.501, 0.0)), "");
    assert!(session.warnings(&state(3, 0.4, 0.0)).contains("went back from 0.501 to 0.4"));
    assert_eq!(session.warnings(&state(4, 0.45, 0.0)), "");
    assert!(session.warnings(&state(5, 3.45, 0.0)).contains("3000 periods"));
}

#[test]
fn a_jump_of_the_sequence_number_is_flagged() {
    let session = Session::open(|_| ());
    session.warnings(&state(1, 0.001, 0.0));
    assert!(session.warnings(&state(5000, 0.002, 0.0)).contains("advanced by 4999"));
    // A client that was silent for half a second counts on.
    assert!(!session.warnings(&state(5500, 0.502, 0.0)).contains("sequence"));
    // Twice the number of periods is plausible above 100 states.
    assert!(!session.warnings(&state(5650, 0.592, 0.0)).contains("sequence"));
    assert!(session.warnings(&state(5850, 0.682, 0.0)).contains("advanced by 200"));
}

#[test]
fn a_position_that_no_motion_explains_is_flagged() {
    let session = Session::open(|_| ());
    session.warnings(&state(1, 0.001, 0.0));
    assert_eq!(session.warnings(&state(2, 0.002, 0.01)), "");
    let flagged = session.warnings(&state(3, 0.003, 0.06));
    assert!(flagged.contains("`j1` jumped") && flagged.contains("check the sensor"), "{flagged}");
    // The joint may move by 0.17 rad in 0.1 s.
    assert_eq!(session.warnings(&state(103, 0.103, -0.1)), "");
    // 0.02 rad and one and a half times its speed limit, 0.28 rad in 0.1 s.
    assert!(session.warnings(&state(203, 0.203, -0.4)).contains("`j1` jumped"));
}

/// The first joint of a Gen3 turns without end. Its encoder does not.
#[test]
fn an_encoder_that_begins_anew_is_named() {
    let session = Session::open(|controller| controller["robot"] = json!("gen3"));
    let at = |sequence: u64, position: f64| state(sequence, 0.001 * sequence as f64, position);
    session.warnings(&at(1, 3.1));
    let flagged = session.warnings(&at(2, -3.1));
    assert!(flagged.contains("`joint_1` jumped") && flagged.contains("a whole turn"), "{flagged}");
    assert!(session.warnings(&at(3, 0.0)).contains("check the sensor"));
}

#[test]
fn stateless_steps_compare_the_state_with_that_of_the_memory() {
    let service = Service::start();
    let mut request = example("step.json");
    let first = service.call("/v1/step", &request);
    request["memory"] = first["memory"].clone();
    request["state"]["sequence"] = json!(18);
    request["state"]["time_s"] = json!(-1.0);
    request["state"]["joint_position"][0] = json!(2.5);
    assert!(warnings(&service.call("/v1/step", &request)).contains("went back"));
    request["state"]["time_s"] = json!(0.018);
    assert!(warnings(&service.call("/v1/step", &request)).contains("jumped"));
    // A memory of an older version has no state to compare with.
    for field in ["time_s", "joint_position"] {
        request["memory"].as_object_mut().unwrap().remove(field);
    }
    assert_eq!(warnings(&service.call("/v1/step", &request)), "");
    request["memory"]["time_s"] = json!(1e300);
    request["memory"]["joint_position"] = json!([0.0]);
    service.post("/v1/step", &request.to_string()).assert_refused(422, Some("/memory/time_s"));
}

#[test]
fn an_arm_that_is_too_fast_to_stop_is_flagged() {
    let session = Session::open(|_| ());
    let mut state = example("state.json");
    state["joint_position"][0] = json!(session.upper() - 0.1);
    state["joint_velocity"][0] = json!(1.7);
    assert!(session.warnings(&state).contains("`j1` is too fast to stop"));
}

#[test]
fn the_validity_is_at_most_the_configured_one_and_shorter_near_a_limit() {
    let fast = json!([{"name": "run", "law": {"kind": "posture", "gain": 100,
        "target_position": {"kind": "constant", "value": [9, 0, 3, 2, 3, 0, 0]}}}]);
    let valid_at = |session: &Session, distance: f64| {
        let mut state = example("state.json");
        state["joint_position"] = json!([session.upper() - distance, 0, 3, 2, 3, 0, 0]);
        let answer = session.send(&state).accepted();
        assert_eq!(numbers(&answer["braking_deceleration"]), [8.0, 8.0, 8.0, 8.0, 10.0, 10.0, 10.0]);
        answer["valid_for_ms"].as_u64().unwrap()
    };
    let open = |valid: Option<u64>| {
        Session::open(|controller| {
            controller["tasks"] = fast.clone();
            controller["limits"] = json!("position_velocity");
            if let Some(valid) = valid {
                controller["valid_for_ms"] = json!(valid);
            }
        })
    };
    let near: Vec<u64> = [1.0, 0.3, 0.2, 0.1, 0.01].map(|distance| valid_at(&open(None), distance)).into();
    assert_eq!((near[0], near[4]), (100, 11));
    assert!(near.is_sorted_by(|a, b| a >= b), "{near:?}");
    assert_eq!((valid_at(&open(Some(20)), 1.0), valid_at(&open(Some(20)), 0.01)), (20, 11));
    assert_eq!(valid_at(&open(Some(1000)), 2.0), 1000);

    let service = Service::start();
    for wrong in [json!(0), json!(10_001), json!(-1), json!(1.5), json!(null)] {
        let mut controller = example("controller.json");
        controller["valid_for_ms"] = wrong;
        service.post("/v1/controllers", &controller.to_string()).assert_refused(422, Some("/valid_for_ms"));
        let mut request = example("step.json");
        request["controller"] = controller;
        service.post("/v1/step", &request.to_string()).assert_refused(422, Some("/controller/valid_for_ms"));
    }
    for field in ["position_tolerance", "max_force_n", "max_torque_nm"] {
        let mut controller = example("controller.json");
        controller["state_checks"] = json!({field: -1});
        let answer = service.post("/v1/controllers", &controller.to_string());
        answer.assert_refused(422, Some(&format!("/state_checks/{field}")));
    }
}

#[test]
fn whole_numbers_may_have_a_fraction_of_zero() {
    let session = Session::open(|_| ());
    let text = state(7, 0.0, 0.0).to_string().replace("\"sequence\":7", "\"sequence\":214103.0");
    assert_eq!(session.service.post(&session.path, &text).accepted()["sequence"], 214_103);
    let half = text.replace("214103.0", "214104.5");
    session.service.post(&session.path, &half).assert_refused(422, Some("/sequence"));

    let mut memory = example("step_again.json");
    memory["memory"]["sequence"] = json!(17.0);
    session.service.call("/v1/step", &memory);
}

/// Returns a controller that moves all joints by 0.3 rad from the posture of the example state.
fn moving() -> Value {
    let target: Vec<f64> = numbers(&example("state.json")["joint_position"]).iter().map(|q| q + 0.3).collect();
    let law = json!({"kind": "posture", "gain": 2, "target_position": {"kind": "constant", "value": target}});
    json!({"robot": "sawyer_dh", "period_s": 0.01, "tasks": [{"name": "move", "law": law}]})
}

#[test]
fn joints_that_a_brake_holds_are_named_with_and_without_a_session() {
    let session = Session::open(|controller| *controller = moving());
    let mut memory = Value::Null;
    for k in 0..90_u32 {
        // The brake of the first joint opens after 0.7 s.
        let state = state(u64::from(k), 0.01 * f64::from(k), 0.005 * (f64::from(k) - 70.0).max(0.0));
        let answer = session.send(&state).accepted();
        let stateless = json!({"controller": moving(), "state": state, "memory": memory});
        let stateless = session.service.call("/v1/step", &stateless);
        memory = stateless["memory"].clone();
        let found = warnings(&answer);
        assert_eq!(found, warnings(&stateless), "period {k}");
        let has = |part: &str| found.contains(part);
        assert!(k > 54 || found.is_empty(), "period {k}: {found}");
        if (65..70).contains(&k) {
            assert!(has("`j1`, `j2`, `j3`, `j4`, `j5`, `j6`, `j7`; `j1` was commanded 0."), "period {k}: {found}");
            assert!(has("for 0.55 s and moved by 0.0000 rad. Check brakes"), "period {k}: {found}");
        }
        assert!(k < 85 || !has("`j1`") && has("`j2`, `j3`"), "period {k}: {found}");
    }
    let next = state(90, 0.9, 0.0);
    for (field, value, pointer) in [
        ("joint", json!("j9"), "/memory/stalls/0/joint"),
        ("moved", json!(1e300), "/memory/stalls/0/moved"),
        ("time_s", json!(-1), "/memory"),
    ] {
        let mut damaged = memory.clone();
        damaged["stalls"][0][field] = value;
        let request = json!({"controller": moving(), "state": next, "memory": damaged});
        session.service.post("/v1/step", &request.to_string()).assert_refused(422, Some(pointer));
    }
}

/// A loop that believed such a speed would make an arm at rest start at full speed.
#[test]
fn a_first_speed_that_no_joint_can_have_is_not_believed() {
    let moving = |sequence: u64, speed: f64| {
        let mut state = state(sequence, 0.01 * sequence as f64, 0.0);
        state["joint_velocity"] = json!(vec![speed; 7]);
        state
    };
    let speed = |answer: &Value| numbers(&answer["joint_velocity"]).iter().fold(0.0_f64, |speed, v| speed.max(v.abs()));
    let resting = speed(&Session::open(|_| ()).send(&moving(1, 0.0)).accepted());
    // The limits of the arm are 1.74 to 4.545 rad/s.
    for implausible in [7.0, -57.0, 1e9] {
        let session = Session::open(|_| ());
        let answer = session.send(&moving(1, implausible)).accepted();
        assert!(warnings(&answer).contains("it is not believed, and the command starts from rest"), "{answer}");
        assert_eq!(speed(&answer), resting, "{implausible}");
        let next = session.send(&moving(2, implausible)).accepted();
        assert!(warnings(&next).contains("check the sensor and its unit"), "{next}");
        assert!(speed(&next) < 3.0 * resting + 0.2, "{next}");
    }
    // An arm that moves is taken over as it moves.
    let answer = Session::open(|_| ()).send(&moving(1, 0.5)).accepted();
    assert!(!warnings(&answer).contains("believed") && speed(&answer) > 0.3, "{answer}");
}
