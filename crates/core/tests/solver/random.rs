//! Reproducible random hierarchies.

use revprio_core::resolution::{ActiveSet, Bound, Side};

use std::f64::consts::TAU;

use crate::hierarchy::{Hierarchy, Row};

/// Reproducible random numbers (SplitMix64).
pub struct Random(u64);

/// What the entries of a random hierarchy are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Entries {
    /// Normally distributed numbers.
    Normal,
    /// −2, −1, 0, 1 and 2: optima in corners, and ties.
    SmallIntegers,
}

/// The sizes of random hierarchies.
#[derive(Debug, Clone, Copy)]
pub struct Family {
    /// Smallest and largest number of joints.
    pub joints: [usize; 2],
    /// Largest number of levels.
    pub levels: usize,
    /// Largest number of rows of a level.
    pub rows: usize,
    /// Largest number of inequality rows.
    pub inequalities: usize,
}

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
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

    /// 0 … 1, without 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normally distributed (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (TAU * self.unit()).cos()
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    pub fn entry(&mut self, entries: Entries) -> f64 {
        match entries {
            Entries::Normal => self.normal(),
            Entries::SmallIntegers => self.below(5) as f64 - 2.0,
        }
    }
}

/// Returns a random hierarchy: pinned joints, infinite bounds, zero rows, and rows that depend on earlier ones.
pub fn hierarchy(random: &mut Random, family: Family, entries: Entries) -> Hierarchy {
    let [fewest, most] = family.joints;
    let n = fewest + random.below(most - fewest + 1);
    // Narrow limits are active for most joints, wide ones around zero for few.
    let width = random.pick(&[1.0, 2.0, 5.0, 20.0]);
    let around_zero = !random.one_in(4);
    let (lower, upper) = (0..n).map(|_| joint_limits(random, entries, width, around_zero)).unzip();
    let reference = (0..n).map(|_| if random.one_in(2) { 0.0 } else { random.entry(entries) }).collect();
    let mut known: Vec<Vec<f64>> = Vec::new();
    let mut inequalities = 0;
    let mut levels = Vec::new();
    for _ in 0..=random.below(family.levels) {
        let mut rows = Vec::new();
        // A power of two changes no digit.
        let unit = if random.one_in(3) { random.pick(&[1.0 / 1024.0, 1.0 / 16.0, 16.0, 1024.0]) } else { 1.0 };
        for _ in 0..=random.below(family.rows) {
            let coefficients = coefficients(random, entries, n, &known);
            known.push(coefficients.clone());
            let is_inequality = inequalities < family.inequalities && random.one_in(3);
            inequalities += usize::from(is_inequality);
            let (lower, upper) = if is_inequality { row_bounds(random, entries) } else { velocity(random, entries) };
            let coefficients = coefficients.iter().map(|a| unit * a).collect();
            rows.push(Row { coefficients, lower: unit * lower, upper: unit * upper });
        }
        levels.push(rows);
    }
    Hierarchy { lower, upper, reference, levels }
}

fn joint_limits(random: &mut Random, entries: Entries, width: f64, around_zero: bool) -> (f64, f64) {
    let (mut a, mut b) = (width * random.entry(entries), width * random.entry(entries));
    if around_zero {
        (a, b) = (-a.abs(), b.abs());
    }
    match random.below(12) {
        0 => (a, a),
        1 => (f64::NEG_INFINITY, a),
        2 => (a, f64::INFINITY),
        _ => (a.min(b), a.max(b)),
    }
}

fn row_bounds(random: &mut Random, entries: Entries) -> (f64, f64) {
    let (a, b) = (random.entry(entries), random.entry(entries));
    match random.below(10) {
        0..3 => (f64::NEG_INFINITY, a),
        3..6 => (a, f64::INFINITY),
        6 => (f64::NEG_INFINITY, f64::INFINITY),
        _ => (a.min(b), a.max(b)),
    }
}

fn velocity(random: &mut Random, entries: Entries) -> (f64, f64) {
    let velocity = if random.one_in(5) { 0.0 } else { random.entry(entries) };
    (velocity, velocity)
}

fn coefficients(random: &mut Random, entries: Entries, n: usize, known: &[Vec<f64>]) -> Vec<f64> {
    match random.below(12) {
        0 => vec![0.0; n],
        1..4 if !known.is_empty() => {
            let (first, second) = (&known[random.below(known.len())], &known[random.below(known.len())]);
            let (s, t) = (random.entry(entries), random.entry(entries));
            first.iter().zip(second).map(|(a, b)| s * a + t * b).collect()
        }
        _ => (0..n).map(|_| if random.one_in(4) { 0.0 } else { random.entry(entries) }).collect(),
    }
}

/// Returns a random working set. It may hold joints at infinite bounds and rows that are equations.
pub fn any_set(random: &mut Random, hierarchy: &Hierarchy) -> ActiveSet {
    let side = |random: &mut Random| random.pick(&[None, Some(Side::Lower), Some(Side::Upper)]);
    hierarchy.bound_ids().filter_map(|id| Some(Bound { id, side: side(random)? })).collect()
}
