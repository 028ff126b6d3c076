//! Tables of runs with known cells.

use super::*;
use crate::simulator::recording::{AtLimit, Sample, Timing};

fn run(method: Method, solver: Solver, velocity: f64) -> Run {
    let sample = Sample {
        joint_position: vec![0.0],
        joint_velocity: vec![velocity],
        force: [33.0, 0.0, 0.0],
        target_force: [Some(30.0), None, None],
        ..Sample::at_rest()
    };
    Run::of(Recording {
        method,
        solver,
        joint_names: vec!["a".to_owned()],
        samples: vec![sample],
        ..Recording::empty()
    })
}

#[test]
fn run_is_compared_with_the_closed_form_of_the_same_method() {
    let recordings = [
        run(Method::ReversePriority, Solver::Qp, 0.75),
        run(Method::DampedLeastSquares, Solver::ClosedForm, 9.0),
        run(Method::ReversePriority, Solver::ClosedForm, 0.5),
        run(Method::StrictReversePriority, Solver::Auto, 0.5),
    ];
    let differences: Vec<_> = rows(&recordings).iter().map(|row| row.largest_difference).collect();
    assert_eq!(differences, [Some(0.25), None, None, None]);
}

#[test]
fn cells_show_the_metrics_of_the_row() {
    let row = &rows(&[run(Method::ReversePriority, Solver::ClosedForm, 0.0)])[0];
    let cell = |heading: &str| {
        let quantity = QUANTITIES.iter().find(|quantity| quantity.heading == heading).unwrap();
        (quantity.cell)(row)
    };
    let cells =
        ["scenario", "method", "solver", "RMSE F_x", "RMSE F_y", "overshoot F", "settling", "final F"].map(cell);
    assert_eq!(cells, ["stiff_wall", "reverse priority", "closed form", "3.00", "–", "3.00 (10.0)", "–", "33.000"]);
    assert_eq!(
        ["vs closed form", "solved by", "status", "calls"].map(cell),
        ["–", "closed form 1", "optimal 1", "2.00"]
    );
    // The path of `auto` without an active limit does not read as another solver.
    let row = &rows(&[run(Method::ReversePriority, Solver::Auto, 0.0)])[0];
    assert_eq!(solved_by(row), "no active limit 1");
    assert_eq!(["steady error F", "peak F", "limit excess"].map(cell), ["3.0", "33.00", "–"]);
}

/// The same run with this number of requests, each with this round trip (µs).
fn over_http(run: Run, count: u64, round_trip_us: f64) -> Run {
    let timings = vec![Timing { round_trip_us, elapsed_us: 1.0 }];
    let requests = Some(Requests::new(count, &timings));
    Run { recording: Recording { timings, ..run.recording }, requests, ..run }
}

/// Returns the words of each line.
fn words_of(text: &str) -> Vec<Vec<&str>> {
    text.lines().map(|line| line.split_whitespace().collect()).collect()
}

#[test]
fn summary_has_one_line_per_method_with_the_largest_difference_and_all_requests_of_its_solvers() {
    let runs = [
        over_http(run(Method::ReversePriority, Solver::ClosedForm, 0.5), 20_002, 120.4),
        over_http(run(Method::ReversePriority, Solver::Qp, 0.75), 20_002, 1210.0),
        over_http(run(Method::ReversePriority, Solver::Auto, 0.5), 20_002, 99.0),
        run(Method::DampedLeastSquares, Solver::ClosedForm, 9.0),
    ];
    let text = summary::text(&runs);
    let lines = words_of(&text);
    assert_eq!(lines.len(), 5);
    assert_eq!(lines[2], ["stiff_wall"]);
    let reverse = ["reverse", "priority", "3.00", "33.00", "–", "33.000", "0.25", "60006", "120", "1210"];
    assert_eq!(lines[3], reverse);
    assert_eq!(lines[4][3..], ["3.00", "33.00", "–", "33.000", "–", "–", "–", "–"]);
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
}

