//! Where the inequalities of a level cannot all be kept, the answer names a minimal set of demands that contradict each
//! other.

use revprio_core::constraint::Inequality;
use revprio_core::resolution::{Bound, BoundId, Contradiction, Problem, Resolution, Side, Solver, Status, resolve};

use crate::feasibility::{Demand, is_feasible};
use crate::hierarchy::{Hierarchy, Row, length};
use crate::random::{Entries, Family, Random, hierarchy};
use crate::solvers::resolve_with;

/// Slacks above this fraction of the size of their level are contradictions, smaller ones rounding.
const BROKEN: f64 = 1e-9;

/// Returns the demands that a member stands for: an inequality row of the contradicting task in full, one of a higher task as
/// far as the answer keeps it, and an equation at the value that it achieves.
fn demands(problem: &Problem, answer: &Resolution, task: Option<usize>, member: &Bound) -> Vec<Demand> {
    let velocity = &answer.joint_velocity;
    let side = member.side;
    match member.id {
        BoundId::Joint(joint) => {
            let mut unit = vec![0.0; velocity.len()];
            unit[joint] = 1.0;
            vec![bounded(&unit, side, problem.limits.lower()[joint], problem.limits.upper()[joint])]
        }
        BoundId::Constraint { index, .. } => {
            assert_eq!(side, Side::Upper, "a hard inequality has an upper bound");
            let inequality = &problem.inequalities[index];
            let value = inequality.value(velocity);
            let bound = if task.is_none() { inequality.bound() } else { inequality.bound().max(value) };
            vec![Demand::at_most(inequality.coefficients().as_slice(), bound)]
        }
        BoundId::Task { index: of, row } => {
            let contradicting = task.expect("hard inequalities come before all tasks");
            assert!(of <= contradicting, "task {of} is below task {contradicting} and cannot contradict it");
            let rows = &problem.tasks.tasks()[of];
            let coefficients: Vec<f64> = rows.jacobian.row(row).iter().copied().collect();
            let (lower, upper, value) = (rows.lower[row], rows.upper[row], answer.tasks[of].achieved[row]);
            let (lower, upper) = match (of == contradicting, lower == upper) {
                (_, true) => (value, value),
                (true, false) => (lower, upper),
                (false, false) => (lower.min(value), upper.max(value)),
            };
            if lower == upper {
                vec![Demand::at_least(&coefficients, lower), Demand::at_most(&coefficients, upper)]
            } else {
                vec![bounded(&coefficients, side, lower, upper)]
            }
        }
    }
}

fn bounded(coefficients: &[f64], side: Side, lower: f64, upper: f64) -> Demand {
    match side {
        Side::Lower => Demand::at_least(coefficients, lower),
        Side::Upper => Demand::at_most(coefficients, upper),
    }
}

/// Asserts that all members together are infeasible, and that the rest is feasible without any one of them.
fn assert_minimal(problem: &Problem, answer: &Resolution, contradiction: &Contradiction) {
    let members: Vec<Vec<Demand>> =
        contradiction.members.iter().map(|member| demands(problem, answer, contradiction.task, member)).collect();
    let finite = members.iter().flatten().all(|demand| demand.bound.is_finite());
    assert!(finite, "a member without a bound: {contradiction:?}");
    assert!(!is_feasible(&members.concat()), "the members do not contradict each other: {contradiction:?}");
    for left_out in 0..members.len() {
        let rest: Vec<Demand> = members
            .iter()
            .enumerate()
            .filter(|(i, _)| *i != left_out)
            .flat_map(|(_, demands)| demands.clone())
            .collect();
        assert!(is_feasible(&rest), "member {left_out} is not needed: {contradiction:?}");
    }
}

