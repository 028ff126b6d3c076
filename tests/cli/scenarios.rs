//! `revprio scenarios`

use crate::program::{Scratch, program, success};

#[test]
fn every_scenario_of_the_repository_is_listed() {
    let listed = success(&["scenarios"]);
    let (described, heads): (Vec<&str>, Vec<&str>) = listed.lines().partition(|line| line.starts_with(' '));
    let mut names: Vec<&str> = heads.iter().map(|line| line.split_whitespace().next().unwrap()).collect();
    names.sort_unstable();
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/scenarios")).unwrap();
    let mut expected: Vec<String> =
        files.map(|file| file.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    expected.sort();
    assert_eq!(names, expected);
    assert!(heads.iter().all(|line| line.ends_with(')')) && described.len() >= heads.len(), "{listed}");
    assert!(listed.lines().all(|line| line.chars().count() <= 100), "{listed}");
}

#[test]
fn the_shown_file_of_a_scenario_is_that_of_the_repository_and_runs() {
    let shown = success(&["scenarios", "show", "press"]);
    assert_eq!(shown, include_str!("../../fixtures/scenarios/press.toml"));
    let scratch = Scratch::new("scenarios_show");
    let file = scratch.write("mine.toml", &shown.replace("duration_s = 3.0", "duration_s = 0.01"));
    success(&["simulate", &file, "--in-process", "--out", &scratch.argument("out")]);
}

#[test]
fn a_mistyped_scenario_is_refused_with_the_nearest_name() {
    let output = program(&["scenarios", "show", "pres"]).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(message.contains("a similar value exists: 'press'"), "{message}");
}
