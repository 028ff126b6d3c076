//! The closed forms compared with the equations as printed, and with each other.

use proptest::prelude::*;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, DampingFactor, Matrix, Vector, stack};
use revprio_core::resolution::{Method, Problem, Solver};
use revprio_core::task::{Task, TaskStack};

use crate::problems::{Family, Random, SMALL, damping, problem};
use crate::reference::{Level, levels, pinv_own, unlimited};
use crate::solvers::resolve_with;

fn solve(tasks: &TaskStack, method: Method, damping: Option<Damping>) -> Vector {
    let limits = VelocityBox::unbounded(tasks.joint_count());
    let problem = Problem { limits, method, damping, ..Problem::new(tasks.clone()) };
    resolve_with(Solver::ClosedForm, &problem, &[]).unwrap().joint_velocity
}

/// All rows, highest priority on top.
fn stacked(tasks: &TaskStack) -> Level {
    let n = tasks.joint_count();
    let start = Level { A: Matrix::zeros(0, n), b: Vector::zeros(0) };
    tasks.tasks().iter().fold(start, |above, task| Level {
        A: Matrix::from_fn(above.A.nrows() + task.jacobian.nrows(), n, |i, j| {
            above.A.get((i, j)).copied().unwrap_or_else(|| task.jacobian[(i - above.A.nrows(), j)])
        }),
        b: Vector::from_iterator(above.b.len() + task.lower.len(), above.b.iter().chain(task.lower.iter()).copied()),
    })
}

fn task(rows: Matrix, velocity: Vector) -> Task {
    Task::new("", rows, velocity)
}

fn row(entries: &[f64], velocity: f64) -> Task {
    task(Matrix::from_row_slice(1, entries.len(), entries), Vector::from_element(1, velocity))
}

/// Draws random tasks until no matrix that Eq. (29) inverts is nearly singular. The smallest singular value is above a quarter
/// of every random threshold of damping, so that no direction fades, which the printed equation does not know.
fn well_conditioned(random: &mut Random) -> TaskStack {
    loop {
        let n = 2 + random.below(7);
        let count = 1 + random.below(4);
        let mut any = || {
            let m = 1 + random.below(2);
            task(Matrix::from_fn(m, n, |_, _| random.unit()), Vector::from_fn(m, |_, _| random.unit()))
        };
        let tasks = TaskStack::new((0..count).map(|_| any()).collect()).unwrap();
        let stacked = stacked(&tasks).A;
        let sigma = stacked.singular_values();
        if stacked.nrows() <= n && sigma.min() > 0.13 {
            return tasks;
        }
    }
}

/// Returns λ for the singular values of `J`; 0 without damping.
fn factor(J: &Matrix, damping: Option<Damping>) -> f64 {
    damping.map_or(0.0, |damping| damping.factor(J.singular_values().min()))
}

/// Returns Jᵀ(J Jᵀ + λ² I)⁻¹.
fn damped_inverse(J: &Matrix, lambda: f64) -> Matrix {
    if lambda == 0.0 {
        return pinv_own(J);
    }
    let m = J.nrows();
    J.transpose() * (J * J.transpose() + Matrix::identity(m, m) * (lambda * lambda)).try_inverse().unwrap()
}

/// Evaluates Eq. (29) as printed: q̇_k = q̇_{k+1} + T_k (J_k T_k)⁺ (ẋ_k − J_k q̇_{k+1}).
///
/// With damping, J_k J_k^# stands before the bracket.
fn printed(tasks: &TaskStack, damping: Option<Damping>) -> Vector {
    let mut qdot = Vector::zeros(tasks.joint_count());
    let mut J_low = Matrix::zeros(0, tasks.joint_count());
    for Task { jacobian: J_k, lower: xdot_k, .. } in tasks.tasks().iter().rev() {
        let J_rp = stack(J_k, &J_low);
        let T_k = damped_inverse(&J_rp, factor(&J_rp, damping)).columns(0, J_k.nrows()).into_owned();
        let reach = J_k * damped_inverse(J_k, factor(J_k, damping));
        qdot += &T_k * pinv_own(&(J_k * &T_k)) * reach * (xdot_k - J_k * &qdot);
        J_low = J_rp;
    }
    qdot
}

