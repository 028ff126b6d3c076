//! Large problems, up to 128 unknowns and 512 rows.

use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{Resolution, Status};

use crate::hierarchy::{Hierarchy, Row, length};
use crate::random::{Entries, Random};

/// Returns a hierarchy of n unknowns and 4 n rows: inequalities, equations, a level of both with rows of the levels
/// above once more, and two levels for which little or nothing is left.
fn large(random: &mut Random, n: usize) -> Hierarchy {
    let equation = |random: &mut Random| {
        let velocity = random.entry(Entries::Normal);
        Row { coefficients: coefficients(random, n), lower: velocity, upper: velocity }
    };
    let inequality = |random: &mut Random| {
        let (bound, width) = (random.entry(Entries::Normal), random.unit());
        Row { coefficients: coefficients(random, n), lower: bound - width, upper: bound + width }
    };
    let one_sided = |random: &mut Random| Row { upper: f64::INFINITY, ..inequality(random) };
    let first: Vec<Row> = (0..n).map(|_| inequality(random)).collect();
    let second: Vec<Row> = (0..n / 2).map(|_| equation(random)).collect();
    let again = first.iter().chain(&second).step_by(4).cloned().map(|row| moved(row, random.unit()));
    let again: Vec<Row> = again.collect();
    let third = (again.len()..n).map(|i| if i % 2 == 0 { equation(random) } else { inequality(random) }).chain(again);
    let third = third.collect();
    let fourth = (0..n).map(|_| one_sided(random)).collect();
    let fifth = (0..n / 2).map(|_| equation(random)).collect();
    let limit = |random: &mut Random| 0.3 + random.unit();
    Hierarchy {
        lower: (0..n).map(|_| -limit(random)).collect(),
        upper: (0..n).map(|_| limit(random)).collect(),
        reference: (0..n).map(|_| 0.1 * random.normal()).collect(),
        levels: vec![first, second, third, fourth, fifth],
    }
}

/// Returns a row of length about one, of which half of the entries are zero.
fn coefficients(random: &mut Random, n: usize) -> Vec<f64> {
    let scale = (2.0 / n as f64).sqrt();
    (0..n).map(|_| if random.one_in(2) { 0.0 } else { scale * random.normal() }).collect()
}

fn moved(row: Row, distance: f64) -> Row {
    Row { lower: row.lower + distance, upper: row.upper + distance, ..row }
}

fn assert_certified(hierarchy: &Hierarchy, answer: &Resolution) {
    let residual = answer.solver.kkt_residual.unwrap_or(f64::INFINITY);
    assert!(answer.solver.status == Status::Optimal && residual <= 1e-9, "{:?}", answer.solver);
    let limits = hierarchy.lower.iter().zip(&hierarchy.upper);
    let excess = limits.zip(&answer.joint_velocity).map(|((lower, upper), x)| (x - upper).max(lower - x));
    assert!(excess.fold(0.0, f64::max) <= 1e-12);
}

/// Asserts that no direction within the limits reduces the slack of the first level.
///
/// With the slack s, its sign that of the excess, −Aᵀs is the direction of steepest descent. A joint between its limits
/// must have none, a joint at a limit may have one that points outwards.
fn assert_first_level_is_optimal(hierarchy: &Hierarchy, velocity: &[f64]) {
    let rows = &hierarchy.levels[0];
    let A = Matrix::from_fn(rows.len(), velocity.len(), |i, j| rows[i].coefficients[j]);
    let excess = |row: &Row| (row.value(velocity) - row.upper).max(0.0) - (row.lower - row.value(velocity)).max(0.0);
    let s = Vector::from_iterator(rows.len(), rows.iter().map(excess));
    let descent = -(A.transpose() * &s);
    for (j, &along) in descent.iter().enumerate() {
        let inwards = if velocity[j] == hierarchy.upper[j] {
            (-along).max(0.0)
        } else if velocity[j] == hierarchy.lower[j] {
            along.max(0.0)
        } else {
            along.abs()
        };
        assert!(inwards <= 1e-11 * hierarchy.size(0, velocity), "joint {j} can reduce the slack: {inwards:e}");
    }
}

