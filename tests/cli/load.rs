//! `revprio load`, in small: what is right under load, not how fast.

use crate::program::success;

#[test]
fn under_any_load_answers_are_right_and_memory_is_bounded() {
    let table = success(&["load", "--seconds", "1", "--clients", "10", "--times", "1,10", "--slow", "100"]);
    for row in ["1x ", "10x ", "1x, 100 slow"] {
        let line = table.lines().find(|line| line.starts_with(row)).unwrap_or_else(|| panic!("{row}: {table}"));
        let accepted: f64 = line.split_whitespace().rev().nth(5).unwrap().parse().unwrap();
        assert!(accepted > 0.0, "{line}");
    }
}
