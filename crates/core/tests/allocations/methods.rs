//! Methods, damping, and the memory of the search for the active limits.

use allocation_counter::measure;
use revprio_core::controller::{ControllerConfig, Limits};
use revprio_core::limits::{LimitKind, VelocityBox};
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Resolution, Resolver, resolve};
use revprio_core::task::{Task, TaskStack};

use crate::arm::{Arm, after_warm_up, assert_allocates_nothing, config, push_and_hold};

pub const METHODS: [Method; 6] = [
    Method::ReversePriority,
    Method::StrictReversePriority,
    Method::TaskPriority,
    Method::SingularityRobust,
    Method::DampedLeastSquares,
    Method::Pseudoinverse,
];

#[test]
fn every_method_allocates_nothing_inside_the_limits_and_at_them() {
    let slow = Limits::Fixed(VelocityBox::new(&[-0.1; 7], &[0.1; 7]).unwrap());
    for method in METHODS {
        for (limits, is_slow) in [(Limits::Robot(LimitKind::PositionVelocity), false), (slow.clone(), true)] {
            for damping in [None, Some(Damping::ARM)] {
                let config = ControllerConfig { method, damping, ..config(limits.clone(), push_and_hold()) };
                assert_allocates_nothing(&format!("{method:?}, {is_slow}"), config, 200, |command| {
                    command.resolution.active_limits().next().is_none() != is_slow
                });
            }
        }
    }
}

#[test]
fn the_answer_without_limits_needs_no_search() {
    let counts = after_warm_up(config(Limits::Robot(LimitKind::Velocity), push_and_hold()), |_| true);
    assert_eq!((counts.allocations, counts.qp, counts.active_set), (0, 0, 0));
}

/// A stretched arm is damped, and fast limits hold it at the same time.
#[test]
fn damping_near_a_singularity_with_active_limits_allocates_nothing() {
    let slow = Limits::Fixed(VelocityBox::new(&[-0.05; 7], &[0.05; 7]).unwrap());
    for method in METHODS {
        let damping = Some(Damping::ARM);
        let config = ControllerConfig { method, damping, ..config(slow.clone(), push_and_hold()) };
        let mut arm = Arm::at(config, &[0.0, 0.02, 0.0, 0.02, 0.0, 0.02, 0.0]);
        arm.warm_up();
        let counts = arm.run(2000, |command| {
            let singular = command.resolution.singularity.smallest_singular_value() < Damping::ARM.threshold();
            singular && command.resolution.active_limits().next().is_some()
        });
        assert!(counts.seen > 200, "{method:?}: {counts:?}");
        assert_eq!((counts.allocations, counts.qp), (0, 0), "{method:?}: {counts:?}");
    }
}

/// The memory of the answer has its size from a first answer, which starts from the right working set.
#[test]
fn a_search_that_meets_more_limits_than_before_allocates_nothing() {
    let task = Task::new("all", Matrix::from_diagonal_element(7, 7, 1.0), Vector::from_element(7, 1.0));
    let mut problem = Problem::new(TaskStack::new(vec![task]).unwrap());
    let mut limit = [10.0; 7];
    limit[0] = 0.5;
    let bounds = |limit: [f64; 7]| VelocityBox::new(&limit.map(|limit| -limit), &limit).unwrap();
    let (mut resolver, mut answer) = (Resolver::default(), Resolution::default());
    problem.limits = bounds(limit);
    resolver.resolve(&problem, &[], &mut answer).unwrap();
    problem.limits = bounds([0.5; 7]);
    let guess = resolve(&problem, &[]).unwrap().active_set;
    resolver.resolve(&problem, &guess, &mut answer).unwrap();
    let counted = measure(|| resolver.resolve(&problem, &[], &mut answer).unwrap());
    assert_eq!((counted.count_total, answer.active_limits().count(), answer.solver.working_sets), (0, 7, 2));
}
