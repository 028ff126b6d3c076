//! `revprio payload`

use crate::program::{failure, success, success_with_input};

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
    // Without --on-tool the sign is the other one.
    refused(&table(), "the other sign");
    refused(&table().lines().take(4).collect::<Vec<_>>().join("\n"), "3 readings; give at least six");
}
