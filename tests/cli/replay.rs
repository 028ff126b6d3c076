//! `revprio replay`.

use crate::program::{Scratch, program, success};
use crate::serve::Server;
use crate::simulate::short;

const RUN: &str = "stiff_wall-reverse_priority-auto";

/// Records a short run in all formats.
fn recorded(name: &str, more: &[&str]) -> Scratch {
    let scratch = Scratch::new(name);
    let file = scratch.write("mine.toml", &short("stiff_wall", "duration_s = 0.4"));
    let (out, formats) = (scratch.argument("out"), ["--traces", "csv,jsonl,parquet,mcap"]);
    success(&[&["simulate", &file, "--out", &out][..], &formats, more].concat());
    scratch
}

#[test]
fn replay_of_every_format_gives_the_same_answers() {
    let (scratch, server) = (recorded("replay", &[]), Server::start());
    for ending in ["csv", "jsonl", "parquet", "mcap"] {
        let file = scratch.argument(&format!("out/{RUN}.{ending}"));
        let said = success(&["replay", &file]);
        assert!(said.starts_with("400 states sent, 400 answers compared, 0 differ\n"), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    let file = scratch.argument(&format!("out/{RUN}.parquet"));
    let said = success(&["replay", &file, "--server", &server.url, "--stateless"]);
    assert!(said.contains("400 answers compared, 0 differ"), "{said}");
}

#[test]
fn replay_of_lost_and_late_answers_gives_the_same_commands() {
    for mode in [&[][..], &["--stateless"]] {
        let scratch = Scratch::new("replay_faults");
        // It holds the outage, in which the arm brakes, and the way back to the answers.
        let text = short("lossy_line", "duration_s = 2.8");
        let (file, out) = (scratch.write("mine.toml", &text), scratch.argument("out"));
        success(&[&["simulate", &file, "--out", &out, "--in-process", "--traces", "csv"][..], mode].concat());
        let table = scratch.argument("out/lossy_line-reverse_priority-auto.csv");
        let said = success(&[&["replay", &table][..], mode].concat());
        assert!(said.contains(", 0 differ"), "{mode:?} {said}");
    }
}

#[test]
fn replay_reports_a_different_answer() {
    let scratch = recorded("replay_differs", &[]);
    let path = scratch.path().join(format!("out/{RUN}.csv"));
    let mut rows: Vec<String> = std::fs::read_to_string(&path).unwrap().lines().map(str::to_owned).collect();
    let column = rows[0].split(',').position(|name| name.starts_with("velocity_")).unwrap();
    let mut cells: Vec<String> = rows[101].split(',').map(str::to_owned).collect();
    cells[column] = (cells[column].parse::<f64>().unwrap() + 1e-6).to_string();
    rows[101] = cells.join(",");
    std::fs::write(&path, rows.join("\n") + "\n").unwrap();
    let file = path.to_str().unwrap();
    let output = program(&["replay", file]).output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("400 answers compared, 1 differ"), "{said}");
    assert!(said.contains("first difference: velocity_") && said.contains("in period 100"), "{said}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("1 answers differ from the recording"));
    assert!(success(&["replay", file, "--tolerance", "1e-5"]).contains("worst difference: velocity_"));
}

#[test]
fn tolerances_that_are_no_numbers_or_negative_are_refused() {
    for tolerance in ["nan", "-1", "inf", "-0.1", "much"] {
        let output = program(&["replay", "run.csv", "--tolerance", tolerance]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{tolerance}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("give a finite number from 0 on"), "{tolerance}");
    }
}

#[test]
fn a_recording_without_answers_does_not_pass() {
    let scratch = recorded("replay_empty", &[]);
    let path = scratch.path().join(format!("out/{RUN}.csv"));
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.lines().next().unwrap().to_owned() + "\n").unwrap();
    let refused = || {
        let output = program(&["replay", path.to_str().unwrap()]).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(refused().contains("it has 0 periods"), "{}", refused());
    let description = path.with_extension("recording.json");
    let mut run: serde_json::Value = serde_json::from_slice(&std::fs::read(&description).unwrap()).unwrap();
    run.as_object_mut().unwrap().remove("periods").unwrap();
    std::fs::write(&description, run.to_string()).unwrap();
    assert!(refused().contains("nothing is compared"), "{}", refused());
}

#[test]
fn error_names_a_file_that_is_not_a_recording() {
    let scratch = Scratch::new("replay_refused");
    let output = program(&["replay", &scratch.write("run.mcap", "nothing")]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("run.mcap: "));
}
