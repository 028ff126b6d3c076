//! Five to twelve joints: the initial working set changes the time, not the answer.

use revprio_core::resolution::{ActiveSet, Bound, BoundId, Status};

use crate::findings::Findings;
use crate::random::{Entries, Family, Random, any_set, hierarchy};

const MIDDLE: Family = Family { joints: [5, 12], levels: 4, rows: 5, inequalities: 8 };

/// Compares the answers from the last working set and from three random ones with the answer from none.
fn examine(entries: Entries, seeds: std::ops::Range<u64>) -> Findings {
    let mut findings = Findings::default();
    for seed in seeds {
        let mut random = Random::new(seed);
        let hierarchy = hierarchy(&mut random, MIDDLE, entries);
        let cold = hierarchy.solve(&[]);
        if cold.solver.status != Status::Optimal {
            findings.uncertified.push(seed);
        }
        let mut guesses = vec![cold.active_set.clone()];
        guesses.extend((0..3).map(|_| vec![any_set(&mut random, &hierarchy)]));
        for guess in guesses {
            let warm = hierarchy.solve(&guess);
            if warm.solver.status != Status::Optimal {
                findings.uncertified.push(seed);
            }
            findings.compare(seed, &hierarchy, warm.joint_velocity.as_slice(), cold.joint_velocity.as_slice());
        }
    }
    println!("{entries:?}: {findings}");
    findings
}

/// An answer near a rank threshold or in a degenerate corner may end in another set, which adds rounding.
fn assert_same(findings: &Findings) {
    assert!(findings.wrong.is_empty() && findings.uncertified.is_empty(), "{findings}");
    assert!(findings.quantile(0.999) <= 1e-12 && findings.quantile(1.0) <= 1e-8, "{findings}");
}

#[test]
fn normal_entries_give_the_same_answer_from_any_initial_set() {
    assert_same(&examine(Entries::Normal, 0..5_000));
}

#[test]
fn small_integers_give_the_same_answer_from_any_initial_set() {
    assert_same(&examine(Entries::SmallIntegers, 0..5_000));
}

#[test]
#[ignore = "10⁵ problems, five answers each, take minutes"]
fn many_hierarchies_give_the_same_answer_from_any_initial_set() {
    let halves = [Entries::Normal, Entries::SmallIntegers].map(|entries| examine(entries, 1_000_000..1_050_000));
    halves.iter().for_each(assert_same);
}

/// Seeds with which an earlier solver ran through working sets without an end.
#[test]
fn hierarchies_that_once_cycled_are_solved() {
    let seeds = [(Entries::Normal, vec![347]), (Entries::SmallIntegers, vec![1_016_535, 1_036_891, 1_046_971])];
    for (entries, seeds) in seeds {
        for seed in seeds {
            assert_same(&examine(entries, seed..seed + 1));
        }
    }
}

#[test]
fn the_last_working_set_is_confirmed_at_once() {
    let mut random = Random::new(7);
    for _ in 0..2_000 {
        let hierarchy = hierarchy(&mut random, MIDDLE, Entries::Normal);
        let cold = hierarchy.solve(&[]);
        let warm = hierarchy.solve(&cold.active_set);
        assert_eq!(warm.solver.working_sets, 1, "{hierarchy:?}");
        assert_eq!(warm.joint_velocity, cold.joint_velocity, "{hierarchy:?}");
    }
}

/// A working set from outside may be about another problem: it may name joints and rows that do not exist, name one
/// twice, or come as a list of another length.
#[test]
fn a_working_set_of_another_problem_does_not_change_the_answer() {
    let mut findings = Findings::default();
    for seed in 0..1_000 {
        let mut random = Random::new(seed);
        let hierarchy = hierarchy(&mut random, MIDDLE, Entries::Normal);
        let cold = hierarchy.solve(&[]);
        let both = |index| [BoundId::Joint(index), BoundId::Task { index, row: index }].map(Bound::lower);
        let beyond = (0..100)
            .step_by(7)
            .flat_map(|index| both(index).into_iter().chain(both(index).map(|it| Bound::upper(it.id))))
            .collect();
        let far: ActiveSet = std::iter::once(Bound::upper(BoundId::Joint(usize::MAX))).collect();
        let longer = vec![any_set(&mut random, &hierarchy), far.clone()];
        for guess in [vec![beyond], vec![far], vec![ActiveSet::new(); 9], longer] {
            let warm = hierarchy.solve(&guess);
            if warm.solver.status != Status::Optimal {
                findings.uncertified.push(seed);
            }
            findings.compare(seed, &hierarchy, warm.joint_velocity.as_slice(), cold.joint_velocity.as_slice());
        }
    }
    assert_same(&findings);
}
