//! Limits: exact answers by enumeration, and warm starts from the previous period.

use proptest::prelude::*;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Solver, resolve};
use revprio_core::task::{Task, TaskStack};

use crate::problems::{Random, SMALL, WIDE, problem, speed};
use crate::reference::{enumerate, levels, residuals};
use crate::solvers::resolve_with;

const METHODS: [Method; 2] = [Method::ReversePriority, Method::StrictReversePriority];

#[test]
fn small_problems_equal_the_enumeration_of_all_active_sets() {
    let mut worst = (0.0_f64, 0);
    for seed in 0..6000 {
        let mut random = Random::new(seed);
        let problem = problem(&mut random, SMALL, METHODS[(seed % 2) as usize]);
        let levels = levels(&problem);
        let exact = enumerate(&levels, problem.limits.lower(), problem.limits.upper());
        let size = exact.amax().max(speed(&problem)).max(1.0);
        for solver in [Solver::Qp, Solver::Auto] {
            let answer = resolve_with(solver, &problem, &[]).unwrap().joint_velocity;
            let error = (&answer - &exact).amax() / size;
            worst = if error > worst.0 { (error, seed) } else { worst };
            let (ours, best) = (residuals(&levels, &answer), residuals(&levels, &exact));
            assert!(error <= 1e-8, "seed {seed}, {solver:?}: off by {error:e}; residuals {ours:?}, exact {best:?}");
        }
    }
    println!("largest error {:e}, seed {}", worst.0, worst.1);
}

/// Returns the problem one period later: all entries changed by up to `step`, relative.
fn later(problem: &Problem, random: &mut Random, step: f64) -> Problem {
    let task = |task: &Task| {
        let jacobian = task.jacobian.map(|x| x * (1.0 + step * random.unit()));
        let velocity = task.lower.map(|x| x * (1.0 + step * random.unit()));
        Task { scaled: task.scaled, ..Task::new(task.name.clone(), jacobian, velocity) }
    };
    let tasks = TaskStack::new(problem.tasks.tasks().iter().map(task).collect()).unwrap();
    Problem { tasks, ..problem.clone() }
}

/// Returns a start problem without dependent rows, which would become nearly dependent along the trajectory.
fn trajectory_start(random: &mut Random, method: Method) -> Problem {
    let n = 2 + random.below(6);
    let task = |k: usize, random: &mut Random| {
        let m = 1 + random.below(2);
        let jacobian = Matrix::from_fn(m, n, |_, _| random.unit());
        Task::new(format!("task {k}"), jacobian, Vector::from_fn(m, |_, _| 2.0 * random.unit()))
    };
    let tasks = TaskStack::new((0..3).map(|k| task(k, random)).collect()).unwrap();
    let limits = problem(random, WIDE, method).limits;
    let limits =
        if limits.joint_count() == n { limits } else { VelocityBox::new(&vec![-0.4; n], &vec![0.5; n]).unwrap() };
    Problem { limits, method, ..Problem::new(tasks) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn warm_starts_from_the_previous_period_change_no_answer(seed in any::<u64>()) {
        let mut random = Random::new(seed);
        let mut problem = trajectory_start(&mut random, METHODS[(seed % 2) as usize]);
        let mut initial = Vec::new();
        for _ in 0..30 {
            problem = later(&problem, &mut random, 0.03);
            let auto = resolve(&problem, &initial).unwrap();
            let qp = resolve_with(Solver::Qp, &problem, &[]).unwrap();
            let size = qp.joint_velocity.amax().max(speed(&problem)).max(1.0);
            let error = (&auto.joint_velocity - &qp.joint_velocity).amax() / size;
            prop_assert!(error <= 1e-8, "off by {error:e}");
            initial = auto.active_set;
        }
    }

    #[test]
    fn a_common_factor_of_rows_and_velocities_changes_nothing(seed in any::<u64>(), exponent in -5..6_i32) {
        let mut random = Random::new(seed);
        let problem = problem(&mut random, SMALL, METHODS[(seed % 2) as usize]);
        let factor = 10_f64.powi(exponent);
        let scaled = |task: &Task| Task {
            jacobian: &task.jacobian * factor,
            lower: &task.lower * factor,
            upper: &task.upper * factor,
            ..task.clone()
        };
        let tasks = TaskStack::new(problem.tasks.tasks().iter().map(scaled).collect()).unwrap();
        let [a, b] = [&problem, &Problem { tasks, ..problem.clone() }]
            .map(|problem| resolve(problem, &[]).unwrap().joint_velocity);
        prop_assert!((&a - &b).amax() <= 1e-9 * a.amax().max(speed(&problem)).max(1.0), "{a} {b}");
    }
}

#[test]
fn extremely_large_and_small_numbers_never_give_an_unsafe_command() {
    for seed in 0..2000 {
        let mut random = Random::new(seed);
        let mut problem = problem(&mut random, SMALL, METHODS[(seed % 2) as usize]);
        let mut extreme = || random.pick(&[1e-320, 1e-300, 1e-160, 1.0, 1e150, 1e160, 1e300]);
        let stretched = |task: &Task, rows: f64, velocity: f64| Task {
            jacobian: &task.jacobian * rows,
            lower: &task.lower * velocity,
            upper: &task.upper * velocity,
            ..task.clone()
        };
        let tasks = problem.tasks.tasks().iter().map(|task| stretched(task, extreme(), extreme())).collect();
        let Ok(tasks) = TaskStack::new(tasks) else { continue };
        problem.tasks = tasks;
        for solver in [Solver::Qp, Solver::Auto] {
            let answer = resolve_with(solver, &problem, &[]).unwrap();
            assert!(answer.joint_velocity.iter().all(|v| v.is_finite()), "seed {seed}: {answer:?}");
            assert!(problem.limits.violation(&answer.joint_velocity) <= 1e-12, "seed {seed}: {answer:?}");
            assert!(answer.broken_limits().next().is_none(), "seed {seed}: {answer:?}");
        }
    }
}

#[test]
fn a_task_that_only_a_corner_of_the_box_satisfies_is_solved() {
    // q̇₁ + q̇₂ = 2 in a box of ±1 has one solution, the corner, at which the multipliers are zero.
    let task =
        |row: &[f64], velocity| Task::new("", Matrix::from_row_slice(1, 2, row), Vector::from_element(1, velocity));
    let tasks = TaskStack::new(vec![task(&[1.0, 1.0], 2.0), task(&[1.0, -1.0], 5.0)]).unwrap();
    let limits = VelocityBox::new(&[-1.0; 2], &[1.0; 2]).unwrap();
    for (method, solver) in METHODS.into_iter().flat_map(|m| [(m, Solver::Qp), (m, Solver::Auto)]) {
        let problem = Problem { limits: limits.clone(), method, ..Problem::new(tasks.clone()) };
        let answer = resolve_with(solver, &problem, &[]).unwrap();
        assert!((&answer.joint_velocity - Vector::repeat(2, 1.0)).amax() <= 1e-12, "{answer:?}");
    }
}