#[test]
fn summary_compares_solvers_without_the_closed_form_and_says_how_long_limits_act() {
    let at_limit = |solver, velocity, limits: [AtLimit; 2]| {
        let mut run = run(Method::ReversePriority, solver, velocity);
        let sample = |limit| Sample { limits: vec![limit], ..run.recording.samples[0].clone() };
        run.recording.samples = limits.map(sample).to_vec();
        run
    };
    let runs = [
        at_limit(Solver::Qp, 0.5, [AtLimit::Upper, AtLimit::Free]),
        at_limit(Solver::Auto, 0.75, [AtLimit::Upper, AtLimit::Lower]),
    ];
    let text = summary::text(&runs);
    assert_eq!(text.lines().nth(2), Some("stiff_wall: a limit acts in 50 % of the periods"), "{text}");
    assert_eq!(words_of(&text)[3][6], "0.25");
}

#[test]
fn requests_are_on_the_page_if_there_were_any() {
    let cells = |run: Run| -> Vec<String> {
        let lines = side_by_side::lines(&rows(&[run]));
        let headings = ["requests", "round trip, median / 99th perc."];
        let of_http = lines.iter().filter(|line| headings.contains(&line.heading.as_str()));
        of_http.flat_map(|line| line.cells.clone()).collect()
    };
    let run = run(Method::ReversePriority, Solver::Qp, 0.0);
    assert!(cells(run.clone()).is_empty());
    assert_eq!(cells(over_http(run, 3, 99.6)), ["3", "100 / 100"]);
}

#[test]
fn side_by_side_table_lists_only_quantities_that_a_run_has() {
    let runs = [Method::ReversePriority, Method::Pseudoinverse].map(|method| run(method, Solver::Qp, 0.0));
    let rows = rows(&runs);
    let headings: Vec<String> = side_by_side::lines(&rows).into_iter().map(|line| line.heading).collect();
    for present in ["RMSE F_x", "final F_x", "limit excess", "calls"] {
        assert!(headings.contains(&present.to_owned()), "{headings:?}");
    }
    for missing in ["RMSE F_y", "settling", "vs closed form", "scenario"] {
        assert!(!headings.contains(&missing.to_owned()), "{headings:?}");
    }
    let text = side_by_side::text(&rows);
    assert!(text.starts_with("stiff_wall\n  method "), "{text}");
    let line = text.lines().find(|line| line.contains("peak F_x")).unwrap();
    assert_eq!(line.split_whitespace().collect::<Vec<_>>(), ["peak", "F_x", "N", "33.00", "33.00"]);
}

#[test]
fn markdown_has_one_column_per_run_and_no_machine_times() {
    let markdown = side_by_side::markdown(&rows(&[run(Method::ReversePriority, Solver::Qp, 0.0)]));
    assert!(markdown.starts_with("|  | reverse priority, qp |\n| :-- | --: |\n"), "{markdown}");
    assert!(markdown.contains("| RMSE F_x (N) | 3.00 |"), "{markdown}");
    assert!(!markdown.contains("calls"), "{markdown}");
}

#[test]
fn runs_that_do_not_fit_follow_in_another_table() {
    let runs: Vec<Run> = (0..7).map(|_| run(Method::ReversePriority, Solver::Qp, 0.0)).collect();
    assert_eq!(side_by_side::text(&rows(&runs)).matches("method").count(), 2);
}

#[test]
fn names_are_aligned_left_and_numbers_right() {
    let text =
        text(&rows(&[run(Method::Pseudoinverse, Solver::Qp, 0.0), run(Method::ReversePriority, Solver::Qp, 0.0)]));
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines.len(), 4);
    let column = lines[0].find("method").unwrap();
    assert!(lines[2][column..].starts_with("pseudoinverse ") && lines[3][column..].starts_with("reverse priority "));
    let length = lines[0].chars().count();
    assert!(lines.iter().all(|line| line.chars().count() == length));
}
