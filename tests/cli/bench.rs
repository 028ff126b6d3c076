//! `revprio bench` measures everything that it says; what it measures is nobody's promise.

use serde_json::Value;

use crate::program::{Scratch, program, success};

#[test]
fn every_part_is_measured_beside_its_peers_and_written_where_asked() {
    let scratch = Scratch::new("bench");
    let document = scratch.write("performance.md", "# Speed\n<!-- bench:core -->\nold\n<!-- end -->\nkept\n");
    let figures = scratch.argument("figures");
    let printed = success(&["bench", "--quick", "--json", "--fill", &document, "--figures", &figures]);

    let report: Value = serde_json::from_str(&printed).unwrap();
    for (part, least) in [("core", 8), ("http", 14)] {
        let rows = report[part].as_array().unwrap();
        assert!(rows.len() >= least, "{part}: {rows:?}");
        assert!(rows.iter().all(|row| row["ours"]["median"].as_f64().unwrap() > 0.0), "{rows:?}");
        assert!(rows.iter().filter(|row| row["ratio"].is_f64()).count() >= least - 1, "{rows:?}");
    }
    assert_eq!(report["pacing"].as_array().unwrap().len(), 3);
    let growth = report["growth"].as_array().unwrap();
    assert_eq!(growth.len(), 5);
    for name in growth.iter().map(|curves| curves["name"].as_str().unwrap()).chain(["latency"]) {
        let svg = std::fs::read_to_string(scratch.path().join(format!("figures/{name}.svg"))).unwrap();
        assert!(svg.contains("</svg>"), "{name}");
    }
    let filled = std::fs::read_to_string(&document).unwrap();
    assert!(filled.contains("| kinematics") && filled.contains("kept") && !filled.contains("old"), "{filled}");
}

#[test]
fn a_length_that_makes_no_sense_and_unknown_parts_are_refused() {
    for arguments in [["bench", "--seconds", "0"], ["bench", "--seconds", "NaN"], ["bench", "--only", "weather"]] {
        assert_eq!(program(&arguments).output().unwrap().status.code(), Some(2), "{arguments:?}");
    }
}
