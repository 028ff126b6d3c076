//! How far the answers of solvers that do not know each other are apart: the tables of `docs/solver.md`.
//!
//! `auto` is the solver of this crate; `qp` and `closed_form` are those of `revprio-reference`.
#![allow(non_snake_case, clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::struct_excessive_bools)]

#[path = "resolution_properties/problems.rs"]
#[allow(dead_code)]
mod problems;
#[path = "solvers/mod.rs"]
mod solvers;

use problems::{EXTREME, Family, Random, SMALL, WIDE, damping, inequalities, problem, scaled, speed};
use revprio_core::linalg::{Matrix, RANK_TOLERANCE, stack};
use revprio_core::resolution::{Method, Path, Problem, Resolution, Solver, Status};
use solvers::solver;

const METHODS: [(&str, Method); 5] = [
    ("reverse_priority", Method::ReversePriority),
    ("strict_reverse_priority", Method::StrictReversePriority),
    ("singularity_robust", Method::SingularityRobust),
    ("pseudoinverse", Method::Pseudoinverse),
    ("damped_least_squares", Method::DampedLeastSquares),
];

/// Three of ten problems are small, six are wide, one is extreme.
const FAMILIES: [Family; 10] = [SMALL, SMALL, SMALL, WIDE, WIDE, WIDE, WIDE, WIDE, WIDE, EXTREME];

/// Returns a random problem; a third are damped, a fifth have inequalities, a fifth have scaled tasks.
fn any_problem(seed: u64, family: Family, method: Method) -> Problem {
    let random = &mut Random::new(seed);
    let mut problem = problem(random, family, method);
    problem.damping = random.one_in(3).then(|| damping(random));
    if random.one_in(5) {
        problem.inequalities = inequalities(random, problem.tasks.joint_count());
    }
    if random.one_in(5) {
        let choice = random.bits();
        problem = scaled(&problem, |k| choice >> k & 1 == 1);
    }
    problem
}

/// Two answers to one problem.
struct Pair {
    seed: u64,
    /// Largest difference of the joint velocities, relative to the largest speed of the answers and of the request.
    distance: f64,
    /// Smallest singular value of the rows of first, last and single tasks that counts, relative to its rows.
    weakest: f64,
    is_sure: bool,
    /// Whether one of them says that rounding may have decided a rank.
    is_rank_uncertain: bool,
    /// Whether one slows a scaled task down in its direction and the other one does not.
    slows_differently: bool,
    is_damped: bool,
}

impl Pair {
    fn new(seed: u64, problem: &Problem, auto: &Resolution, other: &Resolution) -> Self {
        let size = auto.joint_velocity.amax().max(other.joint_velocity.amax()).max(speed(problem)).max(1e-5);
        let slowed = |answer: &Resolution| answer.tasks.iter().map(|task| task.scale.is_some()).collect::<Vec<_>>();
        Self {
            seed,
            distance: (&auto.joint_velocity - &other.joint_velocity).amax() / size,
            weakest: weakest(problem),
            is_sure: [auto, other].iter().all(|answer| answer.solver.status == Status::Optimal),
            is_rank_uncertain: auto.solver.rank_uncertain || other.solver.rank_uncertain,
            // The formulas know no scale.
            slows_differently: other.solver.path != Path::ClosedForm && slowed(auto) != slowed(other),
            is_damped: problem.damping.is_some(),
        }
    }

    /// Returns whether both answers are sure of everything that decides them.
    fn is_comparable(&self) -> bool {
        self.is_sure && !self.is_rank_uncertain && !self.slows_differently
    }
}

fn weakest(problem: &Problem) -> f64 {
    let tasks = problem.tasks.tasks();
    let stacked = |range: std::ops::Range<usize>| {
        let empty = Matrix::zeros(0, problem.tasks.joint_count());
        tasks[range].iter().fold(empty, |above, task| stack(&above, &task.jacobian))
    };
    let matrices = (0..tasks.len()).flat_map(|k| [stacked(0..k + 1), stacked(k..tasks.len()), stacked(k..k + 1)]);
    let smallest = |rows: Matrix| {
        let relative = rows.singular_values() / rows.norm();
        relative.iter().copied().filter(|sigma| *sigma > RANK_TOLERANCE).fold(1.0, f64::min)
    };
    matrices.map(smallest).fold(1.0, f64::min)
}

