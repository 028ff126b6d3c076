//! `revprio payload`

use revprio_robot::built_in;
use revprio_robot::kinematics::Configuration;

use crate::program::{Scratch, failure, program, success, success_with_input};

const EXAMPLE: &str = "api/examples/payload.json";
const HEADER: &str = "force_x,force_y,force_z,torque_x,torque_y,torque_z";

/// A table of the example.
fn table() -> String {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/api/examples/payload.json")).unwrap();
    let request: serde_json::Value = serde_json::from_str(&text).unwrap();
    let mut table = format!("gravity_x, gravity_y, gravity_z, {HEADER}\n");
    for reading in request["readings"].as_array().unwrap() {
        let parts = [&reading["gravity"], &reading["wrench"]["force"], &reading["wrench"]["torque"]];
        let cells = parts.iter().flat_map(|part| part.as_array().unwrap()).map(ToString::to_string);
        table += &(cells.collect::<Vec<_>>().join(",") + "\n");
    }
    table
}

#[test]
fn a_request_and_a_table_give_the_same_payload() {
    let found = success(&["payload", EXAMPLE]);
    for part in ["mass              0.49", "centre of mass    1.", "sign and axes     verified", "6 readings"] {
        assert!(found.contains(part), "{part} is not in {found}");
    }
    assert_eq!(success_with_input(&["payload", "-", "--on-tool"], &table()), found);
    // As spreadsheets write it: a mark of the byte order, names in quotes, empty lines at the end.
    let quoted = table().replace(", ", ",").replace("force_x", "\"force_x\"").replace('\n', "\r\n");
    let table = format!("\u{feff}{quoted}\r\n\r\n");
    assert_eq!(success_with_input(&["payload", "-", "--on-tool"], &table), found);
    let json: serde_json::Value = serde_json::from_str(&success(&["payload", EXAMPLE, "--json"])).unwrap();
    assert_eq!(json["axes_verified"], true);
}

#[test]
fn poor_readings_and_broken_tables_are_refused_with_the_place() {
    let refused = |input: &str, part: &str| {
        let path = std::env::temp_dir().join(format!("revprio-payload-{}.csv", std::process::id()));
        std::fs::write(&path, input).unwrap();
        let error = failure(&["payload", path.to_str().unwrap()]);
        std::fs::remove_file(&path).unwrap();
        assert!(error.contains(part), "{part} is not in {error}");
    };
    refused("", "the file is empty");
    refused("force_x,force_y\n1,2", "`force_z` is missing");
    refused(&format!("{HEADER},gravity_x\n"), "give all of gravity_x");
    refused(&format!("{HEADER},gravity_x,gravity_y,gravity_z,j1\n"), "`j1` is too much");
    refused(&format!("{HEADER},force_x\n"), "`force_x` is there twice");
    refused(&HEADER.replace(',', ";"), "separated by commas");
    refused(&format!("{HEADER}\n1,2,3"), "line 2: 3 cells for 6");
    refused(&format!("{HEADER}\n1,2,3,4,5,six"), "`six` in `torque_z` is not a number");
    refused(&format!("{HEADER}\n1,2,3,4,nan,6"), "`nan` in `torque_y` is not a number");
    refused(&format!("{HEADER},j1\n1,2,3,4,5,6,0\n"), "`joint_position` needs the name of a `robot`");
    let no_noise = failure(&["payload", EXAMPLE, "--torque-noise-nm=0"]);
    assert!(no_noise.contains("/torque_noise_nm") && no_noise.contains("positive"), "{no_noise}");
    // Without --on-tool the sign is the other one.
    refused(&table(), "the other sign");
    refused(&table().lines().take(4).collect::<Vec<_>>().join("\n"), "3 readings; give at least six");
}

#[test]
fn mounting_and_place_of_a_sensor_are_stated_beside_a_table() {
    let robot = built_in().iter().find(|robot| robot.name() == "panda").unwrap();
    let names: Vec<_> = robot.moving_joints().iter().map(|joint| joint.name.as_str()).collect();
    let mut table = format!("{HEADER},{}\n", names.join(","));
    for k in 0..8 {
        let q: Vec<f64> = (0..7)
            .map(|j| [0.0, 0.0, 0.0, -1.5, 0.0, 1.5, 0.0][j] + f64::sin(f64::from(k) * (1.3 + j as f64)))
            .collect();
        // The arm hangs on a wall: gravity is along -y. The sensor is turned by half a turn about x.
        let rotation = Configuration::new(robot, &q).unwrap().tool_pose().rotation;
        let gravity = [1.0, -1.0, -1.0].iter().enumerate().map(|(axis, sign)| -9.81 * sign * rotation[(1, axis)]);
        let [x, y, z] = <[f64; 3]>::try_from(gravity.map(|entry| 0.5 * entry).collect::<Vec<_>>()).unwrap();
        let cells = [x, y, z, -0.05 * y, 0.05 * x, 0.0].iter().chain(&q).map(ToString::to_string).collect::<Vec<_>>();
        table += &(cells.join(",") + "\n");
    }
    let scratch = Scratch::new("payload-place");
    let file = &scratch.write("readings.csv", &table);
    let pose = r#"{"position": [0, 0, 0], "orientation": {"w": 0, "x": 1, "y": 0, "z": 0}}"#;
    let [common, pose, gravity] =
        [&["payload", file, "--robot", "panda", "--on-tool"][..], &["--pose", pose], &["--gravity", "0,-9.81,0"]];
    let found = success(&[common, pose, gravity].concat());
    for part in ["mass              0.5000 kg", "centre of mass    0.0, 0.0, 50.0 mm", "verified"] {
        assert!(found.contains(part), "{part} is not in {found}");
    }
    // Without one of them the readings fit no payload.
    failure(&[common, pose].concat());
    failure(&[common, gravity].concat());
    let unknown = failure(&[common, pose, gravity, &["--tip", "nowhere"]].concat());
    assert!(unknown.contains("/tip") && unknown.contains("nowhere"), "{unknown}");
    let meaningless = failure(&["payload", EXAMPLE, "--gravity", "0,-9.81,0"]);
    assert!(meaningless.contains("--gravity") && meaningless.contains("with postures"), "{meaningless}");
    for (option, value, part) in [
        ("--gravity", "0,-9.81", "three numbers"),
        ("--gravity", "0,down,0", "three numbers"),
        ("--gravity", "0,1e999,0", "three numbers"),
        ("--pose", "0,0,0.1", "orientation"),
        ("--force-noise-n", "nan", "finite number"),
        ("--torque-noise-nm", "inf", "finite number"),
    ] {
        let output = program(&[common, &[option, value]].concat()).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && message.contains(option) && message.contains(part), "{message}");
    }
}
