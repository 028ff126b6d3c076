//! What each way to a working set finds alone, and what an answer is whose working set is not found in time.

use super::*;
use crate::resolution::hierarchy::Hierarchy;
use crate::resolution::solver::tests::{RandomSet, WIDTH};

/// Returns the squared slack of each level.
fn slacks(hierarchy: &Hierarchy, x: &[f64]) -> Vec<f64> {
    let slack = |row: usize| {
        let (value, demand) = (hierarchy.value(row, x), &hierarchy.rows[row]);
        (value - demand.upper).max(demand.lower - value).max(0.0)
    };
    hierarchy.levels.iter().map(|level| level.rows().map(|row| slack(row).powi(2)).sum()).collect()
}

#[test]
fn without_a_right_working_set_the_answer_has_the_least_slack_in_the_order_of_the_levels() {
    let (mut solver, mut exact, mut found) =
        (ActiveSetSolver::<WIDTH>::default(), Solution::default(), Solution::default());
    let mut broken = 0;
    for seed in 0..500 {
        let random = RandomSet::new(seed);
        let problem = random.problem();
        solver.solve_rows(&problem, Start::default(), &mut exact);
        if !exact.certainty.is_optimal || exact.certainty.rank_uncertain {
            continue;
        }
        solver.propose_by_cascade(&problem);
        solver.conditions.wrong.push(0);
        solver.write(&problem, &mut found, 1);
        assert!(!found.certainty.is_optimal && !found.is_held_back(), "seed {seed}");
        let inside = |(j, x): (usize, &f64)| problem.lower.0[j] <= *x && *x <= problem.upper.0[j];
        assert!(found.x.iter().enumerate().all(inside), "seed {seed}: {:?}", found.x);
        let (least, reached) = (slacks(random.hierarchy(), &exact.x), slacks(random.hierarchy(), &found.x));
        for (least, reached) in least.iter().zip(&reached) {
            assert!((least - reached).abs() < 1e-9 * (1.0 + least), "seed {seed}: {least} {reached}");
        }
        broken += u32::from(least.iter().any(|slack| *slack > 1e-3));
    }
    assert!(broken > 100, "{broken}");
}

#[test]
fn an_attempt_ends_after_ten_working_sets_of_512_rows_and_after_400_small_ones() {
    assert_eq!([(7, 40), (32, 100), (32, 512), (128, 512)].map(|(n, m)| most_sets(n, m)), [400, 47, 11, 10]);
}

const PROBLEMS: u64 = 1000;

impl ActiveSetSolver<WIDTH> {
    /// Factorises on the present set and returns whether it is the right one.
    fn is_right(&mut self, problem: &ProblemRows<WIDTH>) -> bool {
        let Self { set, solved, conditions, .. } = self;
        solved.solve(problem, set);
        let trial = Trial { problem, set, solved };
        conditions.check_point(trial, TOLERANCES.rounding);
        conditions.check_levels(trial);
        self.conditions.are_met()
    }
}

/// Returns in how many problems `way` finds the right set from the empty one.
fn right_sets(way: impl Fn(&mut ActiveSetSolver<WIDTH>, &ProblemRows<WIDTH>)) -> usize {
    let mut solver = ActiveSetSolver::<WIDTH>::default();
    let found = (0..PROBLEMS).filter(|&seed| {
        let random = RandomSet::new(seed);
        let problem = random.problem();
        solver.factorize_rows(&problem);
        way(&mut solver, &problem);
        solver.is_right(&problem)
    });
    found.count()
}

#[test]
fn the_search_alone_finds_six_of_seven_right_sets() {
    let right = right_sets(|solver, problem| {
        let ActiveSetSolver { search, solved, set, .. } = solver;
        search.propose(problem, solved, TOLERANCES.search_spacing, set);
    });
    assert!(right >= 860, "{right}");
}

#[test]
fn the_cascade_alone_finds_every_right_set() {
    let right = right_sets(|solver, problem| {
        solver.propose_by_cascade(problem);
    });
    assert_eq!(right, 1000);
}

#[test]
fn corrections_alone_end_at_the_answer() {
    let (mut solver, mut exact) = (ActiveSetSolver::<WIDTH>::default(), Solution::default());
    let (mut arrived, mut steps) = (0_u64, 0);
    for seed in 0..PROBLEMS {
        let random = RandomSet::new(seed);
        let problem = random.problem();
        solver.solve_rows(&problem, Start::default(), &mut exact);
        solver.start_from(&problem, Some(&random.set));
        solver.fewest_wrong = usize::MAX;
        for _ in 0..MAX_SETS {
            if solver.is_right(&problem) {
                arrived += 1;
                let off = exact.x.iter().zip(&solver.solved.x.0).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-8 || exact.certainty.rank_uncertain, "seed {seed}: {off}");
                break;
            }
            solver.correct_in_turn(&problem);
            steps += 1;
        }
    }
    assert!(arrived == PROBLEMS && steps <= 9500, "{arrived} of {PROBLEMS} in {steps} steps");
}