/// Returns the pairs of `auto` and another solver over `count` problems of a method; of `closed_form`, those inside the limits.
fn pairs(name: Solver, method: Method, count: u64) -> Vec<Pair> {
    let (mut auto, mut other) = (solver(Solver::Auto), solver(name));
    let (mut first, mut second) = (Resolution::default(), Resolution::default());
    let mut pairs = Vec::new();
    for seed in 0..count {
        let problem = any_problem(seed, FAMILIES[(seed % 10) as usize], method);
        auto.solve(&problem, &[], &mut first).unwrap();
        other.solve(&problem, &[], &mut second).unwrap();
        let is_inside = second.broken_limits().next().is_none() && second.broken_constraints().next().is_none();
        let has_bounds = problem.tasks.tasks().iter().any(|task| !task.is_equation());
        if name == Solver::Qp || (is_inside && !has_bounds) {
            pairs.push(Pair::new(seed, &problem, &first, &second));
        }
    }
    pairs
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted.get((last as f64 * share).round() as usize).copied().unwrap_or(0.0)
}

fn sorted_distances(pairs: &[&Pair]) -> Vec<f64> {
    let mut distances: Vec<f64> = pairs.iter().filter(|pair| pair.is_comparable()).map(|pair| pair.distance).collect();
    distances.sort_by(f64::total_cmp);
    distances
}

/// Returns a row of the table: how many, how far apart, how many above each bar, how many are not compared.
fn row(label: &str, pairs: &[&Pair]) -> String {
    let distances = sorted_distances(pairs);
    let share = |count: usize| format!("{:.3} %", 100.0 * count as f64 / pairs.len().max(1) as f64);
    let above = |bar: f64| share(distances.iter().filter(|distance| **distance > bar).count());
    let count = |is: &dyn Fn(&Pair) -> bool| share(pairs.iter().filter(|pair| is(pair)).count());
    format!(
        "| {label} | {} | {:.1e} | {:.1e} | {:.1e} | {} | {} | {} | {} | {} | {} |",
        pairs.len(),
        quantile(&distances, 0.5),
        quantile(&distances, 0.99),
        quantile(&distances, 1.0),
        above(1e-9),
        above(1e-7),
        above(1e-5),
        count(&|pair| !pair.is_sure),
        count(&|pair| pair.is_sure && pair.is_rank_uncertain),
        count(&|pair| pair.is_sure && !pair.is_rank_uncertain && pair.slows_differently),
    )
}

const HEADING: &str = "problems | median | 99 % | largest | > 1e-9 | > 1e-7 | > 1e-5 | not sure | rank uncertain | \
     slowed by one |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|";

#[test]
#[ignore = "10⁵ problems of five methods, twice, take two minutes; prints the tables of docs/solver.md"]
fn distribution_over_1e5_problems() {
    let count = std::env::var("REVPRIO_PROBLEMS").ok().and_then(|count| count.parse().ok()).unwrap_or(20_000);
    let mut all: Vec<(&str, Pair)> = Vec::new();
    for name in [Solver::Qp, Solver::ClosedForm] {
        println!("\n| `auto` and {name:?} | {HEADING}");
        for (label, method) in METHODS {
            let pairs = pairs(name, method, count);
            println!("{}", row(&format!("`{label}`"), &pairs.iter().collect::<Vec<_>>()));
            if name == Solver::Qp {
                all.extend(pairs.into_iter().map(|pair| (label, pair)));
            }
        }
    }
    println!("\n| weakest singular value, `auto` and `qp` | {HEADING}");
    for (low, high) in [(1e-1, 2.0), (1e-2, 1e-1), (1e-3, 1e-2), (1e-4, 1e-3), (1e-5, 1e-4), (0.0, 1e-5)] {
        let among: Vec<&Pair> =
            all.iter().map(|(_, pair)| pair).filter(|pair| low <= pair.weakest && pair.weakest < high).collect();
        println!("{}", row(&format!("{low:.0e} to {high:.0e}"), &among));
    }
    all.retain(|(_, pair)| pair.is_comparable());
    all.sort_by(|a, b| b.1.distance.total_cmp(&a.1.distance));
    println!("\n| farthest apart | seed | distance | weakest singular value | damped |\n|---|---:|---:|---:|---|");
    for (label, Pair { seed, distance, weakest, is_damped, .. }) in all.iter().take(8) {
        println!("| `{label}` | {seed} | {distance:.1e} | {weakest:.1e} | {is_damped} |");
    }
}

#[test]
fn sure_answers_agree_and_few_are_not_sure() {
    for (label, method) in METHODS {
        let pairs = pairs(Solver::Qp, method, 1000);
        let distances = sorted_distances(&pairs.iter().collect::<Vec<_>>());
        let unsure = pairs.iter().filter(|pair| !pair.is_sure).count();
        assert!(distances.len() >= 900, "{label}: {} of 1000 are compared", distances.len());
        assert!(quantile(&distances, 0.5) <= 1e-14 && quantile(&distances, 0.99) <= 1e-9, "{label}");
        assert!(quantile(&distances, 1.0) <= 1e-5, "{label}: {}", quantile(&distances, 1.0));
        assert!(unsure <= 10, "{label}: {unsure} of 1000 are not sure");
    }
}
