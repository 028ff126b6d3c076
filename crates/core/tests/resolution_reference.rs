//! Resolution compared with exact answers that were computed independently: reverse priority by Eq. (29) with NumPy,
//! limits by enumeration of all 3ⁿ active sets (fixtures/golden/README.md).

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{Method, Path, Problem, Resolution, Status, resolve};
use revprio_core::task::{Task, TaskStack};
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    kind: String,
    tasks: Vec<CaseTask>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    rp_qp: Vec<f64>,
    rp_residuals: Vec<f64>,
    strict_qp: Vec<f64>,
    strict_residuals: Vec<f64>,
}

#[derive(Deserialize)]
struct CaseTask {
    jacobian: Vec<Vec<f64>>,
    velocity: Vec<f64>,
}

impl Case {
    fn solve(&self, method: Method) -> Resolution {
        let task = |(k, task): (usize, &CaseTask)| {
            let jacobian = Matrix::from_fn(task.jacobian.len(), task.jacobian[0].len(), |i, j| task.jacobian[i][j]);
            Task::new(format!("task {}", k + 1), jacobian, Vector::from_row_slice(&task.velocity))
        };
        let tasks = TaskStack::new(self.tasks.iter().enumerate().map(task).collect()).unwrap();
        let limits = VelocityBox::new(&self.lower, &self.upper).unwrap();
        resolve(&Problem { limits, method, ..Problem::new(tasks) }, &[]).unwrap()
    }
}

fn cases() -> Vec<Case> {
    let cases: Vec<Case> =
        serde_json::from_str(include_str!("../../../fixtures/golden/resolution_cases.json")).unwrap();
    assert_eq!(cases.len(), 58);
    cases
}

fn distance(answer: &Resolution, exact: &[f64]) -> f64 {
    (&answer.joint_velocity - Vector::from_row_slice(exact)).amax()
}

/// Asserts that every case is solved exactly, certified, and inside the limits.
fn assert_every_case_is_exact(method: Method, exact: impl Fn(&Case) -> (&[f64], &[f64])) {
    for (i, case) in cases().iter().enumerate() {
        let (velocity, residuals) = exact(case);
        let answer = case.solve(method);
        let context = format!("case {i} ({})", case.kind);
        let error = distance(&answer, velocity);
        assert!(error < 1e-8, "{context}: off by {error:e}");
        assert_eq!(answer.solver.status, Status::Optimal, "{context}: {:?}", answer.solver);
        assert!(answer.broken_limits().next().is_none(), "{context}");
        let first = answer.tasks[0].residual_norm;
        assert!((first - residuals[0]).abs() < 1e-9, "{context}: task 1 {first} instead of {}", residuals[0]);
    }
}

#[test]
fn reverse_priority_in_the_box_equals_enumeration() {
    assert_every_case_is_exact(Method::ReversePriority, |case| (&case.rp_qp, &case.rp_residuals));
}

#[test]
fn strict_reverse_priority_in_the_box_equals_enumeration() {
    assert_every_case_is_exact(Method::StrictReversePriority, |case| (&case.strict_qp, &case.strict_residuals));
}

#[test]
fn some_cases_have_active_limits_and_some_have_none() {
    let inside =
        cases().iter().filter(|case| case.solve(Method::ReversePriority).solver.path == Path::ClosedForm).count();
    assert!((10..=48).contains(&inside), "{inside} of 58 cases inside the limits");
}
