//! How often Clarabel's working set is the right one, and how far the answers of `qp` and `auto` are apart.

use revprio_core::linalg::Vector;
use revprio_core::resolution::{Method, Resolution, Solver, Status};

use crate::problems::{EXTREME, Family, Random, SMALL, WIDE, problem, speed};
use crate::solvers::resolve_with;

/// Distances above which two answers count as different.
const LIMITS: [f64; 3] = [1e-12, 1e-9, 1e-6];

#[derive(Debug, Default)]
struct Disagreement {
    problems: u32,
    /// Problems with active limits.
    limited: u32,
    /// Limited problems whose working set needed no correction after Clarabel.
    confirmed: u32,
    /// Problems in which Clarabel failed at a level.
    failed: u32,
    /// Problems with answers farther apart than each of [`LIMITS`], relative to the requested speed.
    apart: [u32; 3],
    uncertified: u32,
}

impl Disagreement {
    fn add(&mut self, qp: &Resolution, auto: &Resolution, requested: f64) {
        self.problems += 1;
        self.failed += u32::from(qp.solver.failures > 0);
        self.uncertified += u32::from(qp.solver.status != Status::Optimal || auto.solver.status != Status::Optimal);
        if !auto.active_limits.is_empty() {
            self.limited += 1;
            self.confirmed += u32::from(qp.solver.working_sets == 1);
        }
        let size = |v: &Vector| v.amax().max(requested).max(1e-5);
        let distance = (&qp.joint_velocity - &auto.joint_velocity).amax() / size(&auto.joint_velocity);
        for (count, limit) in self.apart.iter_mut().zip(LIMITS) {
            *count += u32::from(distance > limit);
        }
    }
}

/// Compares the solvers over random problems of one strict hierarchy.
fn compare(family: Family, seeds: std::ops::Range<u64>) -> Disagreement {
    let mut found = Disagreement::default();
    for seed in seeds {
        let problem = problem(&mut Random::new(seed), family, Method::StrictReversePriority);
        let answer = |solver| resolve_with(solver, &problem, &[]).unwrap();
        found.add(&answer(Solver::Qp), &answer(Solver::Auto), speed(&problem));
    }
    found
}

#[test]
fn clarabel_finds_the_working_set_of_most_problems() {
    let found = compare(WIDE, 0..5000);
    assert!(found.limited > 2000 && f64::from(found.confirmed) > 0.9 * f64::from(found.limited), "{found:?}");
    assert_eq!((found.apart[1], found.uncertified), (0, 0), "{found:?}");
}

#[test]
#[ignore = "10⁶ problems take some ten minutes; prints the table of docs/solver.md"]
fn disagreement_of_clarabel_and_the_solver_over_1e6_problems() {
    println!(
        "| family | problems | limited | set right at once | Clarabel failed | > 1e-12 | > 1e-9 | > 1e-6 | uncertified |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|");
    for (name, family, count) in [("small", SMALL, 300_000), ("wide", WIDE, 600_000), ("extreme", EXTREME, 100_000)] {
        let Disagreement { problems, limited, confirmed, failed, apart, uncertified } = compare(family, 0..count);
        let share = 100.0 * f64::from(confirmed) / f64::from(limited);
        let [a, b, c] = apart;
        println!("| {name} | {problems} | {limited} | {share:.2} % | {failed} | {a} | {b} | {c} | {uncertified} |");
    }
}
