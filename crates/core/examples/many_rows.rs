//! Problems with many rows that contradict each other: working sets, times, and how often each way to a working set was needed,
//! as docs/solver.md has them.
//!
//!     cargo run --release -p revprio-core --example many_rows        # all families
//!     cargo run --release -p revprio-core --example many_rows 32     # those with at most 32 joints

use std::time::{Duration, Instant};

use revprio_core::constraint::Inequality;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Resolution, Resolver, Rung, Rungs, Status};
use revprio_core::task::{Task, TaskStack};

const PROBLEMS: u64 = 20;

/// Joints, hard inequalities, rows of each inequality task, rows of each equation task below them.
type Family = (usize, usize, &'static [usize], &'static [usize]);

const FAMILIES: [Family; 10] = [
    (7, 0, &[], &[3, 3]),
    (35, 0, &[], &[12, 6, 6, 8]),
    (7, 8, &[6; 3], &[3, 3]),
    (14, 20, &[4; 6], &[3; 6]),
    (7, 480, &[], &[3, 3]),
    (24, 200, &[60; 4], &[6, 6]),
    (32, 400, &[], &[6, 6, 3]),
    (32, 0, &[100; 5], &[6, 6]),
    (32, 0, &[40; 12], &[6, 6]),
    (128, 400, &[10; 8], &[12, 20]),
];

/// How the coefficients of rows are chosen.
#[derive(Debug, Clone, Copy)]
enum Rows {
    Normal,
    SmallIntegers,
    NearlyParallel,
    Sparse,
}

/// Reproducible numbers (SplitMix64).
struct Random(u64);

impl Random {
    /// 0 to 1, without 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Nearly normally distributed.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }

    fn coefficients(&mut self, rows: Rows, direction: &[f64]) -> Vec<f64> {
        let mut coefficient = |along: f64| match rows {
            Rows::Normal => self.normal(),
            Rows::SmallIntegers => (3.0 * self.unit()).floor() - 1.0,
            Rows::NearlyParallel => along + 0.05 * self.normal(),
            Rows::Sparse => {
                if self.unit() < 0.25 {
                    self.normal()
                } else {
                    0.0
                }
            }
        };
        direction.iter().map(|along| coefficient(*along)).collect()
    }

    fn matrix(&mut self, count: usize, rows: Rows, direction: &[f64]) -> Matrix {
        let entries: Vec<f64> = (0..count).flat_map(|_| self.coefficients(rows, direction)).collect();
        Matrix::from_row_slice(count, direction.len(), &entries)
    }
}

fn problem(seed: u64, (n, hard, inequalities, equations): Family, rows: Rows) -> Problem {
    let mut random = Random(seed);
    let direction: Vec<f64> = (0..n).map(|_| random.normal()).collect();
    let mut tasks = Vec::new();
    for &count in inequalities {
        let matrix = random.matrix(count, rows, &direction);
        let bounds: Vec<(f64, f64)> = (0..count)
            .map(|_| match (random.normal(), random.unit()) {
                (bound, share) if share < 0.3 => (bound, f64::INFINITY),
                (bound, share) if share < 0.6 => (f64::NEG_INFINITY, bound),
                (bound, share) => (bound, bound + share),
            })
            .collect();
        let (lower, upper): (Vec<f64>, Vec<f64>) = bounds.into_iter().unzip();
        tasks.push(Task::between("bounds", matrix, Vector::from_vec(lower), Vector::from_vec(upper)));
    }
    for &count in equations {
        let matrix = random.matrix(count, Rows::Normal, &direction);
        tasks.push(Task::new("motion", matrix, Vector::from_fn(count, |_, _| random.normal())));
    }
    let limits: Vec<f64> = (0..n).map(|_| 0.2 + random.unit()).collect();
    let lower: Vec<f64> = limits.iter().map(|limit| -limit).collect();
    let wall = |random: &mut Random| {
        let mut coefficients = random.coefficients(rows, &direction);
        coefficients[0] += 0.5;
        Inequality::new("wall", coefficients, random.normal()).expect("finite")
    };
    Problem {
        limits: VelocityBox::new(&lower, &limits).expect("ordered"),
        inequalities: (0..hard).map(|_| wall(&mut random)).collect(),
        method: Method::StrictReversePriority,
        ..Problem::new(TaskStack::new(tasks).expect("of equal width"))
    }
}

fn main() {
    println!(
        "joints, hard rows, tasks, damping: problems, working sets mean and most, last resorts, not certified, mean and longest ms"
    );
    let most_joints = std::env::args().nth(1).map_or(usize::MAX, |joints| joints.parse().expect("a number of joints"));
    let mut rungs = Rungs::default();
    for family in FAMILIES.into_iter().filter(|family| family.0 <= most_joints) {
        for damping in [None, Some(Damping::STANDARD)] {
            let (mut sets, mut most, mut resorts, mut unsure, mut times) = (0, 0, 0, 0, Vec::new());
            for rows in [Rows::Normal, Rows::SmallIntegers, Rows::NearlyParallel, Rows::Sparse] {
                // The largest problems take seconds.
                for seed in 0..if family.0 > 100 { 2 } else { PROBLEMS } {
                    let problem = Problem { damping, ..problem(seed, family, rows) };
                    let (mut resolver, mut answer) = (Resolver::default(), Resolution::default());
                    // The first call allocates.
                    resolver.resolve(&problem, &[], &mut answer).expect("the parts fit");
                    rungs = rungs + resolver.rungs();
                    // The least of three times leaves out what other processes take.
                    let time = |_| {
                        let start = Instant::now();
                        resolver.resolve(&problem, &[], &mut answer).expect("the parts fit");
                        start.elapsed()
                    };
                    times.push((0..3).map(time).min().unwrap_or_default());
                    sets += answer.solver.working_sets;
                    most = most.max(answer.solver.working_sets);
                    resorts += answer.solver.last_resorts;
                    unsure += u32::from(answer.solver.status != Status::Optimal);
                }
            }
            let (n, hard, inequalities, equations) = family;
            let ms = |time: Duration| 1e3 * time.as_secs_f64();
            let (count, mean) = (times.len(), ms(times.iter().sum()) / times.len() as f64);
            let longest = times.iter().copied().max().map_or(0.0, ms);
            let damped = if damping.is_some() { "damped" } else { "exact" };
            let mean_sets = f64::from(sets) / count as f64;
            println!(
                "{n}, {hard}, {inequalities:?} {equations:?}, {damped}: {count}, {mean_sets:.1} {most}, {resorts}, {unsure}, {mean:.3} {longest:.3}"
            );
        }
    }
    println!("\nway to a working set: sets tried, problems answered");
    for rung in Rung::ALL {
        println!("{rung:?}: {}, {}", rungs[rung].tried, rungs[rung].answered);
    }
}
