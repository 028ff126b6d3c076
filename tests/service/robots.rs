//! Registered robots, from registration to deletion.

use serde_json::{Value, json};

use crate::harness::{Service, numbers, without};

/// A URDF with one joint about z and a tool at a distance of 2 m.
pub const CRANK: &str = r#"<robot name="unused">
  <link name="base"/><link name="arm"/><link name="tool"/>
  <joint name="crank" type="revolute">
    <parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1.5" acceleration="4"/>
  </joint>
  <joint name="hand" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="2 0 0"/></joint>
</robot>"#;

/// Body of `POST /v1/robots`.
pub fn registration(name: &str, urdf: &str) -> Value {
    json!({"name": name, "urdf": urdf})
}

/// Returns a problem: a velocity along y, for a robot with one joint.
fn pull(robot: &str) -> Value {
    json!({
        "robot": robot, "joint_position": [0.0], "period_s": 0.001,
        "tasks": [{"axes": ["y"], "velocity": [0.5]}]
    })
}

fn controller(robot: &str) -> Value {
    let law = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": [0.5]}});
    json!({"robot": robot, "period_s": 0.001, "limits": "position_velocity", "tasks": [{"name": "pull", "axes": ["y"], "law": law}]})
}

#[test]
fn a_robot_is_registered_used_and_deleted() {
    let service = Service::start();
    service.post("/v1/resolve", &pull("crank").to_string()).assert_refused(422, Some("/robot"));
    let created = service.post("/v1/robots", &registration("crank", CRANK).to_string());
    assert_eq!((created.status, created.location.as_deref()), (201, Some("/v1/robots/crank")));
    let shown = service.get("/v1/robots/crank").accepted();
    assert_eq!(created.json(), shown);
    assert_eq!((&shown["name"], &shown["source"]), (&json!("crank"), &json!("urdf")));
    let joint = &shown["joints"][0];
    assert_eq!((&joint["name"], &joint["position_limit"]), (&json!("crank"), &json!([-3.0, 3.0])));
    assert_eq!((&joint["velocity_limit"], &joint["acceleration_limit"]), (&json!(1.5), &json!(4.0)));
    assert!(service.get("/v1/robots").accepted()["robots"].as_array().unwrap().contains(&shown));

    // 0.5 m/s at a distance of 2 m is 0.25 rad/s.
    let answer = service.call("/v1/resolve", &pull("crank"));
    assert!((numbers(&answer["joint_velocity"])[0] - 0.25).abs() < 1e-12, "{answer}");

    assert_eq!(service.delete("/v1/robots/crank").status, 204);
    for answer in [service.get("/v1/robots/crank"), service.delete("/v1/robots/crank")] {
        answer.assert_refused(404, None);
    }
    service.post("/v1/controllers", &controller("crank").to_string()).assert_refused(422, Some("/robot"));
}

#[test]
fn a_session_keeps_its_robot_when_another_robot_gets_the_name() {
    let service = Service::start();
    service.post("/v1/robots", &registration("crank", CRANK).to_string()).accepted();
    let session = service.open(&controller("crank"));
    service.delete("/v1/robots/crank");
    let shorter = CRANK.replace("2 0 0", "1 0 0");
    service.post("/v1/robots", &registration("crank", &shorter).to_string()).accepted();
    let step = |session: &str| {
        let state = json!({"sequence": 1, "time_s": 0.0, "joint_position": {"crank": 0.0}});
        numbers(&service.call(&format!("{session}/step"), &state)["joint_velocity"])[0]
    };
    assert!((step(&session) - 0.25).abs() < 1e-12);
    assert!((step(&service.open(&controller("crank"))) - 0.5).abs() < 1e-12);
}

