//! Ranks near their threshold: decided alike by every solver, and reported where rounding may have decided them.

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Resolution, Resolver, Rung, Rungs, Solver, Status, resolve};
use revprio_core::task::{Task, TaskStack};

use crate::problems::Random;
use crate::solvers::resolve_with;

/// Returns two tasks of Gaussian-like rows, the last of which depends on the first one up to `nearness`, within limits.
fn nearly_dependent(random: &mut Random, nearness: f64, same_task: bool, method: Method) -> Problem {
    let n = 7;
    let mut any = |_: usize, _: usize| random.unit();
    let (mut first, mut second) = (Matrix::from_fn(3, n, &mut any), Matrix::from_fn(2, n, &mut any));
    let dependent = first.row(0) + nearness * Matrix::from_fn(1, n, &mut any);
    if same_task {
        first.set_row(2, &dependent);
    } else {
        second.set_row(1, &dependent);
    }
    let velocity = |m: usize, random: &mut Random| Vector::from_fn(m, |_, _| random.unit());
    let tasks = vec![Task::new("1", first, velocity(3, random)), Task::new("2", second, velocity(2, random))];
    let limits = VelocityBox::new(&[-0.5; 7], &[0.5; 7]).unwrap();
    Problem { limits, method, ..Problem::new(TaskStack::new(tasks).unwrap()) }
}

#[test]
fn auto_and_qp_agree_unless_they_say_that_a_rank_is_uncertain() {
    let (mut uncertain, mut uncertified, mut apart, mut rungs) = (0, 0, 0, Rungs::default());
    for seed in 0..3000 {
        let mut random = Random::new(seed);
        let nearness = 10.0_f64.powf(-6.0 - 4.0 * random.unit().abs());
        let method = random.pick(&[Method::ReversePriority, Method::StrictReversePriority, Method::Pseudoinverse]);
        let same_task = random.one_in(2);
        let problem = nearly_dependent(&mut random, nearness, same_task, method);
        let (mut resolver, mut auto) = (Resolver::default(), Resolution::default());
        resolver.resolve(&problem, &[], &mut auto).unwrap();
        rungs = rungs + resolver.rungs();
        let mut again = Resolution::default();
        resolver.resolve(&problem, &[], &mut again).unwrap();
        assert_eq!(again.joint_velocity, auto.joint_velocity, "seed {seed}: the resolver remembers the call before");
        let qp = resolve_with(Solver::Qp, &problem, &[]).unwrap();
        let difference = (&auto.joint_velocity - &qp.joint_velocity).amax();
        let context =
            format!("seed {seed}, {method:?}, {nearness:e}: {difference:e}, {:?}, {:?}", auto.solver, qp.solver);
        let is_uncertain = auto.solver.rank_uncertain || qp.solver.rank_uncertain;
        assert!(difference <= 1e-9 || is_uncertain, "{context}");
        apart += u32::from(difference > 1e-6 && qp.solver.status == Status::Optimal);
        assert!(auto.solver.status == Status::Optimal || is_uncertain, "{context}");
        uncertain += u32::from(auto.solver.rank_uncertain);
        uncertified += u32::from(auto.solver.status != Status::Optimal);
    }
    assert!(uncertain > 100, "few ranks are uncertain: {uncertain}");
    println!("{apart} of 3000 answers are far apart, although qp is sure but for the rank");
    for rung in Rung::ALL {
        println!("{rung:?}: {:?}", rungs[rung]);
    }
    assert!(rungs[Rung::LargerRankTolerance].answered > 0, "no problem needed a larger tolerance for ranks");
    assert!(apart <= 40, "{apart} of 3000 answers are far apart");
    assert!(uncertified <= 15, "of 3000 answers, {uncertified} are not certified");
}

#[test]
fn well_separated_ranks_are_certain() {
    for seed in 0..500 {
        let mut random = Random::new(seed);
        for nearness in [0.0, 1e-3] {
            let same_task = random.one_in(2);
            let problem = nearly_dependent(&mut random, nearness, same_task, Method::StrictReversePriority);
            let answer = resolve(&problem, &[]).unwrap();
            assert!(!answer.solver.rank_uncertain, "seed {seed}, {nearness:e}: {:?}", answer.solver);
        }
    }
}

#[test]
fn a_huge_lower_task_costs_the_top_task_no_digits() {
    for seed in 0..500 {
        let mut random = Random::new(seed);
        let method = random.pick(&[Method::ReversePriority, Method::StrictReversePriority]);
        let mut problem = nearly_dependent(&mut random, 1.0, false, method);
        let tasks = problem.tasks.tasks().to_vec();
        let top = Task::new("top", tasks[0].jacobian.rows(0, 1).into_owned(), Vector::from_element(1, 0.1));
        let huge = Task::new("huge", tasks[1].jacobian.clone(), Vector::from_vec(vec![8e5, -8e5]));
        for limits in [problem.limits.clone(), VelocityBox::unbounded(7)] {
            problem.tasks = TaskStack::new(vec![top.clone(), huge.clone()]).unwrap();
            problem.limits = limits;
            let together = resolve(&problem, &[]).unwrap();
            assert_eq!(together.solver.status, Status::Optimal, "seed {seed}");
            // Without limits the lower task may ask for 1e7 rad/s; then a·q̇ itself is rounded.
            let rounding = f64::EPSILON * top.jacobian.norm() * together.joint_velocity.norm();
            let residual = together.tasks[0].residual_norm;
            assert!(residual <= 1e-9_f64.max(rounding), "seed {seed}: {residual:e}, rounding {rounding:e}");
        }
    }
}
