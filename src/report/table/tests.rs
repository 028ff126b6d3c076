//! The table on runs whose cells are known by hand.

use super::*;
use crate::simulator::recording::Sample;
use crate::wire::{Path, Status};

fn run(method: Method, solver: Solver, velocity: f64) -> Recording {
    let sample = Sample {
        time_s: 0.0,
        joint_position: vec![0.0],
        joint_velocity: vec![velocity],
        position: [0.0; 3],
        position_error: [0.0; 3],
        force: [33.0, 0.0, 0.0],
        target_force: [Some(30.0), None, None],
        wall_distance: None,
        path: Path::ClosedForm,
        status: Status::Optimal,
        kkt_residual: Some(0.0),
        smallest_singular_value: 0.2,
        residual_norms: vec![],
        answered: true,
    };
    Recording {
        scenario: "stiff_wall".to_owned(),
        method,
        solver,
        period_s: 1e-3,
        wall_time_s: 0.5,
        joint_names: vec!["a".to_owned()],
        samples: vec![sample],
    }
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
    let cells = COLUMNS.each_ref().map(|column| (column.cell)(row));
    let forces = ["stiff_wall", "reverse priority", "closed form", "3.00", "–", "3.00 (10.0)", "–", "33.000"];
    assert_eq!(cells[..8], forces);
    assert_eq!(cells[8..], ["–", "closed form 1", "2.00"]);
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