#[test]
fn joints_without_acceleration_limit_obey_their_other_limits() {
    let service = Service::start();
    let free = CRANK.replace(r#"acceleration="4""#, "");
    service.post("/v1/robots", &registration("free", &free).to_string()).accepted();
    service.post("/v1/robots", &registration("crank", CRANK).to_string()).accepted();
    let speed = |robot: &str| {
        let mut question = pull(robot);
        question["limits"] = json!("position_velocity_acceleration");
        question["joint_velocity"] = json!([0.0]);
        question["tasks"][0]["velocity"] = json!([100.0]);
        numbers(&service.call("/v1/resolve", &question)["joint_velocity"])[0]
    };
    assert!((speed("crank") - 0.004).abs() < 1e-12 && (speed("free") - 1.5).abs() < 1e-12);
}

#[test]
fn a_stated_jerk_limit_is_shown_and_kept_with_the_memory_of_stateless_steps() {
    let service = Service::start();
    let mut body = registration("soft", CRANK);
    body["limits"] = json!({"crank": {"jerk": 100.0}});
    let soft = service.post("/v1/robots", &body.to_string()).accepted();
    assert_eq!(
        (&soft["joints"][0]["jerk_limit"], &soft["joints"][0]["acceleration_limit"]),
        (&json!(100.0), &json!(4.0))
    );
    let mut running = controller("soft");
    running["limits"] = json!("position_velocity_acceleration");
    let mut memory = json!(null);
    let mut commands = vec![0.0, 0.0];
    for sequence in 1..20 {
        let position = 0.001 * commands.iter().sum::<f64>();
        let state = json!({"sequence": sequence, "time_s": 0.001 * f64::from(sequence), "joint_position": [position]});
        let question = json!({"controller": running, "state": state, "memory": memory});
        let answer = service.call("/v1/step", &question);
        commands.push(numbers(&answer["joint_velocity"])[0]);
        let [before, last, now] = commands[commands.len() - 3..] else { unreachable!("three commands") };
        assert!((now - 2.0 * last + before).abs() <= 1e-4 + 1e-12, "{commands:?}");
        memory = answer["memory"].clone();
        let remembered = numbers(&memory["jerk"]["acceleration"])[0];
        assert!((remembered - (now - last) / 0.001).abs() < 1e-9);
    }
    assert!((commands[2] - 1e-4).abs() < 1e-12 && commands[5] > 9e-4, "{commands:?}");
}

/// Opens a stateless loop at rest at a position of the crank; returns its first answer.
fn first_step(service: &Service, controller: &Value, position: f64, velocity: f64) -> Value {
    let state = json!({"sequence": 1, "time_s": 0.0, "joint_position": [position], "joint_velocity": [velocity]});
    service.call("/v1/step", &json!({"controller": controller, "state": state}))
}

#[test]
fn a_velocity_envelope_is_shown_and_kept_wherever_it_is_stated() {
    let service = Service::start();
    let envelope = json!({"deceleration_limit": 2.0, "velocity_offset": 0.1});
    let mut stated = registration("stated", CRANK);
    stated["limits"] = json!({"crank": {"velocity_envelope": envelope}});
    let element = r#"<position_based_velocity_limits deceleration_limit="2.0" velocity_offset="0.1"/></joint>"#;
    let text = registration("text", &CRANK.replacen("</joint>", element, 1));
    for body in [stated, text] {
        let robot = service.post("/v1/robots", &body.to_string()).accepted();
        assert_eq!(robot["joints"][0]["velocity_envelope"], envelope);
        let name = robot["name"].as_str().unwrap();
        assert_eq!(service.get(&format!("/v1/robots/{name}")).accepted(), robot);
        // v (0.011 + o/D) + v²/2D = d − o²/2D for d = 0.1 and T = 1 ms.
        let mut question = pull(name);
        (question["joint_position"], question["tasks"][0]["velocity"]) = (json!([2.9]), json!([-100.0]));
        question["period_s"] = json!(0.001);
        let answer = service.call("/v1/resolve", &question);
        let speed = numbers(&answer["joint_velocity"])[0];
        assert!((speed * 0.061 + speed * speed / 4.0 - 0.0975).abs() < 1e-9, "{answer}");
    }
    let plain = service.post("/v1/robots", &registration("plain", CRANK).to_string()).accepted();
    assert!(plain["joints"][0].get("velocity_envelope").is_none(), "{plain}");
    let fr3 = service.get("/v1/robots/fr3").accepted();
    assert_eq!(fr3["joints"][1]["velocity_envelope"], json!({"deceleration_limit": 2.585, "velocity_offset": 0.2}));
}

#[test]
fn a_velocity_envelope_that_allows_no_motion_is_refused() {
    let service = Service::start();
    for (envelope, pointer, cause) in [
        (json!({"deceleration_limit": 0, "velocity_offset": 0}), "/limits", "deceleration 0, which must be positive"),
        (
            json!({"deceleration_limit": 6, "velocity_offset": -0.1}),
            "/limits",
            "offset -0.1, which must not be negative",
        ),
        (json!({"deceleration_limit": 1e-200, "velocity_offset": 1}), "/limits", "leaves no range"),
        (json!({"deceleration_limit": 1, "velocity_offset": 3}), "/limits", "leaves no range"),
        (json!({"deceleration_limit": 6}), "/limits/crank/velocity_envelope", "velocity_offset"),
        (
            json!({"deceleration_limit": 6, "velocity_offset": 0, "margin": 1}),
            "/limits/crank/velocity_envelope/margin",
            "margin",
        ),
        (json!([6, 0.3]), "/limits/crank/velocity_envelope", "object"),
        (
            json!({"deceleration_limit": "6", "velocity_offset": 0}),
            "/limits/crank/velocity_envelope/deceleration_limit",
            "number",
        ),
    ] {
        let mut body = registration("crank", CRANK);
        body["limits"] = json!({"crank": {"velocity_envelope": envelope}});
        let answer = service.post("/v1/robots", &body.to_string());
        answer.assert_refused(422, Some(pointer));
        assert!(answer.text.contains(cause), "{}", answer.text);
    }
}

#[test]
fn a_start_outside_the_velocity_envelope_is_told_and_left() {
    let service = Service::start();
    let mut body = registration("crank", CRANK);
    body["limits"] = json!({"crank": {"velocity_envelope": {"deceleration_limit": 2.0, "velocity_offset": 0.2}}});
    service.post("/v1/robots", &body.to_string()).accepted();
    let mut running = controller("crank");
    running["why"] = json!(true);
    // Towards the upper end.
    running["tasks"][0]["law"]["target_velocity"]["value"] = json!([-0.5]);
    let texts = |answer: &Value| format!("{} {}", answer["warnings"], answer["why"]);
    // The margin is 0.01 rad.
    let within = first_step(&service, &running, 2.995, 0.0);
    assert!(numbers(&within["joint_velocity"])[0] < 0.0 && texts(&within).contains("must move back"), "{within}");
    assert!(texts(&within).contains("nearer to the end of its range than 0.0100 rad"), "{within}");
    let fast = first_step(&service, &running, 2.9, 1.0);
    assert!(texts(&fast).contains("faster than its velocity envelope allows"), "{fast}");
    let inside = first_step(&service, &running, 2.989, 0.0);
    assert!(!texts(&inside).contains("velocity envelope lets") && !texts(&inside).contains("faster"), "{inside}");
}

#[test]
fn base_and_tip_select_the_chain() {
    let service = Service::start();
    let mut body = registration("short", CRANK);
    (body["base"], body["tip"]) = (json!("base"), json!("arm"));
    let short = service.post("/v1/robots", &body.to_string()).accepted();
    assert!(short["description"].as_str().unwrap().contains("to link `arm`"));
    let full = service.post("/v1/robots", &registration("full", CRANK).to_string()).accepted();
    let chain = json!({"base": "base", "tip": "arm", "reason": "request", "joints": ["crank"], "left_out": []});
    assert_eq!((&short["chain"], &full["chain"]["reason"]), (&chain, &json!("only_end")));
    assert_eq!((&short["tips"][0]["link"], &full["tips"][0]["link"]), (&json!("arm"), &json!("tool")));
    let same = ["name", "description", "chain", "tips", "links"];
    assert_eq!(without(short, &same), without(full, &same));
    let reached = service.call("/v1/resolve", &pull("short"))["tasks"][0]["achieved"][0].as_f64().unwrap();
    assert_eq!(reached, 0.0, "the tool is not on the axis");
}

/// The crank with a gripper on its tool and a second joint, and a wheel at its base.
fn with_gripper() -> String {
    let more = r#"<link name="fore"/><link name="finger"/><link name="wheel"/>
  <joint name="elbow" type="revolute">
    <parent link="tool"/><child link="fore"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="0"/>
  </joint>
  <joint name="grip" type="prismatic">
    <parent link="fore"/><child link="finger"/><limit lower="0" upper="0.1" velocity="1"/>
  </joint>
  <joint name="roll" type="continuous"><parent link="base"/><child link="wheel"/></joint>
</robot>"#;
    CRANK.replace("</robot>", more)
}

#[test]
fn a_registration_mends_limits_and_names_what_it_left_out() {
    let service = Service::start();
    let mut body = registration("mended", &with_gripper());
    let refused = service.post("/v1/robots", &body.to_string());
    refused.assert_refused(422, Some("/urdf"));
    assert!(refused.json()["detail"].as_str().unwrap().contains(r#""elbow": {"velocity""#), "{}", refused.json());

    body["limits"] = json!({"elbow": {"velocity": 2.0, "acceleration": 9.0, "position": [-1.0, 1.0]}});
    body["joint_names"] = json!({"elbow": "q2"});
    body["tool_offset"] = json!({"position": [0.5, 0, 0], "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}});
    let mended = service.post("/v1/robots", &body.to_string()).accepted();
    assert_eq!(service.get("/v1/robots/mended").accepted(), mended);
    let left_out = json!([{"joint": "grip", "reason": "gripper"}, {"joint": "roll", "reason": "leg_or_wheel"}]);
    let chain = json!({"base": "base", "tip": "fore", "reason": "before_gripper", "joints": ["crank", "q2"], "left_out": left_out});
    assert_eq!(mended["chain"], chain);
    let elbow = &mended["joints"][1];
    assert_eq!((&elbow["velocity_limit"], &elbow["position_limit"]), (&json!(2.0), &json!([-1.0, 1.0])));
    let pose = service.call("/v1/kinematics", &json!({"robot": "mended", "joint_position": [0.0, 0.0]}));
    assert_eq!(pose["pose"]["position"], json!([2.5, 0.0, 0.0]));
}

#[test]
fn wrong_overrides_are_refused_with_their_place() {
    let service = Service::start();
    for (field, value, pointer) in [
        ("limits", json!({"elbow": {"velocity": 1.0}}), "/limits"),
        ("limits", json!({"crank": {"velocity": 0.0}}), "/limits"),
        ("limits", json!({"crank": {"position": [1.0, -1.0]}}), "/limits"),
        ("joint_names", json!({"elbow": "j"}), "/joint_names"),
        ("joint_names", json!({"crank": ""}), "/joint_names"),
        (
            "tool_offset",
            json!({"position": [0, 0, 0], "orientation": {"w": 2, "x": 0, "y": 0, "z": 0}}),
            "/tool_offset/orientation",
        ),
    ] {
        let mut body = registration("wrong", CRANK);
        body[field] = value;
        service.post("/v1/robots", &body.to_string()).assert_refused(422, Some(pointer));
    }
    let two = CRANK.replace(
        "</robot>",
        r#"<link name="arm2"/><link name="b2"/>
  <joint name="i" type="continuous"><parent link="base"/><child link="arm2"/></joint>
  <joint name="k" type="continuous"><parent link="arm2"/><child link="b2"/></joint></robot>"#,
    );
    let two = two.replace(r#"<joint name="hand" type="fixed">"#, r#"<joint name="hand" type="continuous">"#);
    let refused = service.post("/v1/robots", &registration("two", &two).to_string());
    refused.assert_refused(422, Some("/tip"));
    assert!(
        refused.json()["detail"].as_str().unwrap().contains("2 arms; name the `tip`: `tool`, `b2`"),
        "{}",
        refused.json()
    );
    assert_eq!(refused.json()["candidates"], json!(["tool", "b2"]));
}

#[test]
fn every_built_in_arm_has_a_source_and_moves() {
    let service = Service::start();
    for (name, source, joints) in [
        ("sawyer_dh", "denavit_hartenberg", 7),
        ("sawyer", "urdf", 7),
        ("ur5e", "urdf", 6),
        ("panda", "urdf", 7),
        ("planar_3r", "urdf", 3),
        ("so101", "urdf", 5),
        ("fr3", "urdf", 7),
        ("xarm7", "urdf", 7),
        ("iiwa14", "urdf", 7),
        ("gen3", "urdf", 7),
    ] {
        let robot = service.get(&format!("/v1/robots/{name}")).accepted();
        assert_eq!((robot["source"].as_str(), robot["joints"].as_array().unwrap().len()), (Some(source), joints));
        // A joint that turns without end has no limit.
        let middle = |joint: &Value| match &joint["position_limit"] {
            Value::Null => 0.3,
            range => numbers(range).iter().sum::<f64>() / 2.0 + 0.3,
        };
        let posture: Vec<f64> = robot["joints"].as_array().unwrap().iter().map(middle).collect();
        let answer = service.call(
            "/v1/resolve",
            &json!({"robot": name, "joint_position": posture, "period_s": 0.001,
                "tasks": [{"axes": ["x", "y"], "velocity": [0.01, -0.02]}]}),
        );
        let achieved = numbers(&answer["tasks"][0]["achieved"]);
        assert!((achieved[0] - 0.01).abs() < 1e-9 && (achieved[1] + 0.02).abs() < 1e-9, "{name}: {answer}");
    }
}