/// Returns the tasks whose inequality rows the answer breaks by more than rounding; `None` for hard inequalities.
fn broken(hierarchy: &Hierarchy, answer: &Resolution) -> Vec<Option<usize>> {
    let velocity = answer.joint_velocity.as_slice();
    let is_broken = |k: &usize| {
        let missing = |row: &Row| (row.value(velocity) - row.upper).max(row.lower - row.value(velocity));
        let rows = hierarchy.levels[*k].iter().filter(|row| row.lower < row.upper);
        rows.map(missing).fold(0.0, f64::max) > BROKEN * hierarchy.size(*k, velocity)
    };
    let hard = answer.broken_constraints().next().map(|_| None);
    hard.into_iter().chain((0..hierarchy.levels.len()).filter(is_broken).map(Some)).collect()
}

/// Asserts that each task with broken inequality rows has a minimal contradiction, and no other task has one.
fn assert_named(hierarchy: &Hierarchy, problem: &Problem, answer: &Resolution) {
    assert_eq!(answer.solver.status, Status::Optimal);
    let named: Vec<_> = answer.contradictions.iter().map(|contradiction| contradiction.task).collect();
    assert_eq!(named, broken(hierarchy, answer), "{:?}", answer.contradictions);
    for contradiction in &answer.contradictions {
        assert_minimal(problem, answer, contradiction);
    }
}

/// Returns a hierarchy in which each level has equations only or inequalities only.
fn separate(random: &mut Random, entries: Entries) -> Hierarchy {
    let family = Family { joints: [2, 8], levels: 4, rows: 4, inequalities: 0 };
    let mut hierarchy = hierarchy(random, family, entries);
    for level in &mut hierarchy.levels {
        if random.one_in(3) {
            continue;
        }
        for row in level {
            let width = (random.entry(entries).abs() + 0.25) * length(&row.coefficients).max(0.01);
            match random.below(3) {
                0 => row.lower = f64::NEG_INFINITY,
                1 => row.upper = f64::INFINITY,
                _ => row.upper += width,
            }
        }
    }
    hierarchy
}

/// Returns one to three hard inequalities, often some that contradict the limits.
fn hard_inequalities(random: &mut Random, n: usize, entries: Entries) -> Vec<Inequality> {
    let mut inequality = |i: usize| {
        let mut coefficients: Vec<f64> = (0..n).map(|_| random.entry(entries)).collect();
        coefficients[i % n] += 0.5;
        let bound = 2.0 * random.entry(entries) - 1.0;
        Inequality::new(i.to_string(), coefficients, bound).unwrap()
    };
    (0..3).map(&mut inequality).collect()
}

/// Returns a random problem, often with hard inequalities.
fn random_problem(entries: Entries, seed: u64) -> (Hierarchy, Problem) {
    let mut random = Random::new(seed);
    let hierarchy = separate(&mut random, entries);
    let mut problem = hierarchy.problem();
    if random.one_in(3) {
        problem.inequalities = hard_inequalities(&mut random, hierarchy.joint_count(), entries);
    }
    (hierarchy, problem)
}

fn examine(entries: Entries, seeds: std::ops::Range<u64>) {
    let (mut tasks, mut hard, mut qp) = (0, 0, NamedByQp::default());
    for seed in seeds {
        println!("seed {seed}");
        let (hierarchy, problem) = random_problem(entries, seed);
        let answer = resolve(&problem, &[]).unwrap();
        assert_named(&hierarchy, &problem, &answer);
        // It takes ten times as long.
        if seed < 4_000 {
            qp.examine(&hierarchy, &problem);
        }
        tasks += usize::from(answer.contradictions.iter().any(|contradiction| contradiction.task.is_some()));
        hard += usize::from(answer.contradictions.iter().any(|contradiction| contradiction.task.is_none()));
    }
    qp.assert_at_least(550);
    assert!(
        tasks > 500 && hard > 50,
        "the problems lack contradictions: {tasks} of tasks, {hard} of hard inequalities"
    );
}

#[test]
fn named_members_of_normal_entries_are_minimal() {
    examine(Entries::Normal, 0..2_000);
}

