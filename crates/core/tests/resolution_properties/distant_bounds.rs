//! Bounds that are never near, rows that are nearly zero, and tasks of equations and bounds leave the rest of an answer as it is.

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Resolution, Status, resolve};
use revprio_core::task::{Task, TaskStack};

use crate::problems::Random;

fn task(rows: &[&[f64]], lower: &[f64], upper: &[f64]) -> Task {
    let jacobian =
        Matrix::from_row_iterator(rows.len(), rows[0].len(), rows.iter().flat_map(|row| row.iter().copied()));
    Task::between("", jacobian, Vector::from_row_slice(lower), Vector::from_row_slice(upper))
}

fn equations(rows: &[&[f64]], velocity: &[f64]) -> Task {
    task(rows, velocity, velocity)
}

fn problem(tasks: Vec<Task>, (lower, upper): (&[f64], &[f64]), damping: Option<Damping>) -> Problem {
    let limits = VelocityBox::new(lower, upper).unwrap();
    let tasks = TaskStack::new(tasks).unwrap();
    Problem { limits, damping, method: Method::StrictReversePriority, ..Problem::new(tasks) }
}

fn damping() -> Damping {
    Damping::new(0.05, 0.1).unwrap()
}

fn answer(problem: &Problem) -> Resolution {
    let answer = resolve(problem, &[]).unwrap();
    assert_eq!(answer.solver.status, Status::Optimal, "{answer:?}");
    answer
}

/// A task has a row that is an equation and one with bounds. The singular value of the next task crosses the threshold of damping.
#[test]
fn an_equation_of_a_task_with_bounds_leaves_the_damped_answer_continuous() {
    for wanted in [3.0, 30.0, 300.0] {
        let at = |sigma: f64| {
            let tasks = vec![
                task(&[&[1.0, 0.0], &[0.0, 1.0]], &[0.2, -4.0], &[0.2, 4.0]),
                equations(&[&[0.0, sigma]], &[0.5 * sigma]),
                equations(&[&[1.0, 1.0]], &[wanted]),
            ];
            answer(&problem(tasks, (&[-1.0, -4.0], &[0.19, 4.0]), Some(damping()))).joint_velocity
        };
        let change = (at(0.05 - 1e-7) - at(0.05 + 1e-7)).amax();
        assert!(change < 1e-4, "{wanted}: {change}");
    }
}

/// A pivot just above the tolerance for ranks makes those of the next task uncertain.
#[test]
fn an_answer_that_is_not_certified_is_tried_again_with_other_ranks() {
    let tasks = vec![
        equations(&[&[1.0, 0.0, 0.0, 0.0, 0.0], &[0.0, 2e-10, 0.0, 0.0, 0.0]], &[0.1, 1e-10]),
        equations(&[&[0.0, 0.0, 1.0, 0.0, 0.0], &[0.0, 0.0, 0.0, 1e-5, 0.0]], &[0.1, 5e-6]),
        equations(&[&[1.0; 5]], &[1.0]),
    ];
    let answer = answer(&problem(tasks, (&[-2.0; 5], &[2.0; 5]), None));
    assert!((answer.tasks[1].achieved[1] - 5e-6).abs() < 1e-10, "{:?}", answer.tasks[1]);
}

/// The levels of three tasks with upper bounds. Lower ones that are far away change nothing.
#[test]
fn lower_bounds_that_are_far_away_change_no_answer() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut rows = |count: usize| {
            let jacobian = Matrix::from_fn(count, 14, |_, _| 2.0 * random.unit() - 1.0);
            (jacobian, Vector::from_fn(count, |_, _| 0.01 * (random.unit() - 0.7)))
        };
        let levels = [20, 6, 6, 6, 6].map(&mut rows);
        let (equations, velocity) = rows(6);
        let with = |far: f64| {
            let bounded = levels.iter().map(|(rows, upper)| {
                Task::between("", rows.clone(), Vector::from_element(upper.len(), far), upper.clone())
            });
            let last = Task::new("", equations.clone(), velocity.clone());
            answer(&problem(bounded.chain([last]).collect(), (&[-0.01; 14], &[0.01; 14]), None))
        };
        let (none, far) = (with(f64::NEG_INFINITY), with(-1e9));
        let difference = (none.joint_velocity - far.joint_velocity).amax();
        assert!(difference < 1e-10, "seed {seed}: {difference}");
        assert_eq!(far.solver.last_resorts, 0, "seed {seed}");
    }
}

#[test]
fn a_contradiction_is_named_beside_a_bound_that_is_far_away() {
    for far in [f64::NEG_INFINITY, -1.0, -1e6, -1e9] {
        let task = task(&[&[0.0, 1.0], &[0.0, -1.0]], &[far, far], &[-0.001, -0.001]);
        let answer = answer(&problem(vec![task], (&[-1.0; 2], &[1.0; 2]), None));
        assert_eq!(answer.contradictions.len(), 1, "{far}");
        assert_eq!(answer.contradictions[0].members.len(), 2, "{far}: {:?}", answer.contradictions);
    }
}

/// The second joint is far from its limits.
#[test]
fn a_wide_limit_that_is_not_active_leaves_a_damped_task_alone() {
    let at = |lower: f64| {
        let tasks = vec![equations(&[&[1.0, 0.3]], &[1.2]), equations(&[&[0.0, 1.0]], &[0.0])];
        answer(&problem(tasks, (&[-1.0, lower], &[1.0, 1.0]), Some(damping()))).joint_velocity
    };
    let wide = at(-20.0);
    for lower in [-1e2, -1e5, -1e9] {
        assert!((at(lower) - &wide).amax() < 1e-9, "{lower}");
    }
}

#[test]
fn a_row_that_is_nearly_zero_stops_no_other_task() {
    for length in [1e-150, 1e-155, 1e-159, 1e-162, 1e-170] {
        let tasks = vec![equations(&[&[1.0, 0.0]], &[0.5]), equations(&[&[0.0, length]], &[0.3 * length])];
        let answer = resolve(&problem(tasks, (&[-1.0; 2], &[1.0; 2]), None), &[]).unwrap();
        assert!(answer.solver.status != Status::Failed, "{length}");
        assert!((answer.joint_velocity[0] - 0.5).abs() < 1e-12, "{length}: {:?}", answer.joint_velocity);
    }
}
