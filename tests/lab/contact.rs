//! The law `contact` in the simulator: Sawyer and Panda press on walls whose stiffness the controller does not know.

use std::ops::ControlFlow;

use revprio::service::{AppState, Robots, RunningServer, router};
use revprio_api::Client;
use revprio_lab::simulator::recording::{ContactEvent, ContactWord, Format, Recording, read};
use revprio_lab::simulator::{CallMode, Scenario, run};

/// A tool that presses downwards with 30 N at 3 cm/s; L 5 ms, D 1, T 2 ms, noise 0.2 N behind a filter of 2 ms.
const PRESS: &str = r#"
name = "press"
description = "press on a wall of unknown stiffness"
duration_s = DURATION
start_joint_position = POSTURE
velocity_loop = { lag_s = 0.005, delay_periods = 1 }
substeps = 8

[sensors]
wrench_filter_s = 0.002
force = { noise = 0.2 }

[[contacts]]
axis = "z"
kind = "wall"
offset_m = -0.004
stiffness = STIFFNESS
damping = DAMPING

[controller]
robot = "ROBOT"
period_s = 0.002
drive = { lag_s = 0.005, delay_periods = 1 }

[[controller.tasks]]
name = "press"
axes = ["z"]
law = { kind = "contact", approach_speed = 0.03, target_force = { kind = "constant", value = -30 } }

[[controller.tasks]]
name = "hold"
axes = ["x", "y", "rx", "ry", "rz"]
law = { kind = "pose", gain = 3 }
"#;

/// An arm and a posture.
const SAWYER: (&str, &str) = ("sawyer_dh", "[2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]");
const PANDA: (&str, &str) = ("panda", "[0, -0.4, 0, -2.2, 0, 1.8, 0.8]");

/// F_d, N.
const TARGET: f64 = 30.0;

fn press(robot: (&str, &str), stiffness: f64, change: impl Fn(String) -> String) -> Recording {
    let duration = 0.5 + 1.5 * TARGET / (stiffness * 0.03) + 0.8;
    let damping = 0.04 * (5.0 * stiffness).sqrt();
    let text = PRESS.replace("ROBOT", robot.0).replace("POSTURE", robot.1);
    let text = text.replace("STIFFNESS", &format!("{stiffness:?}")).replace("DAMPING", &format!("{damping:?}"));
    let text = change(text.replace("DURATION", &format!("{duration:?}")));
    let scenario = Scenario::parse(&text, "press.toml").unwrap();
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    run(&scenario, &Client::new(&server.url()), CallMode::Session, |_| ControlFlow::Continue(())).unwrap()
}

/// The forces with which the tool presses, N.
fn forces(run: &Recording) -> Vec<f64> {
    run.samples.iter().map(|sample| -sample.force[2]).collect()
}

fn peak(forces: &[f64]) -> f64 {
    forces.iter().copied().fold(0.0, f64::max)
}

/// Time from the first touch after which the force stays within 5 %, s.
fn settling(forces: &[f64]) -> f64 {
    let touch = forces.iter().position(|force| *force > 0.0).unwrap();
    let outside = forces.iter().rposition(|force| (force - TARGET).abs() > 0.05 * TARGET).unwrap();
    0.002 * outside.saturating_sub(touch) as f64
}

#[test]
fn sawyer_and_panda_press_on_walls_of_unknown_stiffness() {
    for robot in [SAWYER, PANDA] {
        // N/m, and the largest peak, N: at 3 cm/s no controller stays below the last two.
        for (stiffness, allowed) in [(1e3, 36.0), (1e4, 36.0), (1e5, 45.0), (1e6, 450.0)] {
            let found = forces(&press(robot, stiffness, |text| text));
            let end = &found[found.len() - 200..];
            let error = end.iter().sum::<f64>() / 200.0 - TARGET;
            assert!(error.abs() < 0.1 && peak(&found) < allowed, "{robot:?} {stiffness}: {error} {}", peak(&found));
            assert!(
                settling(&found) < 0.5 + TARGET / (stiffness * 0.03),
                "{robot:?} {stiffness}: {}",
                settling(&found)
            );
        }
    }
}

