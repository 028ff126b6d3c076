//! What an answer is whose working set is not found in time.

use super::*;
use crate::resolution::hierarchy::Hierarchy;
use crate::resolution::solver::random_sets::{RandomSet, WIDTH};

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
        solver.solve(&problem, Start::default(), &mut exact);
        if !exact.certainty.is_optimal || exact.certainty.rank_uncertain {
            continue;
        }
        solver.start_cascade(&problem);
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
