//! Examples by other authors, and the answers of another hierarchical solver.

use revprio_core::resolution::Status;
use serde::Deserialize;

use crate::hierarchy::{Hierarchy, Row, length};

const NONE: f64 = f64::INFINITY;

fn row(coefficients: &[f64], lower: f64, upper: f64) -> Row {
    Row { coefficients: coefficients.to_vec(), lower, upper }
}

/// Returns a hierarchy without limits.
fn unlimited(reference: &[f64], levels: Vec<Vec<Row>>) -> Hierarchy {
    let n = reference.len();
    Hierarchy { lower: vec![-NONE; n], upper: vec![NONE; n], reference: reference.to_vec(), levels }
}

fn assert_answer(hierarchy: &Hierarchy, expected: &[f64], tolerance: f64) {
    let answer = hierarchy.solve(&[]);
    let error = answer.joint_velocity.iter().zip(expected).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    assert!(error <= tolerance, "off by {error:e}: {answer:?} instead of {expected:?}");
    assert_eq!(answer.solver.status, Status::Optimal);
}

/// The four tasks of DAQP's tests (github.com/darnstrom/daqp, interfaces/daqp-eigen/tests): −1 ≤ x ≤ 1 for all joints,
/// then x₁ + x₂ + x₃ ≤ 1, then x₁ − x₂ = 0.5, then 10 ≤ 3 x₁ + x₂ − x₃ ≤ 20.
fn daqp_tasks() -> [Vec<Row>; 4] {
    let unit =
        |j: usize| Row { coefficients: (0..3).map(|i| f64::from(u8::from(i == j))).collect(), lower: -1.0, upper: 1.0 };
    [
        (0..3).map(unit).collect(),
        vec![row(&[1.0, 1.0, 1.0], -NONE, 1.0)],
        vec![row(&[1.0, -1.0, 0.0], 0.5, 0.5)],
        vec![row(&[3.0, 1.0, -1.0], 10.0, 20.0)],
    ]
}

#[test]
fn four_tasks_of_daqp() {
    let [bounds, sum, difference, last] = daqp_tasks();
    let expected = [1.0, 0.5, -1.0];
    assert_answer(&unlimited(&[0.0; 3], vec![bounds, sum.clone(), difference.clone(), last.clone()]), &expected, 1e-12);
    let limited =
        Hierarchy { lower: vec![-1.0; 3], upper: vec![1.0; 3], ..unlimited(&[0.0; 3], vec![sum, difference, last]) };
    assert_answer(&limited, &expected, 1e-12);
}

#[test]
fn two_tasks_of_daqp() {
    let [bounds, _, _, last] = daqp_tasks();
    assert_answer(&unlimited(&[0.0; 3], vec![bounds, last]), &[1.0, 1.0, -1.0], 1e-12);
}

#[test]
fn four_tasks_of_daqp_without_the_third_joint() {
    let without_third = |row: Row| Row { coefficients: row.coefficients[..2].to_vec(), ..row };
    let [mut bounds, sum, difference, last] = daqp_tasks();
    bounds.pop();
    let levels = [bounds, sum, difference, last].map(|level| level.into_iter().map(without_third).collect());
    assert_answer(&unlimited(&[0.0; 2], levels.to_vec()), &[0.75, 0.25], 1e-12);
}

/// The last two levels cannot be kept: they have slack.
#[test]
fn four_tasks_of_daqp_in_another_order() {
    let [bounds, sum, difference, last] = daqp_tasks();
    assert_answer(&unlimited(&[0.0; 3], vec![sum, last, bounds, difference]), &[2.25, 1.0, -2.25], 1e-12);
}

