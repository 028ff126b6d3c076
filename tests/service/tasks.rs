//! Options of tasks: gains, frames, tool offsets, null-space motion.

use std::ops::ControlFlow;

use revprio_api::Client;
use revprio_api::wire::{WrenchConvention, WrenchFrame};
use revprio_lab::simulator::{CallMode, Scenario, run};
use serde_json::{Value, json};

use crate::harness::{Service, example, numbers, without};

fn resolved(service: &Service, change: impl Fn(&mut Value)) -> Value {
    let mut request = example("resolve.json");
    change(&mut request);
    without(service.call("/v1/resolve", &request), &["elapsed_us"])
}

fn largest_difference(a: &Value, b: &Value) -> f64 {
    let (a, b) = (numbers(&a["joint_velocity"]), numbers(&b["joint_velocity"]));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn one_gain_for_all_axes_gives_the_same_bytes_as_one_per_axis() {
    let service = Service::start();
    let answer = |inertia: Value, stiffness: Value, target: Value| {
        let mut step = example("step.json");
        let tasks = &mut step["controller"]["tasks"];
        tasks[1]["law"]["inertia"] = inertia;
        tasks[1]["law"]["stiffness"] = stiffness;
        tasks[0]["law"]["target_force"]["value"] = target;
        without(service.call("/v1/step", &step), &["elapsed_us"]).to_string()
    };
    let each = answer(json!([15, 15, 15, 15, 15]), json!([700, 700, 700, 700, 700]), json!([30]));
    assert_eq!(answer(json!(15), json!(700.0), json!(30)), each);
}

#[test]
fn a_task_in_a_rotated_frame_equals_the_rotated_task() {
    let service = Service::start();
    // A rotation by 90° about z: x of the frame is y of the base.
    let half = 0.5_f64.sqrt();
    let frame = json!({"position": [9, 9, 9], "orientation": {"w": half, "x": 0, "y": 0, "z": half}});
    let along = resolved(&service, |request| {
        request["tasks"] = json!([{"axes": ["x", "rx"], "frame": frame, "velocity": [0.05, 0.02]}]);
    });
    let turned = resolved(&service, |request| {
        request["tasks"] = json!([{"axes": ["y", "ry"], "velocity": [0.05, 0.02]}]);
    });
    assert!(largest_difference(&along, &turned) < 1e-14);
}

#[test]
fn a_tool_offset_moves_the_tool_point_as_a_reference_point_does() {
    let service = Service::start();
    let turning = |change: &dyn Fn(&mut Value)| {
        resolved(&service, |request| {
            request["tasks"][1]["velocity"] = json!([0, 0, 0.1, -0.2, 0.1]);
            change(request);
        })
    };
    let offset = turning(&|request| {
        let orientation = json!({"w": 0.8, "x": 0, "y": 0.6, "z": 0});
        request["tool_offset"] = json!({"position": [0.0, 0.1, 0.3], "orientation": orientation});
    });
    let point = turning(&|request| {
        for k in 0..2 {
            request["tasks"][k]["reference_point"] = json!([0.0, 0.1, 0.3]);
        }
    });
    assert!(largest_difference(&offset, &point) < 1e-13);
    assert!(largest_difference(&offset, &turning(&|_| ())) > 1e-3, "the offset changes nothing");
}

#[test]
fn an_extreme_target_gives_a_command_inside_the_limits() {
    let service = Service::start();
    let jump = json!({"kind": "waypoints", "points": [{"time_s": 0, "value": -1e9}, {"time_s": 1e-6, "value": 1e9},
        {"time_s": 2e-6, "value": -1e9}]});
    let shake = json!({"kind": "sine", "offset": 0, "amplitude": 1e9, "angular_frequency_rad_s": 1e9});
    for displacement in [jump, shake] {
        for law in [
            json!({"kind": "pose", "gain": 1999}),
            json!({"kind": "impedance", "inertia": 1e-6, "damping": 1e9, "stiffness": 1e9}),
        ] {
            let mut step = example("step.json");
            step["state"]["time_s"] = json!(1.3e-6);
            let task = &mut step["controller"]["tasks"][1];
            task["law"] = law;
            task["law"]["target_displacement"] = displacement.clone();
            for sequence in [17, 18] {
                step["state"]["sequence"] = json!(sequence);
                let answer = service.call("/v1/step", &step);
                let velocity = numbers(&answer["joint_velocity"]);
                assert!(velocity.iter().all(|speed| speed.abs() < 5.0), "{velocity:?}");
                step["memory"] = answer["memory"].clone();
            }
        }
    }
}

#[test]
fn null_space_motions_equal_their_explicit_velocities() {
    let service = Service::start();
    let with = |motion: Value| {
        resolved(&service, |request| {
            request["null_space_velocity"] = motion.clone();
            request["tasks"] = json!([{"axes": ["x", "y", "z"], "velocity": [0.01, 0, 0]}]);
        })
    };
    let q = numbers(&example("resolve.json")["joint_position"]);
    let wanted = [0.1, -0.5, 0.3, 1.2, 0.0, 1.0, 0.1];
    let drawn: Vec<f64> = wanted.iter().zip(&q).map(|(wanted, q)| 0.5 * (wanted - q)).collect();
    let posture = with(json!({"kind": "posture", "joint_position": wanted, "gain": 0.5}));
    assert_eq!(posture["joint_velocity"], with(json!(drawn))["joint_velocity"]);

    let robot = service.get("/v1/robots/sawyer_dh").accepted();
    let away = |(i, q): (usize, &f64)| {
        let range = numbers(&robot["joints"][i]["position_limit"]);
        let half = 0.5 * (range[1] - range[0]);
        -2.0 * (q - f64::midpoint(range[0], range[1])) / (7.0 * half * half)
    };
    let away: Vec<f64> = q.iter().enumerate().map(away).collect();
    let limits = with(json!({"kind": "joint_limits", "gain": 2.0}));
    assert!(largest_difference(&limits, &with(json!(away))) < 1e-14);
    assert!(largest_difference(&limits, &with(json!([0, 0, 0, 0, 0, 0, 0]))) > 1e-3);
}

#[test]
fn answers_contain_the_joint_limit_index_if_the_posture_is_known() {
    let service = Service::start();
    let robot = service.get("/v1/robots/sawyer_dh").accepted();
    let upper: Vec<f64> = (0..7).map(|i| numbers(&robot["joints"][i]["position_limit"])[1]).collect();
    let at_the_ends = resolved(&service, |request| request["joint_position"] = json!(upper));
    assert!((at_the_ends["joint_limit_index"].as_f64().unwrap() - 0.5).abs() < 1e-15);
    let step = service.call("/v1/step", &example("step.json"));
    assert!((0.0..0.5).contains(&step["joint_limit_index"].as_f64().unwrap()));
    let own = service.call("/v1/resolve", &json!({"tasks": [{"jacobian": [[1, 0]], "velocity": [1]}]}));
    assert_eq!(own.get("joint_limit_index"), None);
}

#[test]
fn laws_without_force_feedback_need_no_wrench() {
    let service = Service::start();
    let law = json!({"kind": "pose", "gain": 2});
    let posture = json!({"kind": "posture", "gain": 1, "joints": ["j3", "j1"], "target_position":
        {"kind": "constant", "value": [2.9, 3.0]}});
    let controller = json!({"robot": "sawyer_dh", "period_s": 0.001, "tasks":
        [{"name": "hold", "axes": ["x"], "law": law}, {"name": "elbow", "law": posture}]});
    let mut state = example("state.json");
    state.as_object_mut().unwrap().remove("wrench");
    let answer = service.call("/v1/step", &json!({"controller": controller, "state": state}));
    let elbow = numbers(&answer["tasks"][1]["requested"]);
    assert!((elbow[0] + 0.1).abs() < 1e-14 && (elbow[1] - 0.1).abs() < 1e-14, "{elbow:?}");
}

#[test]
fn a_profile_has_at_most_a_thousand_points() {
    let service = Service::start();
    let with = |points: usize| {
        let points: Vec<_> = (0..points).map(|i| json!({"time_s": i, "value": 0.01})).collect();
        let mut controller = example("controller.json");
        controller["tasks"][0]["law"]["target_force"] = json!({"kind": "waypoints", "points": points});
        service.post("/v1/controllers", &controller.to_string())
    };
    with(1000).accepted();
    with(1001).assert_refused(422, Some("/tasks/0/law/target_force/points"));
}

/// Runs `stiff_wall` through the impact, with a sensor of this convention and frame.
fn pushed(service: &Service, convention: WrenchConvention, frame: WrenchFrame) -> Vec<Vec<f64>> {
    let mut scenario = Scenario::find("stiff_wall").unwrap();
    scenario.duration_s = 0.45;
    scenario.controller.wrench_convention = convention;
    scenario.controller.wrench_frame = frame;
    let recording =
        run(&scenario, &Client::new(&service.url()), CallMode::Session, |_| ControlFlow::Continue(())).unwrap();
    recording.samples.into_iter().map(|sample| sample.joint_position).collect()
}

#[test]
fn a_simulated_sensor_follows_the_convention_of_its_controller() {
    let service = Service::start();
    let plain = pushed(&service, WrenchConvention::OnEnvironment, WrenchFrame::Base);
    assert_eq!(plain, pushed(&service, WrenchConvention::OnTool, WrenchFrame::Base));
    let wrist = pushed(&service, WrenchConvention::OnTool, WrenchFrame::Tool);
    let difference = plain.iter().flatten().zip(wrist.iter().flatten()).map(|(a, b)| (a - b).abs());
    assert!(difference.fold(0.0, f64::max) < 1e-10);
}

const WIPING: &str = r#"
name = "wiping"
description = "press on a wall with the end of a brush and wipe along it"
duration_s = 2.0
start_joint_position = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]