#[test]
fn large_hierarchies_are_optimal() {
    let mut random = Random::new(128);
    for n in [16, 24, 34, 48, 64, 96, 128] {
        let hierarchy = large(&mut random, n);
        let answer = hierarchy.solve(&[]);
        assert_certified(&hierarchy, &answer);
        let velocity = answer.joint_velocity.as_slice();
        assert_first_level_is_optimal(&hierarchy, velocity);
        println!("{n} unknowns: slacks {:.3?}, {:?}", hierarchy.slacks(velocity), answer.solver);
    }
}

#[test]
fn lower_levels_do_not_change_the_slack_of_the_first_one() {
    let mut random = Random::new(256);
    let hierarchy = large(&mut random, 128);
    let rows: usize = hierarchy.levels.iter().map(Vec::len).sum();
    assert_eq!((hierarchy.joint_count(), rows), (128, 512));
    let alone = Hierarchy { levels: hierarchy.levels[..1].to_vec(), ..hierarchy.clone() };
    let [all, alone] = [&hierarchy, &alone].map(|hierarchy| {
        let answer = hierarchy.solve(&[]);
        assert_certified(hierarchy, &answer);
        hierarchy.slacks(answer.joint_velocity.as_slice())[0]
    });
    assert!(all <= alone + 1e-9 && alone > 0.1, "slack {all} instead of {alone}");
}

#[test]
fn a_large_warm_start_gives_the_same_answer() {
    let mut random = Random::new(512);
    let mut hierarchy = large(&mut random, 64);
    let before = hierarchy.solve(&[]);
    for row in hierarchy.levels.iter_mut().flatten() {
        *row = moved(row.clone(), 1e-3 * random.normal());
    }
    let (cold, warm) = (hierarchy.solve(&[]), hierarchy.solve(&before.active_set));
    assert_certified(&hierarchy, &warm);
    let difference = (&cold.joint_velocity - &warm.joint_velocity).amax();
    assert!(difference <= 1e-11 * length(cold.joint_velocity.as_slice()), "{difference:e}");
}

/// Most inequality rows of a level cannot be kept together. The working set is found level by level, and the answer names one
/// contradiction for each level.
#[test]
fn hundreds_of_rows_that_contradict_each_other_need_few_sets() {
    for (n, levels) in [(7, [480, 16, 8]), (24, [200, 200, 60]), (32, [400, 80, 16]), (32, [40, 300, 100])] {
        for entries in [Entries::Normal, Entries::SmallIntegers] {
            let mut random = Random::new(n as u64);
            let side = |random: &mut Random| {
                let coefficients = (0..n).map(|_| random.entry(entries)).collect();
                let bound = random.normal();
                if random.one_in(2) {
                    Row { coefficients, lower: bound, upper: f64::INFINITY }
                } else {
                    Row { coefficients, lower: f64::NEG_INFINITY, upper: bound }
                }
            };
            let levels = levels.map(|count| (0..count).map(|_| side(&mut random)).collect()).to_vec();
            let (lower, upper, reference) = (vec![-0.5; n], vec![0.7; n], vec![0.1; n]);
            let hierarchy = Hierarchy { lower, upper, reference, levels };
            let answer = hierarchy.solve(&[]);
            assert_certified(&hierarchy, &answer);
            assert_first_level_is_optimal(&hierarchy, answer.joint_velocity.as_slice());
            assert!(answer.solver.working_sets <= 5, "{n} {entries:?}: {:?}", answer.solver);
            let slacks = hierarchy.slacks(answer.joint_velocity.as_slice());
            let broken = slacks.iter().filter(|slack| **slack > 1e-9).count();
            assert!(broken >= 2 && answer.contradictions.len() == broken, "{n} {entries:?}: {slacks:?}");
            let longest = answer.contradictions.iter().map(|contradiction| contradiction.members.len()).max();
            assert!(longest <= Some(n + 1), "{n} {entries:?}: {longest:?} members");
        }
    }
}

/// The sets of [`large`] that take most trials.
#[test]
fn many_levels_of_inequality_rows_need_few_sets() {
    for (n, seed) in [(16, 11), (24, 4), (24, 6)] {
        let hierarchy = large(&mut Random::new(seed), n);
        let answer = hierarchy.solve(&[]);
        assert_certified(&hierarchy, &answer);
        assert!(answer.solver.working_sets <= 4, "{n} {seed}: {:?}", answer.solver);
    }
}