/// Escande, Mansard and Wieber, "Hierarchical quadratic programming: Fast online humanoid-robot motion generation"
/// (2014), Fig. 2; the numbers are those of github.com/nmansard/hqp, unittests/example_fig2.m. There, the problem is
/// shifted by its initial point, and a third level leads back to the origin.
#[test]
fn figure_2_of_escande_mansard_and_wieber() {
    let start = [-0.5, 1.5];
    let shifted = |coefficients: [f64; 2], upper: f64| {
        let moved: f64 = coefficients.iter().zip(start).map(|(a, x)| a * x).sum();
        row(&coefficients, -NONE, upper - moved)
    };
    let first = vec![shifted([0.1, -1.0], -0.55), shifted([1.0, -1.0], 1.5)];
    let second = vec![shifted([-1.0, -1.0], -2.0), shifted([-1.0, 0.0], -2.5)];
    let third = vec![row(&[1.0, 0.0], 0.5, 0.5), row(&[0.0, 1.0], -1.5, -1.5)];
    let expected = [3.0, -0.5];
    assert_answer(&unlimited(&[0.0; 2], vec![first.clone(), second.clone(), third]), &expected, 1e-12);
    // The last level of this solver, the distance from the reference, replaces the third one.
    assert_answer(&unlimited(&[0.5, -1.5], vec![first, second]), &expected, 1e-12);
}

/// A problem of `fixtures/golden/hierarchies.json`; no bound is infinite.
#[derive(Deserialize)]
struct Case {
    lower: Vec<f64>,
    upper: Vec<f64>,
    reference: Vec<f64>,
    levels: Vec<Vec<CaseRow>>,
    /// The answer of DAQP.
    answer: Vec<f64>,
}

#[derive(Deserialize)]
struct CaseRow {
    row: Vec<f64>,
    lower: Option<f64>,
    upper: Option<f64>,
}

impl Case {
    /// Returns the hierarchy. DAQP divides each row by its length, which changes the weights of slacks.
    fn hierarchy(&self) -> Hierarchy {
        let unit = |case: &CaseRow| Row {
            coefficients: case.row.iter().map(|a| a / length(&case.row)).collect(),
            lower: case.lower.unwrap_or(-NONE),
            upper: case.upper.unwrap_or(NONE),
        };
        Hierarchy {
            lower: self.lower.clone(),
            upper: self.upper.clone(),
            reference: self.reference.clone(),
            levels: self.levels.iter().map(|level| level.iter().map(unit).collect()).collect(),
        }
    }
}

#[test]
fn answers_are_those_of_daqp_or_better() {
    let cases: Vec<Case> = serde_json::from_str(include_str!("../../../../fixtures/golden/hierarchies.json")).unwrap();
    assert_eq!(cases.len(), 200);
    let (mut better, mut broken) = (0, 0);
    for (i, case) in cases.iter().enumerate() {
        let hierarchy = case.hierarchy();
        let answer = hierarchy.solve(&[]);
        let velocity = answer.joint_velocity.as_slice();
        assert_eq!(answer.solver.status, Status::Optimal, "problem {i}");
        // The distance from the reference is the last level.
        let levels = |x: &[f64]| [hierarchy.slacks(x), vec![hierarchy.distance(x)]].concat();
        let (ours, theirs) = (levels(velocity), levels(&case.answer));
        let gaps = ours.iter().zip(&theirs).map(|(ours, theirs)| ours - theirs);
        let gap = gaps.clone().find(|gap| gap.abs() > 1e-6).unwrap_or(0.0);
        assert!(gap <= 0.0, "problem {i}: slacks {ours:?} instead of {theirs:?}");
        broken += usize::from(ours.iter().any(|slack| *slack > 1e-3));
        if gap < 0.0 {
            better += 1;
            continue;
        }
        let error = velocity.iter().zip(&case.answer).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(error <= 1e-4, "problem {i}: off by {error:e}: {velocity:?} instead of {:?}", case.answer);
    }
    assert!(broken > 50, "the problems lack contradictions: {broken}");
    assert!(better < 10, "DAQP was exact when the file was written, now {better} answers are better");
}