[[contacts]]
axis = "x"
kind = "spring"
stiffness = 1000.0

[controller]
robot = "sawyer_dh"
period_s = 0.001
tool_offset = { position = [0.0, 0.0, 0.15], orientation = { w = 1.0, x = 0.0, y = 0.0, z = 0.0 } }
null_space_velocity = { kind = "joint_limits", gain = 1.0 }

[[controller.tasks]]
name = "press"
axes = ["x"]
law = { kind = "force", inertia = 15, damping = 150, target_force = { kind = "ramp", start = 0, end = 20, duration_s = 0.5 } }

[[controller.tasks]]
name = "wipe"
axes = ["y", "z", "rx", "ry", "rz"]

[controller.tasks.law]
kind = "pose"
gain = 20

[controller.tasks.law.target_displacement]
kind = "waypoints"
points = [
  { time_s = 0.5, value = 0 },
  { time_s = 1.0, value = [0.05, 0.02, 0, 0, 0] },
  { time_s = 1.5, value = [-0.05, 0, 0, 0, 0.1] },
]
"#;

#[test]
fn a_scenario_file_and_a_request_have_the_same_fields() {
    let service = Service::start();
    let scenario = Scenario::parse(WIPING, "wiping.toml").unwrap();
    let recording =
        run(&scenario, &Client::new(&service.url()), CallMode::Session, |_| ControlFlow::Continue(())).unwrap();
    let last = recording.samples.last().unwrap();
    assert!((last.position_error[1] + 0.05).abs() < 1e-4, "{:?}", last.position_error);
    assert!((last.force[0] - 20.0).abs() < 0.5, "{:?}", last.force);
    let json = serde_json::to_string(&scenario).unwrap();
    assert_eq!(Scenario::parse(&json, "wiping.json").unwrap(), scenario);
}

/// What rounding leaves of a row that no joint moves at a posture is no motion: joints would race to reach it.
#[test]
fn a_row_that_is_zero_but_for_rounding_moves_no_joint() {
    let service = Service::start();
    let right_angle = std::f64::consts::FRAC_PI_2;
    let request = |angle: f64| {
        json!({
            "robot": "ur5e", "joint_position": [0.0, -angle, angle, -angle, -angle, 0.0], "why": true,
            "tasks": [
                {"name": "roll", "link": "upper_arm_link", "axes": ["rx"], "velocity": [0.01]},
                {"name": "hand", "axes": ["x", "y", "z"], "velocity": [0.0, 0.0, 0.0]},
            ],
        })
    };
    let answer = service.call("/v1/resolve", &request(right_angle));
    assert_eq!(numbers(&answer["joint_velocity"]), [0.0; 6], "{answer}");
    assert_eq!(answer["tasks"][0]["rank"], 0);
    assert!(answer["why"].to_string().contains("can move in 0 of 1 directions"), "{answer}");
}
