//! `revprio scenarios`

use crate::program::success;

#[test]
fn every_scenario_of_the_repository_is_listed() {
    let listed = success(&["scenarios"]);
    let mut names: Vec<&str> = listed.lines().map(|line| line.split_whitespace().next().unwrap()).collect();
    names.sort_unstable();
    let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/scenarios")).unwrap();
    let mut expected: Vec<String> =
        files.map(|file| file.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    expected.sort();
    assert_eq!(names, expected);
    assert!(listed.lines().all(|line| line.len() > 40 && line.ends_with(')')), "{listed}");
}
