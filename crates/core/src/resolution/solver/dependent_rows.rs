//! The rows of a level that depend on its pivots: least squares and shortest multipliers (Peters and Wilkinson).
//!
//! With T the pivots' own triangle and E the dependent rows' own coordinates, F T = E. F is bounded, because pivots are the
//! longest rows, so I + F Fᵀ is well conditioned. Section numbers refer to `docs/solver.md`.

use super::factor_row::FactorRow;
use crate::linalg::Row;
use crate::resolution::solution::refill;

/// Workspace for one level.
#[derive(Debug, Default)]
pub struct DependentRows<const N: usize> {
    /// The rows of F.
    combinations: Vec<Row<N>>,
    /// Fᵀ F.
    gram: Vec<Row<N>>,
    /// Cholesky factor of I + F Fᵀ or I + Fᵀ F.
    cholesky: Vec<f64>,
    /// c, then r: one number for each dependent row.
    r: Vec<f64>,
}

impl<const N: usize> DependentRows<N> {
    /// Solves least squares and returns the change of the coordinates; `first` is the level's first one (section 4).
    ///
    /// With c the residuals of the dependent rows after the pivots are met: r = (I + F Fᵀ)⁻¹ c remains, the pivots give up
    /// e = Fᵀ r, and the coordinates change by δ, T δ = e.
    pub fn solve(&mut self, pivots: &mut [FactorRow<N>], dependents: &mut [FactorRow<N>], first: usize) -> Row<N> {
        self.write_combinations(pivots, dependents, first);
        refill(&mut self.r, dependents.iter().map(|row| row.residual));
        let pivot_part = self.solve_normal_equations(first, pivots.len());
        let mut change = Row::ZERO;
        for (c, row) in (first..).zip(pivots) {
            change.0[c] = (pivot_part.0[c] - row.coordinates.dot(&change)) * row.inverse;
            row.residual = -pivot_part.0[c];
        }
        for (row, r) in dependents.iter_mut().zip(&self.r) {
            row.residual = *r;
        }
        change
    }

    /// Makes the multipliers w of a level the shortest ones with the same Aᵀw, and updates their sum g = Σ w_i coordinates[i]
    /// (section 5).
    pub fn shorten_multipliers(
        &mut self,
        (pivots, dependents): (&[FactorRow<N>], &[FactorRow<N>]),
        first: usize,
        w: &mut [f64],
        g: &mut Row<N>,
    ) {
        for row in dependents {
            w[row.index] = 0.0;
        }
        if pivots.is_empty() {
            return;
        }
        self.write_combinations(pivots, dependents, first);
        let mut basic = Row::ZERO;
        (first..).zip(pivots).for_each(|(c, row)| basic.0[c] = w[row.index]);
        refill(&mut self.r, self.combinations.iter().map(|f| f.dot(&basic)));
        let pivot_part = self.solve_normal_equations(first, pivots.len());
        for (c, row) in (first..).zip(pivots) {
            w[row.index] -= pivot_part.0[c];
            g.add_scaled(-pivot_part.0[c], &row.coordinates);
        }
        for (row, &r) in dependents.iter().zip(&self.r) {
            w[row.index] = r;
            g.add_scaled(r, &row.coordinates);
        }
    }

    /// Writes w of a level with Aᵀw = 0 over the level's coordinates: 1 at one dependent row, −F at the pivots.
    pub fn write_left_null_vector(
        (pivots, dependents): (&[FactorRow<N>], &[FactorRow<N>]),
        first: usize,
        dependent: usize,
        w: &mut [f64],
    ) {
        for row in dependents {
            w[row.index] = 0.0;
        }
        let combination = combination_of(&dependents[dependent], pivots, first);
        (first..).zip(pivots).for_each(|(c, row)| w[row.index] = -combination.0[c]);
        w[dependents[dependent].index] = 1.0;
    }

    /// Writes F.
    fn write_combinations(&mut self, pivots: &[FactorRow<N>], dependents: &[FactorRow<N>], first: usize) {
        refill(&mut self.combinations, dependents.iter().map(|row| combination_of(row, pivots, first)));
    }

    /// Replaces c in `r` by r = (I + F Fᵀ)⁻¹ c; returns e = Fᵀ r. `width`: the level's coordinates, from `first` on.
    ///
    /// Where rows outnumber coordinates, e is solved for first: (I + Fᵀ F) e = Fᵀ c, r = c − F e.
    fn solve_normal_equations(&mut self, first: usize, width: usize) -> Row<N> {
        let (f, r, count) = (&self.combinations, &mut self.r, self.combinations.len());
        let mut pivot_part = Row::ZERO;
        if let [single] = f.as_slice() {
            r[0] /= 1.0 + single.dot(single);
        } else if count <= width {
            let product = |i: usize, j: usize| f[i].dot(&f[j]);
            solve_identity_plus(&mut self.cholesky, count, product, r);
        } else {
            f.iter().zip(&*r).for_each(|(f, c)| pivot_part.add_scaled(*c, f));
            let gram = &mut self.gram;
            refill(gram, std::iter::repeat_n(Row::<N>::ZERO, width));
            for f in f {
                for (row, entry) in gram.iter_mut().zip(&f.0[first..]) {
                    row.add_scaled(*entry, f);
                }
            }
            let product = |i: usize, j: usize| gram[i].0[first + j];
            solve_identity_plus(&mut self.cholesky, width, product, &mut pivot_part.0[first..first + width]);
            r.iter_mut().zip(f).for_each(|(r, f)| *r -= f.dot(&pivot_part));
            return pivot_part;
        }
        f.iter().zip(r).for_each(|(f, r)| pivot_part.add_scaled(*r, f));
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

/// Replaces x by (I + G)⁻¹ x for a positive semidefinite matrix G, by Cholesky's factorisation.
fn solve_identity_plus(g: &mut Vec<f64>, count: usize, product: impl Fn(usize, usize) -> f64, x: &mut [f64]) {
    g.resize(count * count, 0.0);
    for i in 0..count {
        for j in 0..=i {
            let known = (0..j).map(|l| g[i * count + l] * g[j * count + l]).sum::<f64>();
            let rest = product(i, j) - known;
            g[i * count + j] = if i == j { (1.0 + rest).sqrt() } else { rest / g[j * count + j] };
        }
    }
    for i in 0..count {
        let known: f64 = (0..i).map(|j| g[i * count + j] * x[j]).sum();
        x[i] = (x[i] - known) / g[i * count + i];
    }
    for i in (0..count).rev() {
        let known: f64 = (i + 1..count).map(|j| g[j * count + i] * x[j]).sum();
        x[i] = (x[i] - known) / g[i * count + i];
    }
}
