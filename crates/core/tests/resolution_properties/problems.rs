//! Random and adversarial problems, every one a function of its seed.

use std::f64::consts::PI;

use revprio_core::constraint::Inequality;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{Method, Problem};
use revprio_core::task::{Task, TaskStack};
use revprio_robot::built_in;
use revprio_robot::kinematics::Configuration;

/// Reproducible random numbers (SplitMix64).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// 0 … n − 1.
    pub fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.bits() % n as u64).unwrap()
    }

    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// −1 … 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// −2, −1, 0, 1 or 2.
    pub fn digit(&mut self) -> f64 {
        self.below(5) as f64 - 2.0
    }

    /// A power of ten, 10^−maximum … 10^maximum.
    pub fn decade(&mut self, maximum: i32) -> f64 {
        10_f64.powi(self.pick(&(-maximum..=maximum).collect::<Vec<_>>()))
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }
}

/// The difficulty of a family of problems.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Family {
    /// Maximum number of joints, at most 8.
    pub joints: usize,
    /// Relative distances of nearly dependent rows from dependence; empty: rows are independent or exactly dependent.
    pub nearness: &'static [f64],
    /// Maximum power of ten of the scale of tasks and velocities.
    pub decades: i32,
}

pub const SMALL: Family = Family { joints: 4, nearness: &[0.1, 1e-2, 1e-3], decades: 1 };
pub const WIDE: Family = Family { joints: 8, nearness: &[0.1, 1e-2, 1e-3], decades: 2 };
pub const EXTREME: Family = Family { joints: 8, nearness: &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6], decades: 6 };

/// Returns a random problem without damping, with the solver `auto`.
pub fn problem(random: &mut Random, family: Family, method: Method) -> Problem {
    let n = if family.joints >= 7 && random.one_in(3) { 7 } else { 1 + random.below(family.joints) };
    let integers = random.one_in(3);
    let limits = limits(random, n, family, integers);
    let tasks = tasks(random, n, family, integers, &limits);
    let null_space_velocity = random.one_in(4).then(|| Vector::from_fn(n, |_, _| entry(random, integers)));
    Problem { limits, method, null_space_velocity, ..Problem::new(tasks) }
}

fn entry(random: &mut Random, integers: bool) -> f64 {
    if integers { random.digit() } else { random.unit() }
}

fn tasks(random: &mut Random, n: usize, family: Family, integers: bool, limits: &VelocityBox) -> TaskStack {
    // More tasks than an arm needs.
    let max_tasks = if family.joints > 4 && random.one_in(4) { 8 } else { 5 };
    let count = 1 + random.below(max_tasks);
    let sawyer = (n == 7 && !integers && !random.one_in(4)).then(|| sawyer_jacobian(random));
    let target = corner(random, limits);
    let mut rows: Vec<Vector> = Vec::new();
    let mut tasks = Vec::new();
    for k in 0..count {
        let m = 1 + if random.one_in(6) { random.below(n + 3) } else { random.below(3) };
        let scale = if random.one_in(4) { random.decade(family.decades / 2) } else { 1.0 };
        let mut jacobian = Matrix::zeros(m, n);
        for i in 0..m {
            let new = row(random, n, &rows, family, integers, sawyer.as_ref());
            jacobian.set_row(i, &(new.transpose() * scale));
            rows.push(new);
        }
        let velocity = velocity(random, &jacobian, &target, integers, family);
        tasks.push(Task::new(format!("task {}", k + 1), jacobian, velocity));
    }
    TaskStack::new(tasks).unwrap()
}

fn row(
    random: &mut Random,
    n: usize,
    before: &[Vector],
    family: Family,
    integers: bool,
    sawyer: Option<&Matrix>,
) -> Vector {
    let fresh = |random: &mut Random| match sawyer {
        Some(jacobian) => jacobian.row(random.below(6)).transpose(),
        None => Vector::from_fn(n, |_, _| entry(random, integers)),
    };
    if before.is_empty() {
        return fresh(random);
    }
    let earlier = &before[random.below(before.len())];
    match random.below(14) {
        0 => earlier * random.pick(&[1.0, -1.0, 2.0, -0.5, 3.0]),
        1 => earlier + &before[random.below(before.len())],
        2 if !family.nearness.is_empty() => {
            let epsilon = random.pick(family.nearness);
            earlier + Vector::from_fn(n, |_, _| entry(random, integers)) * epsilon
        }
        3 => Vector::zeros(n),
        4 => {
            let mut unit = Vector::zeros(n);
            unit[random.below(n)] = 1.0;
            unit
        }
        _ => fresh(random),
    }
}

