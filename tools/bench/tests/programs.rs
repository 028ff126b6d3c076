//! The benchmark program measures every part. The values are not checked.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn program(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_revprio-bench")).args(arguments).output().unwrap()
}

fn success(arguments: &[&str]) -> String {
    let output = program(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_part_is_measured_with_its_peers_and_written() {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let argument = |name: &str| scratch.join(name).to_str().unwrap().to_owned();
    let (document, figures) = (argument("performance.md"), argument("figures"));
    std::fs::write(&document, "# Speed\n<!-- bench:core -->\nold\n<!-- end -->\nkept\n").unwrap();
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
        let svg = std::fs::read_to_string(scratch.join(format!("figures/{name}.svg"))).unwrap();
        assert!(svg.contains("</svg>"), "{name}");
    }
    let filled = std::fs::read_to_string(&document).unwrap();
    assert!(filled.contains("| kinematics") && filled.contains("kept") && !filled.contains("old"), "{filled}");
}

#[test]
fn invalid_durations_and_unknown_parts_are_refused() {
    for arguments in [["bench", "--seconds", "0"], ["bench", "--seconds", "NaN"], ["bench", "--only", "weather"]] {
        assert_eq!(program(&arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn load_test_passes_with_bounded_memory() {
    let table = success(&["load", "--seconds", "1", "--clients", "10", "--times", "1,10", "--slow", "100"]);
    for row in ["1x ", "10x ", "1x, 100 slow"] {
        let line = table.lines().find(|line| line.starts_with(row)).unwrap_or_else(|| panic!("{row}: {table}"));
        let accepted: f64 = line.split_whitespace().rev().nth(5).unwrap().parse().unwrap();
        assert!(accepted > 0.0, "{line}");
    }
}
