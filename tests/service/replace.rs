//! Another controller for a session that runs.

use serde_json::{Value, json};

use crate::harness::{Answer, Service};

const JSON: (&str, &str) = ("content-type", "application/json");
const PERIOD_S: f64 = 0.005;
/// Acceleration limits of `planar_3r`, rad/s².
const ACCELERATION: [f64; 3] = [10.0, 10.0, 15.0];

fn controller(limits: &str, tasks: &Value) -> Value {
    json!({"robot": "planar_3r", "period_s": PERIOD_S, "limits": limits, "tasks": tasks})
}

fn along(axis: &str, velocity: f64) -> Value {
    json!({"name": axis, "axes": [axis], "law": {"kind": "velocity", "target_velocity": {"kind": "constant", "value": [velocity]}}})
}

fn replace(service: &Service, session: &str, controller: &Value, headers: &[(&str, &str)]) -> Answer {
    service.send("PUT", session, &[&[JSON], headers].concat(), &controller.to_string())
}

/// A session with an arm that follows its commands at once.
struct Arm<'a> {
    service: &'a Service,
    session: String,
    q: Vec<f64>,
    velocity: Vec<f64>,
    sequence: u64,
}

impl Arm<'_> {
    /// Runs one period. Returns the answer, and the largest change of a joint's velocity relative to A T.
    fn step(&mut self) -> (Value, f64) {
        let state =
            json!({"sequence": self.sequence, "time_s": PERIOD_S * self.sequence as f64, "joint_position": self.q});
        let answer = self.service.call(&format!("{}/step", self.session), &state);
        let velocity: Vec<f64> = serde_json::from_value(answer["joint_velocity"].clone()).unwrap();
        let changes = self.velocity.iter().zip(&velocity).zip(ACCELERATION);
        let change = changes.map(|((last, now), a)| (now - last).abs() / (a * PERIOD_S)).fold(0.0, f64::max);
        self.q.iter_mut().zip(&velocity).for_each(|(q, v)| *q += PERIOD_S * v);
        (self.velocity, self.sequence) = (velocity, self.sequence + 1);
        (answer, change)
    }
}

fn arm<'a>(service: &'a Service, controller: &Value) -> Arm<'a> {
    let session = service.open(controller);
    Arm { service, session, q: vec![0.3, 0.9, -0.8], velocity: vec![0.0; 3], sequence: 1 }
}

#[test]
fn tasks_are_added_reordered_and_removed_without_a_jump() {
    let service = Service::start();
    let stacks = [
        json!([along("x", 0.2), along("y", -0.1)]),
        json!([along("y", 0.2), along("x", -0.2)]),
        json!([along("rz", 0.5)]),
        json!([{"name": "stop", "jacobian": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "law": {"kind": "velocity", "target_velocity": {"kind": "constant", "value": [0, 0, 0]}}}]),
    ];
    let mut arm = arm(&service, &controller("velocity", &json!([along("x", 0.1)])));
    for _ in 0..5 {
        arm.step();
    }
    for tasks in stacks {
        let new = controller("velocity", &tasks);
        let created = replace(&service, &arm.session, &new, &[]).accepted();
        assert!(arm.session.ends_with(created["id"].as_str().unwrap()));
        assert_eq!(created["joints"].as_array().unwrap().len(), 3);
        let changes: Vec<f64> = (0..60)
            .map(|_| {
                let (answer, change) = arm.step();
                assert_eq!(answer["tasks"].as_array().unwrap().len(), tasks.as_array().unwrap().len());
                assert_eq!(answer["tasks"][0]["name"], tasks[0]["name"]);
                change
            })
            .collect();
        let largest = changes.iter().copied().fold(0.0, f64::max);
        assert!(largest <= 1.0 + 1e-9, "{largest}");
        assert!(largest >= 0.9, "the tasks do not differ enough: {largest}");
        assert!(*changes.last().unwrap() < 0.1, "the transition has not ended");
        assert_eq!(service.get(&arm.session).json()["controller"]["tasks"][0]["name"], tasks[0]["name"]);
    }
    assert!(arm.velocity.iter().all(|velocity| velocity.abs() < 1e-9), "{:?}", arm.velocity);
}

#[test]
fn a_replaced_controller_without_a_step_starts_anew() {
    let service = Service::start();
    let mut arm = arm(&service, &controller("velocity", &json!([along("x", 0.1)])));
    replace(&service, &arm.session, &controller("velocity", &json!([along("y", 0.1)])), &[]).accepted();
    assert_eq!(arm.step().0["tasks"][0]["name"], "y");
}

