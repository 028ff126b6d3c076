//! Scaled tasks: limits slow them down without changing their direction.
#![allow(non_snake_case)]

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, DampingFactor, Matrix, Vector, stack};
use revprio_core::resolution::{Method, Problem, Resolution, Solver, Status, resolve};
use revprio_core::task::{Task, TaskStack};

use crate::problems::{Random, SMALL, problem, scaled, speed};
use crate::reference::{Level, enumerate, levels, pinv, pinv_own};
use crate::solvers::resolve_with;

/// Returns the levels with the velocities of scaled tasks multiplied by `factors`.
fn scaled_levels(problem: &Problem, factors: &[Option<f64>]) -> Vec<Level> {
    let mut levels = levels(problem);
    for (level, factor) in levels.iter_mut().zip(factors) {
        level.b *= factor.unwrap_or(1.0);
    }
    levels
}

fn factors(answer: &Resolution) -> Vec<Option<f64>> {
    answer.tasks.iter().map(|task| task.scale).collect()
}

/// Returns the residual of level k of the exact solution, in the directions that the levels above leave free.
fn residual(problem: &Problem, levels: &[Level], k: usize) -> f64 {
    let exact = enumerate(levels, problem.limits.lower(), problem.limits.upper());
    let n = exact.len();
    let above = levels[..k].iter().fold(Matrix::zeros(0, n), |rows, level| stack(&rows, &level.A));
    let open = &levels[k].A * (Matrix::identity(n, n) - pinv_own(&above) * above);
    let reachable = &open * pinv(&open, 1e-10 * levels[k].A.norm());
    (reachable * (&levels[k].A * exact - &levels[k].b)).norm()
}

/// What random problems with scaled tasks have shown.
#[derive(Default)]
struct Scaled {
    /// Number of factors below 1.
    cut: u32,
    /// Number of answers of `qp` that say that they are not sure.
    unsure: u32,
}

/// Checks the answer to one random problem with scaled tasks.
///
/// The check does not depend on how scaling is solved. With the factors of the answer, the problem is an ordinary
/// hierarchy, and its solution by enumeration must be the answer. A larger factor must leave a larger residual.
fn examine(seed: u64, method: Method, seen: &mut Scaled) {
    let mut random = Random::new(seed);
    let problem = problem(&mut random, SMALL, method);
    let choice = random.bits();
    let problem = scaled(&problem, |k| k == 0 || choice >> k & 1 == 1);
    let answer = resolve_with(Solver::Auto, &problem, &[]).unwrap();
    assert_eq!(answer.solver.status, Status::Optimal, "seed {seed}: {answer:?}");
    let size = answer.joint_velocity.amax().max(speed(&problem)).max(1.0);
    let qp = resolve_with(Solver::Qp, &problem, &[]).unwrap();
    if qp.solver.status == Status::Optimal {
        assert!((&qp.joint_velocity - &answer.joint_velocity).amax() <= 1e-8 * size, "seed {seed}");
    } else {
        seen.unsure += 1;
    }

    let factors = factors(&answer);
    let exact = enumerate(&scaled_levels(&problem, &factors), problem.limits.lower(), problem.limits.upper());
    let error = (&answer.joint_velocity - exact).amax() / size;
    assert!(error <= 1e-7, "seed {seed}: off by {error:e}, {factors:?}");

    for (k, factor) in factors.iter().enumerate() {
        let Some(factor) = factor.filter(|factor| *factor < 1.0) else { continue };
        seen.cut += 1;
        let more = |step: f64| {
            let mut factors = factors.clone();
            factors[k] = Some(factor + step);
            residual(&problem, &scaled_levels(&problem, &factors), k)
        };
        let requested = problem.tasks.tasks()[k].lower.norm();
        let (now, then) = (more(0.0), more(1e-4));
        assert!(
            then > now + 1e-9 * requested,
            "seed {seed}: task {k} could be faster than {factor}: {now:e}, {then:e}"
        );
    }
}

