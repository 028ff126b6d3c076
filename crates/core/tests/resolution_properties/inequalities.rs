//! Inequalities a·q̇ ≤ b besides the box.
#![allow(non_snake_case)]

use revprio_core::constraint::Inequality;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{Bound, BoundId, Method, Problem, Solver, Status, resolve};
use revprio_core::task::{Task, TaskStack};

use crate::problems::{Random, SMALL, problem, speed};
use crate::reference::{enumerate, levels};
use crate::solvers::resolve_with;

const METHODS: [Method; 2] = [Method::ReversePriority, Method::StrictReversePriority];

/// Returns a random rotation of n joints.
fn rotation(random: &mut Random, n: usize) -> Matrix {
    Matrix::from_fn(n, n, |_, _| random.unit()).qr().q()
}

/// Returns the problem in rotated coordinates x = R q̇. Its box becomes inequalities.
fn rotated(problem: &Problem, R: &Matrix, random: &mut Random) -> Problem {
    let task = |task: &Task| Task { jacobian: &task.jacobian * R.transpose(), ..task.clone() };
    let tasks = TaskStack::new(problem.tasks.tasks().iter().map(task).collect()).unwrap();
    let bounds = problem.limits.lower().iter().map(|lower| (-1.0, -lower)).enumerate();
    let bounds = bounds.chain(problem.limits.upper().iter().map(|upper| (1.0, *upper)).enumerate());
    let mut inequality = |(joint, (sign, bound)): (usize, (f64, f64))| {
        let length = sign * 10_f64.powf(random.unit());
        let row: Vec<f64> = R.column(joint).iter().map(|entry| length * entry).collect();
        Inequality::new(format!("{joint} {sign}"), row, length.abs() * bound).unwrap()
    };
    let inequalities = bounds.filter(|(_, (_, bound))| bound.is_finite()).map(&mut inequality).collect();
    let null_space_velocity = problem.null_space_velocity.as_ref().map(|zeta| R * zeta);
    let limits = VelocityBox::unbounded(tasks.joint_count());
    Problem { tasks, limits, inequalities, null_space_velocity, ..problem.clone() }
}

#[test]
fn a_rotated_box_gives_the_rotated_answer() {
    let (mut worst, mut unsure) = (0.0_f64, 0);
    for seed in 0..4000 {
        let mut random = Random::new(seed);
        let problem = problem(&mut random, SMALL, METHODS[(seed % 2) as usize]);
        let exact = enumerate(&levels(&problem), problem.limits.lower(), problem.limits.upper());
        let R = rotation(&mut random, exact.len());
        let rotated = rotated(&problem, &R, &mut random);
        let size = exact.amax().max(speed(&problem)).max(1.0);
        for solver in [Solver::Qp, Solver::Auto] {
            let answer = resolve_with(solver, &rotated, &[]).unwrap();
            if solver == Solver::Qp && answer.solver.status == Status::NotCertified {
                unsure += 1;
                continue;
            }
            let error = (R.transpose() * &answer.joint_velocity - &exact).amax() / size;
            worst = worst.max(error);
            assert!(error <= 1e-8, "seed {seed}, {solver:?}: off by {error:e}: {answer:?}");
            assert_eq!(answer.solver.status, Status::Optimal, "seed {seed}");
            for inequality in &rotated.inequalities {
                let excess = inequality.violation(&answer.joint_velocity);
                assert!(excess <= 1e-12 * size, "seed {seed}: {excess:e} beyond {inequality:?}, {answer:?}");
            }
        }
    }
    println!("largest error {worst:e}, {unsure} answers of qp are not sure");
    assert!(unsure <= 40, "{unsure} of 4000 answers of qp are not sure");
}

fn push(velocity: f64) -> TaskStack {
    let rows = Matrix::from_row_slice(1, 2, &[1.0, 1.0]);
    TaskStack::new(vec![Task::new("push", rows, Vector::from_element(1, velocity))]).unwrap()
}