#[test]
fn a_tool_offset_that_moves_nothing_is_none() {
    let service = Service::start();
    let running = controller("velocity", &json!([along("x", 0.1)]));
    let mut arm = arm(&service, &running);
    arm.step();
    let mut stated = running.clone();
    stated["tool_offset"] = json!({"position": [0, 0, 0], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}});
    for controller in [stated, running] {
        replace(&service, &arm.session, &controller, &[]).accepted();
        arm.step();
    }
}

#[test]
fn what_belongs_to_the_arm_cannot_be_replaced_and_nothing_changes_then() {
    let service = Service::start();
    let running = controller("velocity", &json!([along("x", 0.1)]));
    let mut arm = arm(&service, &running);
    for steps in 0..2 {
        for (field, value, pointer) in [
            ("robot", json!("sawyer"), "/robot"),
            (
                "tool_offset",
                json!({"position": [0, 0, 0.1], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}),
                "/robot",
            ),
            ("period_s", json!(0.01), "/period_s"),
            ("drive", json!({"lag_s": 0, "delay_periods": 0}), "/drive"),
            ("solver", json!("closed_form"), "/solver"),
            ("tasks", json!([]), "/tasks"),
        ] {
            let mut changed = running.clone();
            changed[field] = value;
            replace(&service, &arm.session, &changed, &[]).assert_refused(422, Some(pointer));
        }
        assert_eq!(arm.step().0["tasks"][0]["name"], "x", "after {steps} steps");
    }
    replace(&service, "/v1/controllers/nobody", &running, &[]).assert_refused(404, None);
}

#[test]
fn only_the_owner_replaces_a_controller() {
    let service = Service::start();
    let running = controller("velocity", &json!([along("x", 0.1)]));
    let owner = ("revprio-owner", "cell-7");
    let opened = service.send("POST", "/v1/controllers", &[JSON, owner], &running.to_string());
    let session = opened.location.unwrap();
    replace(&service, &session, &running, &[]).assert_refused(403, None);
    replace(&service, &session, &running, &[owner]).accepted();
}

#[test]
fn a_profile_that_is_over_when_its_controller_comes_is_warned_of() {
    let service = Service::start();
    let hold = json!([along("x", 0.0)]);
    let moving = |end_s: f64| {
        let points = json!([{"time_s": 0, "value": [0]}, {"time_s": end_s, "value": [0.1]}]);
        let law = json!({"kind": "velocity", "target_velocity": {"kind": "waypoints", "points": points}});
        json!([{"name": "x", "axes": ["x"], "law": law}])
    };
    for start_s in [0.0, 1.7e9] {
        let session = service.open(&controller("position_velocity_acceleration", &hold));
        for sequence in 1..40_u32 {
            let time_s = start_s + PERIOD_S * f64::from(sequence);
            let state = json!({"sequence": sequence, "time_s": time_s, "joint_position": [0.3, 0.5, -0.4]});
            service.call(&format!("{session}/step"), &state);
        }
        let warned = |end_s: f64| {
            let controller = controller("position_velocity_acceleration", &moving(end_s));
            let answer = replace(&service, &session, &controller, &[]).accepted();
            answer["warnings"].to_string().contains("its profile ended at")
        };
        assert!(warned(0.1), "{start_s}");
        assert!(!warned(0.1), "a profile that was followed, {start_s}");
        assert!(!warned(0.5), "{start_s}");
    }
}

/// The answer to the last state may have been lost before the controller was replaced.
#[test]
fn the_last_state_gets_its_answer_again_after_its_task_is_gone() {
    let service = Service::start();
    let hand = json!({"name": "hand", "axes": ["x"], "law": {"kind": "pose", "gain": 2.0}});
    let session = service.open(&controller("position_velocity", &json!([hand])));
    let state = json!({"sequence": 1, "time_s": 0.0, "joint_position": [0.3, 0.9, -0.8],
        "targets": {"hand": {"pose": {"position": [1.0, 0.5, 0.0]}}}});
    let step = format!("{session}/step");
    let answer = service.call(&step, &state);
    let other = controller("position_velocity", &json!([along("y", 0.1)]));
    assert_eq!(replace(&service, &session, &other, &[]).status, 200);
    assert_eq!(service.call(&step, &state), answer);
}
