//! The table on runs whose cells are known by hand.

use super::*;
use crate::simulator::recording::Sample;

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
fn a_run_is_compared_with_the_closed_form_of_its_own_method() {
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
fn the_cells_of_a_row_are_its_metrics() {
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
    assert_eq!(["steady error F", "peak F", "limits broken by"].map(cell), ["3.0", "33.00", "–"]);
}

#[test]
fn side_by_side_a_row_is_a_quantity_and_only_of_runs_that_have_it() {
    let runs = [Method::ReversePriority, Method::Pseudoinverse].map(|method| run(method, Solver::Qp, 0.0));
    let rows = rows(&runs);
    let headings: Vec<String> = side_by_side::lines(&rows).into_iter().map(|line| line.heading).collect();
    for there in ["RMSE F_x", "final F_x", "limits broken by", "calls"] {
        assert!(headings.contains(&there.to_owned()), "{headings:?}");
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
fn markdown_has_a_column_per_run_and_no_time_of_the_machine() {
    let markdown = side_by_side::markdown(&rows(&[run(Method::ReversePriority, Solver::Qp, 0.0)]));
    assert!(markdown.starts_with("|  | reverse priority, qp |\n| :-- | --: |\n"), "{markdown}");
    assert!(markdown.contains("| RMSE F_x (N) | 3.00 |"), "{markdown}");
    assert!(!markdown.contains("calls"), "{markdown}");
}

#[test]
fn more_runs_than_fit_beside_each_other_follow_below() {
    let runs: Vec<Run> = (0..7).map(|_| run(Method::ReversePriority, Solver::Qp, 0.0)).collect();
    assert_eq!(side_by_side::text(&rows(&runs)).matches("method").count(), 2);
}

#[test]
fn the_text_is_aligned_names_left_and_numbers_right() {
    let text =
        text(&rows(&[run(Method::Pseudoinverse, Solver::Qp, 0.0), run(Method::ReversePriority, Solver::Qp, 0.0)]));
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines.len(), 4);
    let column = lines[0].find("method").unwrap();
    assert!(lines[2][column..].starts_with("pseudoinverse ") && lines[3][column..].starts_with("reverse priority "));
    let length = lines[0].chars().count();
    assert!(lines.iter().all(|line| line.chars().count() == length));
}