#[test]
fn named_members_of_small_integers_are_minimal() {
    examine(Entries::SmallIntegers, 0..20_000);
}

/// `qp` names what contradicts by itself: never something wrong, and nothing where Clarabel is too inexact.
#[derive(Default)]
struct NamedByQp {
    named: usize,
    unnamed: usize,
}

impl NamedByQp {
    fn examine(&mut self, hierarchy: &Hierarchy, problem: &Problem) {
        let answer = resolve_with(Solver::Qp, problem, &[]).unwrap();
        let broken = broken(hierarchy, &answer);
        for contradiction in &answer.contradictions {
            assert!(broken.contains(&contradiction.task), "{contradiction:?}");
            assert_minimal(problem, &answer, contradiction);
        }
        self.named += answer.contradictions.len();
        self.unnamed += broken.len() - answer.contradictions.len();
    }

    fn assert_at_least(&self, named: usize) {
        assert!(self.named >= named, "the problems lack contradictions: {}", self.named);
        assert!(
            1_000 * self.unnamed <= self.named,
            "{} contradictions are named, {} are not",
            self.named,
            self.unnamed
        );
    }
}

/// More members than the groups have in which they are reduced.
#[test]
fn named_members_among_many_rows_are_minimal() {
    let mut qp = NamedByQp::default();
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let (n, entries) = (2 + random.below(4), random.pick(&[Entries::Normal, Entries::SmallIntegers]));
        let mut level = |count: usize| {
            let row = |random: &mut Random| {
                let mut coefficients: Vec<f64> = (0..n).map(|_| random.entry(entries)).collect();
                coefficients[0] += 0.5;
                Row { coefficients, lower: f64::NEG_INFINITY, upper: random.entry(entries) - 0.5 }
            };
            (0..count).map(|_| row(&mut random)).collect::<Vec<_>>()
        };
        let (levels, limit) = (vec![level(40), level(60)], vec![1.5; n]);
        let lower = limit.iter().map(|limit| -limit).collect();
        let hierarchy = Hierarchy { lower, upper: limit, reference: vec![0.0; n], levels };
        let (problem, answer) = (hierarchy.problem(), hierarchy.solve(&[]));
        assert_named(&hierarchy, &problem, &answer);
        assert!(!answer.contradictions.is_empty(), "seed {seed}");
        qp.examine(&hierarchy, &problem);
    }
    qp.assert_at_least(200);
}

/// Lower levels use what several higher ones hold: equations that are missed, rows and limits.
#[test]
fn named_members_below_many_levels_are_minimal() {
    let (mut named, mut qp) = (0, NamedByQp::default());
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let (n, entries) = (4 + random.below(9), random.pick(&[Entries::Normal, Entries::SmallIntegers]));
        let mut level = |_| {
            // Equations alone, inequalities alone, or both.
            let (equations, inequalities) = random.pick(&[(n / 3, 0), (0, 2 * n), (n / 3, n)]);
            let row = |random: &mut Random, is_equation: bool| {
                let coefficients = (0..n).map(|_| random.entry(entries)).collect();
                let bound = random.entry(entries) - 0.5;
                Row { coefficients, lower: if is_equation { bound } else { f64::NEG_INFINITY }, upper: bound }
            };
            let inequalities = if inequalities > 0 { 1 + random.below(inequalities) } else { 0 };
            (0..equations + inequalities).map(|i| row(&mut random, i < equations)).collect::<Vec<_>>()
        };
        let levels = (0..8).map(&mut level).collect();
        let hierarchy = Hierarchy { lower: vec![-0.4; n], upper: vec![0.7; n], reference: vec![0.0; n], levels };
        let answer = hierarchy.solve(&[]);
        assert_named(&hierarchy, &hierarchy.problem(), &answer);
        qp.examine(&hierarchy, &hierarchy.problem());
        named += answer.contradictions.len();
    }
    qp.assert_at_least(800);
    assert!(named > 800, "the problems lack contradictions: {named}");
}