fn box_of(lower: [f64; 2], upper: [f64; 2]) -> VelocityBox {
    VelocityBox::new(&lower, &upper).unwrap()
}

#[test]
fn an_active_inequality_is_named_with_its_multiplier() {
    // ½(q̇₁ + q̇₂ − 2)² with 2 q̇₁ + 2 q̇₂ ≤ 1 is ½ 1.5². It decreases by 1.5/2 per unit of the bound.
    let inequalities = vec![Inequality::new("wall", vec![2.0, 2.0], 1.0).unwrap()];
    for solver in [Solver::Qp, Solver::Auto] {
        let problem = Problem { inequalities: inequalities.clone(), ..Problem::new(push(2.0)) };
        let answer = resolve_with(solver, &problem, &[]).unwrap();
        assert!((&answer.joint_velocity - Vector::repeat(2, 0.25)).amax() <= 1e-14, "{answer:?}");
        assert!(answer.broken_constraints().next().is_none() && answer.active_limits().next().is_none());
        let active: Vec<_> = answer.active_constraints().collect();
        assert!(active.len() == 1 && active[0].0 == 0 && (active[0].1.multiplier - 0.75).abs() < 1e-12);
        let again = resolve_with(Solver::Auto, &problem, &answer.active_set).unwrap();
        assert_eq!(again.solver.working_sets, 1);
        assert!((&again.joint_velocity - &answer.joint_velocity).amax() <= 1e-15, "{solver:?}");
    }
}

#[test]
fn the_closed_form_reports_the_inequalities_that_it_violates() {
    let inequalities = vec![Inequality::new("wall", vec![1.0, 0.0], 0.5).unwrap()];
    let answer = resolve_with(Solver::ClosedForm, &Problem { inequalities, ..Problem::new(push(2.0)) }, &[]).unwrap();
    assert_eq!(answer.broken_constraints().count(), 1);
    let violated = &answer.broken_bounds[0];
    assert_eq!(violated.bound, Bound::upper(BoundId::Constraint { index: 0, row: 0 }));
    assert!(violated.limit == 0.5 && (violated.value - 1.0).abs() < 1e-14, "{violated:?}");
}

#[test]
fn if_inequalities_contradict_the_box_the_box_holds_and_their_violation_is_minimal() {
    // q̇₁ + q̇₂ ≥ 4 and q̇₁ − q̇₂ ≥ 3 contradict a box of ±1. The violation is smallest in least squares at q̇₁ = 1.
    let inequalities = vec![
        Inequality::new("sum", vec![-1.0, -1.0], -4.0).unwrap(),
        Inequality::new("difference", vec![-1.0, 1.0], -3.0).unwrap(),
    ];
    let limits = box_of([-1.0; 2], [1.0; 2]);
    for solver in [Solver::Qp, Solver::Auto] {
        let inequalities = inequalities.clone();
        let problem = Problem { inequalities, limits: limits.clone(), ..Problem::new(push(0.0)) };
        let answer = resolve_with(solver, &problem, &[]).unwrap();
        // min (4 − 1 − y)² + (3 − 1 + y)²: y = ½.
        assert!((&answer.joint_velocity - Vector::from_vec(vec![1.0, 0.5])).amax() <= 1e-12, "{answer:?}");
        let violated: Vec<usize> = answer.broken_constraints().map(|(index, _)| index).collect();
        assert_eq!(violated, [0, 1]);
        assert_eq!(answer.solver.status, Status::Optimal);
    }
}

#[test]
fn if_an_inequality_forbids_rest_the_answer_satisfies_it() {
    let inequalities = vec![Inequality::new("back", vec![1.0, 0.0], -0.3).unwrap()];
    let limits = box_of([-1.0; 2], [1.0; 2]);
    let answer = resolve(&Problem { inequalities, limits, ..Problem::new(push(0.0)) }, &[]).unwrap();
    assert!((&answer.joint_velocity - Vector::from_vec(vec![-0.3, 0.3])).amax() <= 1e-14, "{answer:?}");
}