#[test]
fn a_scaled_task_keeps_its_direction_at_the_largest_speed() {
    for (method, least) in [(Method::StrictReversePriority, 300), (Method::ReversePriority, 200)] {
        let mut seen = Scaled::default();
        (0..1500).for_each(|seed| examine(seed, method, &mut seen));
        assert!(seen.cut > least, "limits cut only {} tasks", seen.cut);
        assert!(seen.unsure <= 15, "{} answers of qp are not sure", seen.unsure);
    }
}

#[test]
fn a_huge_request_of_scaled_tasks_takes_no_more_work_than_a_large_one() {
    let solve = |seed: u64, method: Method, factor: f64| {
        let problem = scaled(&problem(&mut Random::new(seed), SMALL, method), |_| true);
        let tasks = problem.tasks.tasks().iter().cloned();
        let larger =
            tasks.map(|task| Task { lower: &task.lower * factor, upper: &task.upper * factor, ..task }).collect();
        resolve(&Problem { tasks: TaskStack::new(larger).unwrap(), ..problem }, &[]).unwrap()
    };
    for method in [Method::StrictReversePriority, Method::ReversePriority, Method::TaskPriority] {
        let (mut large, mut huge) = (0, 0);
        for seed in 0..300 {
            large += solve(seed, method, 1e2).solver.working_sets;
            let answer = solve(seed, method, 1e8);
            assert_eq!(answer.solver.status, Status::Optimal, "seed {seed}");
            assert!(answer.solver.working_sets < 200, "seed {seed}: {} sets", answer.solver.working_sets);
            huge += answer.solver.working_sets;
        }
        assert!(huge < 2 * large, "{method:?}: {huge} sets, and {large} for a smaller request");
    }
}

fn plane_task(velocity: [f64; 2], scaled: bool) -> Problem {
    let task = Task::new("move", Matrix::identity(2, 2), Vector::from_row_slice(&velocity));
    let limits = VelocityBox::new(&[-1.0; 2], &[1.0; 2]).unwrap();
    Problem { limits, ..Problem::new(TaskStack::new(vec![Task { scaled, ..task }]).unwrap()) }
}

#[test]
fn limits_change_the_direction_of_a_task_unless_it_is_scaled() {
    let answer = resolve(&plane_task([2.0, 1.0], false), &[]).unwrap();
    assert_eq!((answer.joint_velocity.as_slice(), answer.tasks[0].scale), (&[1.0, 1.0][..], None));
    for method in [
        Method::Pseudoinverse,
        Method::DampedLeastSquares,
        Method::TaskPriority,
        Method::SingularityRobust,
        Method::ReversePriority,
        Method::StrictReversePriority,
    ] {
        let answer = resolve(&Problem { method, ..plane_task([2.0, 1.0], true) }, &[]).unwrap();
        assert!((&answer.joint_velocity - Vector::from_vec(vec![1.0, 0.5])).amax() <= 1e-13, "{answer:?}");
        assert!((answer.tasks[0].scale.unwrap() - 0.5).abs() <= 1e-13);
        // ½(1 − s)²‖ẋ‖² = ½(2 − hi)²·5/4 decreases by 5/4 per unit of the limit.
        assert!((answer.active_bounds[0].multiplier - 1.25).abs() <= 1e-10, "{answer:?}");
    }
}