/// Returns the members of the only contradiction, those of equations without a side.
fn only_contradiction(hierarchy: &Hierarchy) -> (Option<usize>, Vec<String>) {
    let problem = hierarchy.problem();
    let answer = resolve(&problem, &[]).unwrap();
    assert_named(hierarchy, &problem, &answer);
    let [contradiction] = &answer.contradictions[..] else { panic!("{:?}", answer.contradictions) };
    let name = |&Bound { id, side }: &Bound| match id {
        BoundId::Task { index, row } if hierarchy.levels[index][row].lower == hierarchy.levels[index][row].upper => {
            format!("equation {index}.{row}")
        }
        BoundId::Task { index, row } => format!("row {index}.{row} {side:?}"),
        BoundId::Joint(joint) => format!("limit {joint} {side:?}"),
        BoundId::Constraint { index, .. } => format!("inequality {index} {side:?}"),
    };
    let mut members: Vec<String> = contradiction.members.iter().map(name).collect();
    members.sort();
    (contradiction.task, members)
}

fn row(coefficients: [f64; 2], lower: f64, upper: f64) -> Row {
    Row { coefficients: coefficients.to_vec(), lower, upper }
}

fn within_one(levels: Vec<Vec<Row>>) -> Hierarchy {
    Hierarchy { lower: vec![-1.0; 2], upper: vec![1.0; 2], reference: vec![0.0; 2], levels }
}

#[test]
fn a_row_beyond_a_limit_names_the_limit() {
    let hierarchy = within_one(vec![vec![row([1.0, 0.0], 2.0, f64::INFINITY), row([0.0, 1.0], -0.5, 0.5)]]);
    let members = vec!["limit 0 Upper".to_owned(), "row 0.0 Lower".to_owned()];
    assert_eq!(only_contradiction(&hierarchy), (Some(0), members));
}

#[test]
fn rows_against_an_equation_of_a_higher_task_name_it() {
    let hierarchy = within_one(vec![
        vec![row([1.0, 1.0], 0.5, 0.5)],
        vec![row([1.0, 0.0], 0.5, 3.0), row([0.0, 1.0], 0.5, f64::INFINITY)],
    ]);
    let members = ["equation 0.0", "row 1.0 Lower", "row 1.1 Lower"].map(str::to_owned).to_vec();
    assert_eq!(only_contradiction(&hierarchy), (Some(1), members));
}

#[test]
fn rows_without_a_contradiction_name_nothing() {
    let hierarchy = within_one(vec![vec![row([1.0, 1.0], 1.5, 3.0)], vec![row([1.0, -1.0], 0.4, 0.5)]]);
    let problem = hierarchy.problem();
    let answer = resolve(&problem, &[]).unwrap();
    assert_eq!(answer.contradictions, []);
    assert_named(&hierarchy, &problem, &answer);
}

/// What is missing counts above 10⁻⁹ (‖A‖ ‖q̇‖ + ‖b‖) of its level, where b are the values inside the bounds that are nearest to A q̇.
#[test]
fn a_row_that_is_missed_by_rounding_is_kept() {
    let named = |off: f64| {
        let rows = vec![row([2.0, 0.0], 2.0 * (1.0 + off), f64::INFINITY), row([0.0, 1.0], -3.0, 4.0)];
        let hierarchy = within_one(vec![vec![row([0.0, 0.5], 0.25, 0.25)], rows]);
        let answer = resolve(&hierarchy.problem(), &[]).unwrap();
        assert_eq!(answer.solver.status, Status::Optimal);
        answer.contradictions.len()
    };
    let limit = 1e-9 * (5.0_f64.sqrt() * 1.25_f64.sqrt() + 4.25_f64.sqrt()) / 2.0;
    assert_eq!((named(0.99 * limit), named(1.01 * limit)), (0, 1));
}
