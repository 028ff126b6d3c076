//! `revprio scenarios`

use crate::program::success;

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