/// The unit of the rows is no matter of the task: metres or micrometres.
#[test]
fn a_scaled_task_has_the_same_factor_in_all_units() {
    let J = Matrix::from_row_slice(2, 3, &[1.0, 0.5, 0.25, 0.25, 1.0, -0.5]);
    let limits = VelocityBox::new(&[-1.0; 3], &[1.0; 3]).unwrap();
    for method in [Method::StrictReversePriority, Method::ReversePriority, Method::Pseudoinverse] {
        for (solver, exponents) in [(Solver::Auto, -12..=12), (Solver::Qp, -8..=8)] {
            for exponent in exponents {
                let unit = 10_f64.powi(exponent);
                let task = Task::new("", &J * unit, Vector::from_row_slice(&[4.0, 1.0]) * unit);
                let tasks = TaskStack::new(vec![Task { scaled: true, ..task }]).unwrap();
                let problem = Problem { limits: limits.clone(), method, ..Problem::new(tasks) };
                let answer = resolve_with(solver, &problem, &[]).unwrap();
                let scale = answer.tasks[0].scale.unwrap_or(0.0);
                assert!((scale - 11.0 / 28.0).abs() <= 1e-9, "{solver:?}, {method:?}, 1e{exponent}: {answer:?}");
            }
        }
    }
}

/// Rows that hardly move the task: it stops, and the answer is certified.
#[test]
fn a_scaled_task_that_joints_hardly_move_stops() {
    for unit in [1e-300, 1e-200, 1e-100, 1e-30] {
        let task = Task::new("", Matrix::identity(2, 2) * unit, Vector::from_row_slice(&[4.0, 1.0]));
        let limits = VelocityBox::new(&[-1.0; 2], &[1.0; 2]).unwrap();
        let problem = Problem { limits, ..Problem::new(TaskStack::new(vec![Task { scaled: true, ..task }]).unwrap()) };
        let answer = resolve(&problem, &[]).unwrap();
        assert_eq!(answer.solver.status, Status::Optimal, "{unit:e}: {answer:?}");
        assert!(answer.tasks[0].scale.unwrap_or(0.0) <= 1e-25, "{unit:e}: {answer:?}");
    }
}

#[test]
fn a_task_without_active_limits_has_the_factor_one() {
    for solver in [Solver::ClosedForm, Solver::Qp, Solver::Auto] {
        let answer = resolve_with(solver, &plane_task([0.5, 1.0], true), &[]).unwrap();
        assert_eq!(answer.tasks[0].scale, Some(1.0), "{solver:?}");
    }
}

#[test]
fn if_limits_exclude_every_factor_the_residual_is_minimal() {
    let limits = VelocityBox::new(&[-1.0, 0.5], &[0.2, 1.0]).unwrap();
    let answer = resolve(&Problem { limits, ..plane_task([1.0, 0.5], true) }, &[]).unwrap();
    assert_eq!((answer.joint_velocity.as_slice(), answer.tasks[0].scale), (&[0.2, 0.5][..], None));
    assert_eq!(answer.solver.status, Status::Optimal);
}

#[test]
fn a_fixed_joint_stops_the_whole_task() {
    let limits = VelocityBox::new(&[-1.0, 0.0], &[1.0, 0.0]).unwrap();
    let answer = resolve(&Problem { limits, ..plane_task([1.0, 0.5], true) }, &[]).unwrap();
    assert!(answer.joint_velocity.amax() <= 1e-14 && answer.tasks[0].scale.unwrap() <= 1e-14, "{answer:?}");
}

/// Returns tasks on two joints within ±1, scaled ones marked.
fn plane_tasks(method: Method, tasks: &[(&[f64], &[f64], bool)]) -> Problem {
    let task = |&(rows, velocity, scaled): &(&[f64], &[f64], bool)| {
        let rows = Matrix::from_row_slice(velocity.len(), 2, rows);
        Task { scaled, ..Task::new("", rows, Vector::from_row_slice(velocity)) }
    };
    let limits = VelocityBox::new(&[-1.0; 2], &[1.0; 2]).unwrap();
    Problem { limits, method, ..Problem::new(TaskStack::new(tasks.iter().map(task).collect()).unwrap()) }
}