#[test]
fn the_default_approach_speed_keeps_the_peak_on_the_stiffest_wall() {
    for robot in [SAWYER, PANDA] {
        let found = forces(&press(robot, 1e6, |text| {
            text.replace("approach_speed = 0.03, ", "").replace("offset_m = -0.004", "offset_m = -0.002")
        }));
        assert!(peak(&found) > 20.0 && peak(&found) < 1.2 * TARGET, "{robot:?}: {}", peak(&found));
    }
}

#[test]
fn a_sensor_of_the_force_on_the_tool_presses_too() {
    for robot in [SAWYER, PANDA] {
        let found = press(robot, 1e4, |text| {
            text.replace("period_s = 0.002", "period_s = 0.002\nwrench_convention = \"on_tool\"")
        });
        assert!((forces(&found).last().unwrap() - TARGET).abs() < 1.5, "{robot:?}");
    }
}

#[test]
fn the_contact_stands_in_every_format_of_a_recording() {
    let run = press(SAWYER, 1e4, |text| text);
    let events = |event| run.samples.iter().filter(|sample| sample.contacts.event[0] == event).count();
    assert_eq!((events(ContactEvent::Contact), events(ContactEvent::Loss), events(ContactEvent::Pull)), (1, 0, 0));
    let (first, last) = (&run.samples[0].contacts, &run.samples.last().unwrap().contacts);
    assert_eq!((first.state[0], first.stiffness[0]), (ContactWord::Approach, None));
    assert_eq!((last.state[0], last.target_force[0]), (ContactWord::Contact, TARGET));
    assert!((last.force[0] - TARGET).abs() < 1.5 && (last.stiffness[0].unwrap() / 1e4 - 1.0).abs() < 0.1, "{last:?}");
    for format in Format::ALL {
        let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("contact.{}", format.ending()));
        format.write_file(&run, false, &file).unwrap();
        let back = read(&file).unwrap();
        assert_eq!(back.samples, run.samples, "{format:?}");
        let bytes = std::fs::read(&file).unwrap();
        let has = |word: &[u8]| bytes.windows(word.len()).any(|part| part == word);
        match format {
            Format::Csv => assert!(has(b"contact_state_1,contact_event_1,contact_force_1")),
            Format::Mcap => assert!(has(b"/contact") && has(b"revprio.Contacts")),
            Format::JsonLines | Format::Parquet => {}
        }
    }
}

/// The sensor has a bias of 3 N, a tool of 0.5 kg and a place of its own; the controller knows them.
#[test]
fn a_wrist_sensor_with_bias_and_payload_presses_with_the_right_force() {
    let sensor = r#"wrench_convention = "on_tool"
wrench_frame = "tool"
tool_offset = { position = [0, 0, 0.1], orientation = { w = 1, x = 0, y = 0, z = 0 } }
wrench_sensor = { pose = { position = [0, 0, 0.02], orientation = { w = 0.8, x = 0, y = 0, z = 0.6 } }, filter_time_s = 0.002, bias = { force = [2, -1, 2], torque = [0.1, 0, 0] }, payload = { mass_kg = 0.5, center_of_mass = [0, 0.01, 0.06] } }
"#;
    let run = press(SAWYER, 1e4, |text| text.replace("[controller]\n", &format!("[controller]\n{sensor}")));
    let sensed = run.samples[0].sensed.as_ref().unwrap();
    assert!(sensed.force.iter().map(|f| f * f).sum::<f64>().sqrt() > 2.0, "{sensed:?}");
    let forces = forces(&run);
    let last = &forces[forces.len() - 200..];
    let mean = last.iter().sum::<f64>() / 200.0;
    assert!((mean - TARGET).abs() < 0.1 && peak(&forces) < 1.2 * TARGET, "{mean} {}", peak(&forces));
}