/// Evaluates Eq. (11) for two tasks: q̇ = J_1⁺ẋ_1 + (J_2 N_1)⁺(ẋ_2 − J_2 J_1⁺ẋ_1).
fn task_priority(first: &Task, second: &Task) -> Vector {
    let n = first.jacobian.ncols();
    let J1_inverse = pinv_own(&first.jacobian);
    let N1 = Matrix::identity(n, n) - &J1_inverse * &first.jacobian;
    let q1 = J1_inverse * &first.lower;
    // The rank is relative to J_2, because the product with the projector may be only rounding.
    let inverse = crate::reference::pinv(&(&second.jacobian * N1), 1e-10 * second.jacobian.norm());
    &q1 + inverse * (&second.lower - &second.jacobian * &q1)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn reverse_priority_equals_the_printed_equation(seed in any::<u64>()) {
        let mut random = Random::new(seed);
        let tasks = well_conditioned(&mut random);
        let (shipped, printed) = (solve(&tasks, Method::ReversePriority, None), printed(&tasks, None));
        prop_assert!((&shipped - &printed).amax() <= 1e-10 * (1.0 + printed.amax()), "{shipped} {printed}");
    }

    #[test]
    fn damped_reverse_priority_equals_the_printed_equation(seed in any::<u64>()) {
        let mut random = Random::new(seed);
        let tasks = well_conditioned(&mut random);
        let damping = Some(damping(&mut random));
        let (shipped, printed) = (solve(&tasks, Method::ReversePriority, damping), printed(&tasks, damping));
        prop_assert!((&shipped - &printed).amax() <= 1e-9 * (1.0 + printed.amax()), "{shipped} {printed}");
    }

    #[test]
    fn two_tasks_equal_task_priority_and_the_lexicographic_solution(seed in any::<u64>()) {
        let mut random = Random::new(seed);
        // Rows may be exactly dependent, but not nearly dependent, which would amplify rounding.
        let family = Family { nearness: &[], ..SMALL };
        let mut any = problem(&mut random, family, Method::StrictReversePriority);
        any.null_space_velocity = None;
        any.tasks = TaskStack::new(any.tasks.tasks().iter().take(2).cloned().collect()).unwrap();
        let [first, second] = any.tasks.tasks() else { return Ok(()) };
        let expected = task_priority(first, second);
        let n = any.tasks.joint_count();
        let others = [
            solve(&any.tasks, Method::ReversePriority, None),
            solve(&any.tasks, Method::TaskPriority, None),
            solve(&any.tasks, Method::StrictReversePriority, None),
            unlimited(&levels(&any), n),
        ];
        for other in others {
            prop_assert!((&other - &expected).amax() <= 1e-9 * (1.0 + expected.amax()), "{other} {expected}");
        }
    }
}

/// Evaluates Eq. (13) as printed.
fn singularity_robust(first: &Task, second: &Task) -> Vector {
    let n = first.jacobian.ncols();
    let J1_inverse = pinv_own(&first.jacobian);
    let N1 = Matrix::identity(n, n) - &J1_inverse * &first.jacobian;
    J1_inverse * &first.lower + N1 * pinv_own(&second.jacobian) * &second.lower
}

#[test]
fn the_singularity_robust_form_equals_the_printed_equation_and_its_cascade() {
    let mut random = Random::new(13);
    for _ in 0..500 {
        let tasks = well_conditioned(&mut random);
        let [first, second] = tasks.tasks() else { continue };
        let expected = singularity_robust(first, second);
        for solver in [Solver::ClosedForm, Solver::Auto, Solver::Qp] {
            let limits = VelocityBox::unbounded(tasks.joint_count());
            let (tasks, method) = (tasks.clone(), Method::SingularityRobust);
            let problem = Problem { limits, method, ..Problem::new(tasks) };
            let answer = resolve_with(solver, &problem, &[]).unwrap();
            assert!((&answer.joint_velocity - &expected).amax() < 1e-10, "{solver:?}");
            assert!(answer.tasks[0].residual_norm < 1e-10);
        }
    }
}

#[test]
fn three_tasks_show_that_the_recursion_is_strict_for_the_top_task_only() {
    let tasks = TaskStack::new(vec![row(&[1.0, 1.0], 1.0), row(&[1.0, 0.0], 0.0), row(&[0.0, 1.0], 0.0)]).unwrap();
    let residuals = |method| {
        let qdot = solve(&tasks, method, None);
        tasks.tasks().iter().map(|task| (&task.jacobian * &qdot - &task.lower).norm()).collect::<Vec<_>>()
    };
    let close = |a: Vec<f64>, b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
    assert!(close(residuals(Method::ReversePriority), [0.0, 0.5, 0.5]));
    assert!(close(residuals(Method::StrictReversePriority), [0.0, 0.0, 1.0]));
}

#[test]
fn without_damping_velocities_grow_near_a_conflict_and_with_damping_they_stay_bounded() {
    for exponent in 1..8 {
        let epsilon = 10_f64.powi(-exponent);
        let tasks = TaskStack::new(vec![row(&[1.0, 0.0], 1.0), row(&[1.0, epsilon], -1.0)]).unwrap();
        let undamped = solve(&tasks, Method::ReversePriority, None).norm();
        assert!((undamped * epsilon - 2.0).abs() < epsilon, "|q̇| = {undamped:e} at ε = {epsilon:e}");
        let damped = solve(&tasks, Method::ReversePriority, Some(Damping::STANDARD));
        assert!((damped[0] - 1.0).abs() < 1e-12, "task 1 must stay exact");
        assert!(damped.norm() < 25.0, "|q̇| = {:e} at ε = {epsilon:e}", damped.norm());
    }
}

#[test]
fn one_task_of_independent_rows_equals_the_pseudo_inverse() {
    let mut random = Random::new(1);
    for _ in 0..100 {
        let tasks = well_conditioned(&mut random);
        let one = stacked(&tasks);
        let expected = pinv_own(&one.A) * &one.b;
        for method in [Method::Pseudoinverse, Method::ReversePriority, Method::StrictReversePriority] {
            assert!((solve(&tasks, method, None) - &expected).amax() < 1e-10, "{method:?}");
        }
    }
}
