//! Both reference solvers compared with exact answers that were computed independently: reverse priority by Eq. (29) with NumPy,
//! limits by enumeration of all 3ⁿ active sets (fixtures/golden/README.md).

use revprio_problem::{Matrix, Method, Path, Problem, Resolution, Solve, Status, Task, TaskStack, Vector, VelocityBox};
use revprio_reference::{ClosedForm, Qp};
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    kind: String,
    tasks: Vec<CaseTask>,
    closed_form: Vec<f64>,
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
    fn solve(&self, method: Method, solver: &mut dyn Solve) -> Resolution {
        let task = |(k, task): (usize, &CaseTask)| {
            let jacobian = Matrix::from_fn(task.jacobian.len(), task.jacobian[0].len(), |i, j| task.jacobian[i][j]);
            Task::new(format!("task {}", k + 1), jacobian, Vector::from_row_slice(&task.velocity))
        };
        let tasks = TaskStack::new(self.tasks.iter().enumerate().map(task).collect()).unwrap();
        let limits = VelocityBox::new(&self.lower, &self.upper).unwrap();
        let mut answer = Resolution::default();
        solver.solve(&Problem { limits, method, ..Problem::new(tasks) }, &[], &mut answer).unwrap();
        answer
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

#[test]
fn closed_form_equals_the_recursion_of_eq_29() {
    for (i, case) in cases().iter().enumerate() {
        let answer = case.solve(Method::ReversePriority, &mut ClosedForm);
        let error = distance(&answer, &case.closed_form);
        assert!(error < 1e-9, "case {i} ({}): off by {error:e}", case.kind);
        assert_eq!(answer.solver.path, Path::ClosedForm);
    }
}

/// Asserts that Clarabel's cascade solves every case, surely, and inside the limits.
fn assert_every_case_is_exact(method: Method, exact: impl Fn(&Case) -> (&[f64], &[f64])) {
    let (mut qp, mut residuals_before) = (Qp::default(), Vec::new());
    for (i, case) in cases().iter().enumerate() {
        let (velocity, residuals) = exact(case);
        let answer = case.solve(method, &mut qp);
        let context = format!("case {i} ({})", case.kind);
        let error = distance(&answer, velocity);
        assert!(error < 1e-8, "{context}: off by {error:e}");
        assert_eq!(answer.solver.status, Status::Optimal, "{context}: {:?}", answer.solver);
        assert!(answer.solver.iterations > 0 && !answer.levels.is_empty(), "{context}: Clarabel was not called");
        let open = answer.levels.iter().filter(|level| level.iterations > 0);
        residuals_before.extend(open.map(|level| level.clarabel_residual));
        let first = answer.tasks[0].residual_norm;
        assert!((first - residuals[0]).abs() < 1e-9, "{context}: task 1 {first} instead of {}", residuals[0]);
    }
    // Clarabel's own answers, before the polish. Bounds that are hardly active are not seen at once.
    let (levels, imprecise) =
        (residuals_before.len(), residuals_before.iter().filter(|residual| **residual > 1e-6).count());
    println!("{method:?}: {imprecise} of {levels} levels above 1e-6 before the polish");
    assert!(levels > 100 && imprecise * 20 <= levels, "{method:?}: {imprecise} of {levels} levels before the polish");
}

#[test]
fn reverse_priority_in_the_box_equals_enumeration() {
    assert_every_case_is_exact(Method::ReversePriority, |case| (&case.rp_qp, &case.rp_residuals));
}

#[test]
fn strict_reverse_priority_in_the_box_equals_enumeration() {
    assert_every_case_is_exact(Method::StrictReversePriority, |case| (&case.strict_qp, &case.strict_residuals));
}
