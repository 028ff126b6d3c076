//! Random problems with random working sets, and the dense matrices of their levels, for tests of the parts of the solver.
#![allow(non_snake_case)]

use super::factorization::Factorization;
use super::problem_rows::ProblemRows;
use crate::linalg::{Matrix, RANK_TOLERANCE, Svd, Vector};
use crate::resolution::Side;
use crate::resolution::hierarchy::{Demand, Hierarchy};
use crate::resolution::solution::WorkingSet;

/// The width of rows.
pub const WIDTH: usize = 8;

/// Returns reproducible numbers between −1 and 1 (SplitMix64).
pub fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Returns 0 … count − 1 from a number between −1 and 1.
pub fn below(number: f64, count: usize) -> usize {
    (1..count).filter(|&i| f64::midpoint(number, 1.0) * count as f64 >= i as f64).count()
}

/// A working set of a problem, factorised and solved.
pub struct RandomSet {
    hierarchy: Hierarchy,
    pub set: WorkingSet,
    pub solved: Factorization<WIDTH>,
}

impl RandomSet {
    /// Makes 3 to 7 unknowns, some at a bound or pinned, and 1 to 3 levels. A third of the rows depend on earlier ones, and
    /// half of the inequality rows are active.
    pub fn new(seed: u64) -> Self {
        let mut number = numbers(seed);
        let mut below = |count: usize| below(number(), count);
        let (n, level_count) = (3 + below(5), 1 + below(3));
        let rows_of: Vec<usize> = (0..level_count).map(|_| 1 + below(4)).collect();
        let mut number = numbers(seed + 1_000_000);
        let mut hierarchy = Hierarchy::default();
        hierarchy.clear(&(0..n).map(|_| number()).collect::<Vec<_>>());
        hierarchy.set_width(WIDTH);
        let mut set = WorkingSet::default();
        set.clear(n, 0);
        for (j, active) in set.unknowns.iter_mut().enumerate() {
            let (a, b) = (number(), number());
            (hierarchy.lower[j], hierarchy.upper[j]) = (a.min(b), a.max(b));
            *active = side(number());
            if number() > 0.8 {
                hierarchy.upper[j] = hierarchy.lower[j];
                *active = None;
            }
        }
        let mut known: Vec<Vec<f64>> = Vec::new();
        for count in rows_of {
            let unit = if number() > 0.3 { 16.0 } else { 1.0 };
            for _ in 0..count {
                let row: Vec<f64> = if known.len() > 1 && number() > 0.3 {
                    let (last, other) = (&known[known.len() - 1], &known[known.len() / 2]);
                    let (s, t) = (number(), number());
                    last.iter().zip(other).map(|(a, b)| s * a + t * b).collect()
                } else {
                    (0..n).map(|_| unit * number()).collect()
                };
                let (a, b) = (unit * number(), unit * number());
                let (lower, upper) = if number() > 0.0 { (a, a) } else { (a.min(b), a.max(b)) };
                set.rows.push(if lower == upper { None } else { side(number()) });
                hierarchy.push_row(row.iter().copied(), Demand::between(lower, upper, None));
                known.push(row);
            }
            hierarchy.end_level();
        }
        Self::of(hierarchy, set)
    }

    /// Factorises a problem whose rows have [`WIDTH`] entries.
    pub fn of(hierarchy: Hierarchy, set: WorkingSet) -> Self {
        let mut solved = Factorization::default();
        solved.rank_tolerance = RANK_TOLERANCE;
        solved.solve(&ProblemRows::new(&hierarchy), &set);
        Self { hierarchy, set, solved }
    }

    /// Returns the data of the problem.
    pub fn hierarchy(&self) -> &Hierarchy {
        &self.hierarchy
    }

    /// Returns the problem.
    pub fn problem(&self) -> ProblemRows<'_, WIDTH> {
        ProblemRows::new(&self.hierarchy)
    }

    /// Returns the active rows of a level.
    pub fn active(&self, level: usize) -> Vec<usize> {
        let level = self.problem().levels[level];
        (level.start..level.end).filter(|&row| self.problem().is_active(&self.set, row)).collect()
    }

    /// Returns these rows over all unknowns.
    pub fn matrix(&self, rows: &[usize]) -> Matrix {
        Matrix::from_fn(rows.len(), self.problem().unknowns, |i, j| self.problem().coefficients[rows[i]][j])
    }

    /// Returns for each level, and for the last objective, the projector onto what the levels above leave free.
    pub fn projectors(&self) -> Vec<Matrix> {
        let n = self.problem().unknowns;
        let mut N = Matrix::from_fn(n, n, |i, j| if i == j { self.solved.is_free.0[i] } else { 0.0 });
        let mut all = vec![N.clone()];
        for level in 0..self.problem().levels.len() {
            let A = self.matrix(&self.active(level));
            let svd = Svd::new(&(&A * &N));
            N -= svd.row_projector(svd.rank(1e-9 * A.norm()));
            all.push(N.clone());
        }
        all
    }

    /// Returns the lexicographic least-squares point by pseudo-inverses.
    pub fn point(&self) -> Vector {
        let n = self.problem().unknowns;
        let mut x = Vector::from_column_slice(&self.solved.base.0[..n]);
        let projectors = self.projectors();
        for (level, open) in projectors[..projectors.len() - 1].iter().enumerate() {
            let rows = self.active(level);
            let b = Vector::from_iterator(rows.len(), rows.iter().map(|&row| self.problem().target(&self.set, row)));
            let A = self.matrix(&rows);
            let svd = Svd::new(&(&A * open));
            x += svd.solve(svd.rank(1e-9 * A.norm()), 0.0, &(b - A * &x));
        }
        let reference = Vector::from_column_slice(&self.problem().reference.0[..n]);
        &x + &projectors[projectors.len() - 1] * reference
    }
}

fn side(number: f64) -> Option<Side> {
    match number {
        _ if number > 0.6 => Some(Side::Upper),
        _ if number < -0.6 => Some(Side::Lower),
        _ => None,
    }
}
