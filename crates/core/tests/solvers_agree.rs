//! The core's solver compared with `Qp`, which does not know it, and with exact answers of another origin.

#[path = "resolution_properties/problems.rs"]
#[allow(dead_code)]
mod problems;

use problems::{Random, SMALL, problem, speed};
use revprio_core::constraint::Inequality;
use revprio_core::linalg::Damping;
use revprio_core::resolution::{Method, Problem, Resolution, Resolver, Solve, Status};
use revprio_core::task::{Task, TaskStack};
use revprio_core::{
    limits::VelocityBox,
    linalg::{Matrix, Vector},
};
use revprio_reference::Qp;
use serde::Deserialize;

/// Problems for each method.
const PROBLEMS: u64 = 1000;

/// Largest relative difference of two sure answers.
const AGREE: f64 = 1e-9;

/// Largest relative residual of an ordinary level at Clarabel's own answer, before the polish.
const PRECISE: f64 = 1e-6;

fn solve(solver: &mut dyn Solve, problem: &Problem) -> Resolution {
    let mut answer = Resolution::default();
    solver.solve(problem, &[], &mut answer).unwrap();
    answer
}

#[test]
fn clarabel_and_the_core_agree_on_random_problems_with_limits() {
    let (mut qp, mut core) = (Qp::default(), Resolver::default());
    for method in [Method::ReversePriority, Method::StrictReversePriority] {
        let (mut unsure, mut uncertain, mut errors) = (0, 0, Vec::new());
        let (mut levels, mut imprecise, mut active) = (0_u32, 0_u32, 0);
        for seed in 0..PROBLEMS {
            let problem = problem(&mut Random::new(seed), SMALL, method);
            let (one, other) = (solve(&mut qp, &problem), solve(&mut core, &problem));
            for level in one.levels.iter().filter(|level| level.iterations > 0) {
                levels += 1;
                imprecise += u32::from(!(level.clarabel_residual <= PRECISE));
            }
            active += u32::from(other.active_limits().next().is_some());
            if one.solver.status != Status::Optimal || other.solver.status != Status::Optimal {
                unsure += 1;
            } else if one.solver.rank_uncertain || other.solver.rank_uncertain {
                uncertain += 1;
            } else {
                let speeds = [one.joint_velocity.amax(), other.joint_velocity.amax(), speed(&problem), 1e-5];
                let error =
                    (&one.joint_velocity - &other.joint_velocity).amax() / speeds.into_iter().fold(0.0, f64::max);
                errors.push((error, seed));
            }
        }
        let largest = errors.iter().copied().fold((0.0, 0), |a, b| if a.0 > b.0 { a } else { b });
        println!(
            "{method:?}: {} compared, {unsure} unsure, {uncertain} uncertain, {active} at limits, {imprecise} of {levels} levels \
             imprecise, largest difference {largest:?}",
            errors.len()
        );
        assert!(largest.0 <= AGREE, "{method:?}: problem {} differs by {:e}", largest.1, largest.0);
        assert!(
            unsure * 100 <= PROBLEMS && uncertain * 100 <= PROBLEMS,
            "{method:?}: {unsure} unsure, {uncertain} uncertain"
        );
        assert!(u64::from(active) * 3 > PROBLEMS && levels > 1000, "{method:?}: {active} at limits, {levels} levels");
        // 1.4 and 4.2 % with Clarabel's tolerance of 1e-10, and 96 % with 1e-3.
        assert!(imprecise * 10 <= levels, "{method:?}: {imprecise} of {levels} levels before the polish");
    }
}

/// Returns one task that asks n joints for a velocity, in a box of half width 1, with constraints a·q̇ ≤ b of some levels.
fn constrained(velocity: &[f64], constraints: &[(Vec<f64>, f64, u8)], damping: Option<Damping>) -> Problem {
    let n = velocity.len();
    let task = Task::new("rest", Matrix::identity(n, n), Vector::from_column_slice(velocity));
    let limits = VelocityBox::new(&vec![-1.0; n], &vec![1.0; n]).unwrap();
    let mut problem = Problem::new(TaskStack::new(vec![task]).unwrap());
    problem.limits = limits;
    problem.damping = damping;
    for (k, (coefficients, bound, level)) in constraints.iter().enumerate() {
        let mut inequality = Inequality::new(format!("c{k}"), coefficients.clone(), *bound).unwrap();
        inequality.set_level(*level);
        problem.inequalities.push(inequality);
    }
    problem
}

/// Two constraints that contradict each other: the higher level is kept, and within a level both give way alike.
#[test]
fn constraints_yield_to_those_of_higher_levels() {
    let (mut qp, mut core) = (Qp::default(), Resolver::default());
    let (above, below) = (vec![-1.0, 0.0], vec![1.0, 0.0]);
    for (levels, expected) in [([0, 2], 0.5), ([2, 1], -0.5), ([1, 1], 0.0), ([0, 9], 0.5)] {
        let constraints = [(above.clone(), -0.5, levels[0]), (below.clone(), -0.5, levels[1])];
        let problem = constrained(&[0.1, 0.2], &constraints, None);
        for solver in [&mut qp as &mut dyn Solve, &mut core] {
            let answer = solve(solver, &problem);
            assert!((answer.joint_velocity[0] - expected).abs() < 1e-9, "{levels:?}: {}", answer.joint_velocity);
            assert!((answer.joint_velocity[1] - 0.2).abs() < 1e-9, "{levels:?}: {}", answer.joint_velocity);
            assert!(answer.broken_constraints().next().is_some(), "{levels:?}");
        }
    }
}