/// Returns a corner of the box, or another point of the box for some joints and where a bound is infinite.
fn corner(random: &mut Random, limits: &VelocityBox) -> Vector {
    Vector::from_fn(limits.joint_count(), |i, _| {
        let bound = if random.one_in(2) { limits.lower()[i] } else { limits.upper()[i] };
        if bound.is_finite() && !random.one_in(5) {
            bound
        } else {
            limits.lower()[i].max(random.unit()).min(limits.upper()[i])
        }
    })
}

fn velocity(random: &mut Random, jacobian: &Matrix, target: &Vector, integers: bool, family: Family) -> Vector {
    match random.below(6) {
        0 => jacobian * target,
        1 => jacobian * target * 2.0,
        2 if !integers => {
            let scale = random.decade(family.decades);
            Vector::from_fn(jacobian.nrows(), |_, _| random.unit() * scale)
        }
        3 => Vector::zeros(jacobian.nrows()),
        _ => Vector::from_fn(jacobian.nrows(), |_, _| entry(random, integers)),
    }
}

fn limits(random: &mut Random, n: usize, family: Family, integers: bool) -> VelocityBox {
    let style = random.below(6);
    let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]);
    for i in 0..n {
        let size = match (style, integers) {
            (0, _) => random.decade(family.decades),
            (1, _) => 100.0,
            (_, true) => 1.0,
            _ => 0.1 + random.unit().abs(),
        };
        (lower[i], upper[i]) = match (style, random.below(12)) {
            (2, _) | (_, 0) => continue,
            (_, 1) => (-size, f64::INFINITY),
            (_, 2) => (f64::NEG_INFINITY, size),
            (_, 3) => (0.5 * size, size),
            (_, 4) => (-size, -0.25 * size),
            (_, 5) => (0.5 * size, 0.5 * size),
            (_, 6) => (0.0, 0.0),
            (_, 7) => (0.0, size),
            _ => (-size, size),
        };
    }
    VelocityBox::new(&lower, &upper).unwrap()
}

/// Returns the Jacobian (6 × 7) of the paper's arm at a posture that is random, singular, or made of multiples of π/6.
pub fn sawyer_jacobian(random: &mut Random) -> Matrix {
    const SINGULAR: [f64; 7] = [0.521, 1.867, 0.793, -0.671, 0.707, -2.336, -0.273];
    let step = PI / 6.0;
    let posture: Vec<f64> = match random.below(4) {
        0 => (0..7).map(|_| step * (random.below(13) as f64 - 6.0)).collect(),
        1 => SINGULAR.to_vec(),
        2 => SINGULAR.iter().map(|q| q + 0.01 * random.unit()).collect(),
        _ => (0..7).map(|_| 3.0 * random.unit()).collect(),
    };
    let jacobian = Configuration::new(&built_in()[0], &posture).unwrap().jacobian().clone();
    Matrix::from_fn(6, 7, |i, j| jacobian[(i, j)])
}

/// Returns the standard damping or a random one.
pub fn damping(random: &mut Random) -> Damping {
    if random.one_in(2) {
        Damping::STANDARD
    } else {
        Damping::new(0.5 * random.unit().abs() + 0.01, random.unit().abs()).unwrap()
    }
}

/// Returns one to three inequalities. Some forbid rest, and some contradict each other.
pub fn inequalities(random: &mut Random, n: usize) -> Vec<Inequality> {
    let mut rows: Vec<Vector> = Vec::new();
    for _ in 0..=random.below(3) {
        let row = match rows.last() {
            Some(last) if random.one_in(4) => -last,
            _ => Vector::from_fn(n, |_, _| random.unit()) * random.decade(2),
        };
        rows.push(row);
    }
    let bound = |random: &mut Random, row: &Vector| row.norm() * random.pick(&[-0.3, 0.0, 0.1, 0.5, 2.0]);
    rows.into_iter()
        .enumerate()
        .map(|(i, row)| Inequality::new(i.to_string(), row.as_slice().to_vec(), bound(random, &row)).unwrap())
        .collect()
}

/// Returns the problem with the tasks that `choose` selects scaled.
pub fn scaled(problem: &Problem, choose: impl Fn(usize) -> bool) -> Problem {
    let task = |(k, task): (usize, &Task)| Task { scaled: choose(k), ..task.clone() };
    let tasks = TaskStack::new(problem.tasks.tasks().iter().enumerate().map(task).collect()).unwrap();
    Problem { tasks, ..problem.clone() }
}

/// Returns the joint speed that the problem requests, the reference for errors of velocities.
pub fn speed(problem: &Problem) -> f64 {
    let tasks = problem.tasks.tasks().iter().filter(|task| task.jacobian.norm() > 0.0);
    let zeta = problem.null_space_velocity.iter().map(Vector::norm);
    tasks.map(|task| task.lower.norm() / task.jacobian.norm()).chain(zeta).fold(0.0, f64::max)
}