fn assert_scales(problem: &Problem, velocity: [f64; 2], scales: &[Option<f64>]) {
    let answer = resolve(problem, &[]).unwrap();
    let near = |(a, b): (&Option<f64>, &Option<f64>)| {
        a.is_some() == b.is_some() && (a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs() < 1e-12
    };
    assert!((&answer.joint_velocity - Vector::from_row_slice(&velocity)).amax() < 1e-12, "{answer:?}");
    assert!(factors(&answer).iter().zip(scales).all(near), "{answer:?}");
    assert_eq!(answer.solver.status, Status::Optimal);
}

/// The tasks of a strict hierarchy have a scale each, the stack of the pseudo-inverse has one, and reverse priority scales its
/// highest task alone.
#[test]
fn each_method_scales_what_it_solves_at_once() {
    let two: [(&[f64], &[f64], bool); 2] = [(&[1.0, 0.0], &[2.0], true), (&[0.0, 1.0], &[4.0], true)];
    assert_scales(&plane_tasks(Method::StrictReversePriority, &two), [1.0, 1.0], &[Some(0.5), Some(0.25)]);
    assert_scales(&plane_tasks(Method::Pseudoinverse, &two), [0.5, 1.0], &[Some(0.25), Some(0.25)]);
    assert_scales(&plane_tasks(Method::ReversePriority, &two), [1.0, 1.0], &[Some(0.5), None]);
    // The first task is bent by the limits and leaves nothing that could bend the second one.
    let second: [(&[f64], &[f64], bool); 2] =
        [(&[1.0, 1.0, 0.0, 1.0], &[3.0, 0.5], false), (&[1.0, 0.0], &[4.0], true)];
    assert_scales(&plane_tasks(Method::StrictReversePriority, &second), [1.0, 1.0], &[None, Some(1.0)]);
}

/// What the higher task decides does not count as a change of direction, in any unit.
#[test]
fn a_higher_task_does_not_bend_a_scaled_one() {
    for unit in [1.0, 1e-6] {
        let above: (&[f64], &[f64], bool) = (&[unit, 0.0], &[0.0], false);
        let scaled: (&[f64], &[f64], bool) = (&[unit, 0.0, 0.0, unit], &[unit, 2.0 * unit], true);
        assert_scales(&plane_tasks(Method::StrictReversePriority, &[above, scaled]), [0.0, 1.0], &[None, Some(0.5)]);
    }
}

/// A task at rest has no direction to keep. A direction is kept up to 10⁻¹¹ (‖J‖ ‖q̇‖ + ‖ẋ‖).
#[test]
fn rest_has_no_scale_and_rounding_does_not_cut() {
    let rest: (&[f64], &[f64], bool) = (&[1.0, 0.0], &[0.0], true);
    let limits = VelocityBox::new(&[0.2, -1.0], &[1.0, 1.0]).unwrap();
    let forced = Problem { limits, ..plane_tasks(Method::ReversePriority, &[rest]) };
    assert_scales(&forced, [0.2, 0.0], &[None]);
    let scale = |off: f64| {
        let move_it: (&[f64], &[f64], bool) = (&[2.0, 0.0], &[6.0], true);
        let limits = VelocityBox::new(&[-9.0; 2], &[3.0 * (1.0 - off), 9.0]).unwrap();
        let problem = Problem { limits, ..plane_tasks(Method::ReversePriority, &[move_it]) };
        resolve(&problem, &[]).unwrap().tasks[0].scale.unwrap()
    };
    assert!(scale(1.95e-11) == 1.0 && scale(2.05e-11) < 1.0, "{} {}", scale(1.95e-11), scale(2.05e-11));
}

/// The velocity of a scaled stack is damped first: 0.1 q̇ = 0.02 gives q̇ = 0.1 · 0.02/(0.01 + λ²).
#[test]
fn a_scaled_stack_is_damped_before_it_is_scaled() {
    let damping = Damping::new(0.2, 0.1).unwrap();
    let weak: (&[f64], &[f64], bool) = (&[0.1, 0.0], &[0.02], true);
    let problem = Problem { damping: Some(damping), ..plane_tasks(Method::DampedLeastSquares, &[weak]) };
    let lambda = damping.factor(0.1);
    assert_scales(&problem, [0.002 / (0.01 + lambda * lambda), 0.0], &[Some(1.0)]);
}