/// Random constraints of random levels: both solvers agree, also with damping, and no level is violated more than without those below it.
#[test]
fn no_level_of_constraints_pays_for_a_lower_one() {
    let (mut qp, mut core) = (Qp::default(), Resolver::default());
    let mut random = Random::new(7);
    let violation = |problem: &Problem, answer: &Resolution, level: u8| {
        let own = problem.inequalities.iter().filter(|row| row.level() == level);
        own.map(|row| row.violation(&answer.joint_velocity).powi(2)).sum::<f64>()
    };
    let (mut broken, mut compared) = (0, 0);
    for case in 0..300_usize {
        let n = 2 + case % 4;
        let velocity: Vec<f64> = (0..n).map(|_| random.unit()).collect();
        let rows = 2 + case % 7;
        let constraints: Vec<(Vec<f64>, f64, u8)> = (0..rows)
            .map(|k| ((0..n).map(|_| random.unit()).collect(), random.unit() - 0.4, [0, 1, 2][k % 3]))
            .collect();
        let damping = (case % 2 == 1).then_some(Damping::STANDARD);
        let problem = constrained(&velocity, &constraints, damping);
        let (one, other) = (solve(&mut qp, &problem), solve(&mut core, &problem));
        if one.solver.status == Status::Optimal && other.solver.status == Status::Optimal {
            let error = (&one.joint_velocity - &other.joint_velocity).amax();
            assert!(error < 1e-7, "case {case}: {error:e}");
            compared += 1;
        }
        if damping.is_some() {
            continue;
        }
        for level in 0..3_u8 {
            let mut above = problem.clone();
            above.inequalities.retain(|row| row.level() <= level);
            let alone = solve(&mut core, &above);
            let (with, without) = (violation(&problem, &other, level), violation(&above, &alone, level));
            broken += u32::from(without > 1e-6);
            assert!((with - without).abs() < 1e-9, "case {case}, level {level}: {with} in place of {without}");
        }
    }
    assert!(broken > 50, "{broken} levels are broken: too few to tell");
    assert!(compared > 295, "only {compared} of 300 pairs are certified");
}

#[derive(Deserialize)]
struct Case {
    tasks: Vec<CaseTask>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    closed_form: Vec<f64>,
    rp_qp: Vec<f64>,
    strict_qp: Vec<f64>,
}

#[derive(Deserialize)]
struct CaseTask {
    jacobian: Vec<Vec<f64>>,
    velocity: Vec<f64>,
}

/// Solves the cases of `fixtures/golden` with the core; returns the largest difference from the exact answers.
fn largest_error(method: Method, has_limits: bool, exact: impl Fn(&Case) -> &[f64]) -> f64 {
    let text = include_str!("../../../fixtures/golden/resolution_cases.json");
    let cases: Vec<Case> = serde_json::from_str(text).unwrap();
    let mut core = Resolver::default();
    let errors = cases.iter().map(|case| {
        let task = |(k, task): (usize, &CaseTask)| {
            let jacobian = Matrix::from_fn(task.jacobian.len(), task.jacobian[0].len(), |i, j| task.jacobian[i][j]);
            Task::new(format!("task {}", k + 1), jacobian, Vector::from_row_slice(&task.velocity))
        };
        let tasks = TaskStack::new(case.tasks.iter().enumerate().map(task).collect()).unwrap();
        let limits = VelocityBox::new(&case.lower, &case.upper).unwrap();
        let stated = Problem { method, ..Problem::new(tasks) };
        let problem = if has_limits { Problem { limits, ..stated } } else { stated };
        let answer = solve(&mut core, &problem);
        assert_eq!(answer.solver.status, Status::Optimal);
        (&answer.joint_velocity - Vector::from_row_slice(exact(case))).amax()
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn the_core_equals_the_recursion_of_eq_29_without_limits() {
    let error = largest_error(Method::ReversePriority, false, |case| &case.closed_form);
    assert!(error <= AGREE, "off by {error:e}");
}

#[test]
fn the_core_equals_enumeration_of_active_sets_for_reverse_priority() {
    let error = largest_error(Method::ReversePriority, true, |case| &case.rp_qp);
    assert!(error <= AGREE, "off by {error:e}");
}

#[test]
fn the_core_equals_enumeration_of_active_sets_for_the_strict_hierarchy() {
    let error = largest_error(Method::StrictReversePriority, true, |case| &case.strict_qp);
    assert!(error <= AGREE, "off by {error:e}");
}
