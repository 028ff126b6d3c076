//! The rows of a level that depend on its pivots: least squares and shortest multipliers (Peters and Wilkinson).
//!
//! With T the pivots' own triangle and E the dependent rows' own coordinates, F T = E. F is bounded, because pivots are the
//! longest rows, so I + F Fᵀ is well conditioned. Section numbers refer to `docs/solver.md`.

use super::factor_row::FactorRow;
use crate::linalg::{Row, cholesky};
use crate::resolution::solution::refill;

/// The dependent rows of one level.
#[derive(Debug, Default)]
pub struct DependentRows<const N: usize> {
    /// First coordinate of the level, and the number of its coordinates.
    first: usize,
    width: usize,
    /// The rows of F.
    combinations: Vec<Row<N>>,
    /// Fᵀ F.
    gram: Vec<Row<N>>,
    /// Cholesky factor of I + F Fᵀ, or of I + Fᵀ F where rows outnumber coordinates.
    cholesky: Vec<f64>,
    /// c, then r: one number for each dependent row.
    r: Vec<f64>,
}

impl<const N: usize> DependentRows<N> {
    /// Writes F and factorises; `first` is the level's first coordinate.
    pub fn factorize(&mut self, pivots: &[FactorRow<N>], dependents: &[FactorRow<N>], first: usize) {
        (self.first, self.width) = (first, pivots.len());
        refill(&mut self.combinations, dependents.iter().map(|row| combination_of(row, pivots, first)));
        let Self { combinations: f, gram, cholesky, width, .. } = self;
        if f.len() <= *width {
            factorize_identity_plus(cholesky, f.len(), |i, j| f[i].dot(&f[j]));
            return;
        }
        refill(gram, std::iter::repeat_n(Row::<N>::ZERO, *width));
        for f in f {
            for (row, entry) in gram.iter_mut().zip(&f.0[first..]) {
                row.add_scaled(*entry, f);
            }
        }
        factorize_identity_plus(cholesky, *width, |i, j| gram[i].0[first + j]);
    }

    /// Solves least squares and returns the change of the coordinates (section 4).
    ///
    /// With c the residuals of the dependent rows after the pivots are met: r = (I + F Fᵀ)⁻¹ c remains, the pivots give up
    /// e = Fᵀ r, and the coordinates change by δ, T δ = e.
    pub fn solve(&mut self, pivots: &mut [FactorRow<N>], dependents: &mut [FactorRow<N>]) -> Row<N> {
        let first = self.first;
        let mut r = std::mem::take(&mut self.r);
        refill(&mut r, dependents.iter().map(|row| row.residual));
        let pivot_part = self.solve_normal_equations(&mut r);
        let mut change = Row::ZERO;
        for (c, row) in (first..).zip(pivots) {
            change.0[c] = (pivot_part.0[c] - row.coordinates.dot(&change)) * row.inverse;
            row.residual = -pivot_part.0[c];
        }
        for (row, r) in dependents.iter_mut().zip(&r) {
            row.residual = *r;
        }
        self.r = r;
        change
    }

    /// Makes the multipliers w of the level the shortest ones with the same Aᵀw, and updates their sum g = Σ w_i coordinates[i]
    /// (section 5). `r` is scratch.
    pub fn shorten_multipliers(
        &self,
        (pivots, dependents): (&[FactorRow<N>], &[FactorRow<N>]),
        w: &mut [f64],
        g: &mut Row<N>,
        r: &mut Vec<f64>,
    ) {
        for row in dependents {
            w[row.index] = 0.0;
        }
        if pivots.is_empty() {
            return;
        }
        let first = self.first;
        let mut basic = Row::ZERO;
        (first..).zip(pivots).for_each(|(c, row)| basic.0[c] = w[row.index]);
        refill(r, self.combinations.iter().map(|f| f.dot(&basic)));
        let pivot_part = self.solve_normal_equations(r);
        for (c, row) in (first..).zip(pivots) {
            w[row.index] -= pivot_part.0[c];
            g.add_scaled(-pivot_part.0[c], &row.coordinates);
        }
        for (row, &r) in dependents.iter().zip(&*r) {
            w[row.index] = r;
            g.add_scaled(r, &row.coordinates);
        }
    }

    /// Writes w of the level with Aᵀw = 0 over the level's coordinates: 1 at one dependent row, −F at the pivots.
    pub fn write_left_null_vector(
        &self,
        (pivots, dependents): (&[FactorRow<N>], &[FactorRow<N>]),
        dependent: usize,
        w: &mut [f64],
    ) {
        for row in dependents {
            w[row.index] = 0.0;
        }
        for (c, row) in (self.first..).zip(pivots) {
            w[row.index] = -self.combinations[dependent].0[c];
        }
        w[dependents[dependent].index] = 1.0;
    }

    /// Replaces c in `r` by r = (I + F Fᵀ)⁻¹ c; returns e = Fᵀ r.
    ///
    /// Where rows outnumber coordinates, e is solved for first: (I + Fᵀ F) e = Fᵀ c, r = c − F e.
    fn solve_normal_equations(&self, r: &mut [f64]) -> Row<N> {
        let Self { combinations: f, cholesky, first, width, .. } = self;
        let mut pivot_part = Row::ZERO;
        if let [single] = f.as_slice() {
            r[0] /= 1.0 + single.dot(single);
            pivot_part = single.scaled(r[0]);
        } else if f.len() <= *width {
            solve_identity_plus(cholesky, f.len(), r);
            f.iter().zip(r).for_each(|(f, r)| pivot_part.add_scaled(*r, f));
        } else {
            f.iter().zip(&*r).for_each(|(f, c)| pivot_part.add_scaled(*c, f));
            solve_identity_plus(cholesky, *width, &mut pivot_part.0[*first..][..*width]);
            r.iter_mut().zip(f).for_each(|(r, f)| *r -= f.dot(&pivot_part));
        }
        pivot_part
    }
}

/// Returns the row of F that belongs to a dependent row.
fn combination_of<const N: usize>(row: &FactorRow<N>, pivots: &[FactorRow<N>], first: usize) -> Row<N> {
    let (mut rest, mut combination) = (row.coordinates, Row::ZERO);
    for (place, pivot) in pivots.iter().enumerate().rev() {
        let factor = rest.0[first + place] * pivot.inverse;
        combination.0[first + place] = factor;
        rest.add_scaled(-factor, &pivot.coordinates);
    }
    combination
}

/// Writes Cholesky's factor of I + G for a positive semidefinite matrix G.
fn factorize_identity_plus(g: &mut Vec<f64>, count: usize, product: impl Fn(usize, usize) -> f64) {
    refill(
        g,
        (0..count * count)
            .map(|at| (at / count, at % count))
            .map(|(i, j)| if i < j { 0.0 } else { product(i, j) + f64::from(u8::from(i == j)) }),
    );
    cholesky(g, count);
}

/// Replaces x by (I + G)⁻¹ x.
fn solve_identity_plus(g: &[f64], count: usize, x: &mut [f64]) {
    for i in 0..count {
        let known: f64 = (0..i).map(|j| g[i * count + j] * x[j]).sum();
        x[i] = (x[i] - known) / g[i * count + i];
    }
    for i in (0..count).rev() {
        let known: f64 = (i + 1..count).map(|j| g[j * count + i] * x[j]).sum();
        x[i] = (x[i] - known) / g[i * count + i];
    }
}
