//! Singular values and vectors by one-sided Jacobi rotations.
//!
//! The decomposition of nalgebra is not used: it returns wrong vectors where singular values coincide.

use super::{Matrix, Vector, dot};
use crate::tolerances::TOLERANCES;

/// Sweeps over all pairs of rows. About five are needed.
const MAX_SWEEPS: usize = 60;

/// A = U diag(σ) Vᵀ with min(m, n) singular values in descending order; each decomposition overwrites the one before.
#[derive(Debug, Clone, Default)]
pub struct Svd {
    /// A row for each singular value: σ times the vector of the longer side, then the vector of the shorter side.
    entries: Vec<f64>,
    /// The rows by descending singular value.
    order: Vec<usize>,
    sigma: Vec<f64>,
    /// The power of two by which the entries are divided, so that no square overflows.
    unit: f64,
    rows: usize,
    columns: usize,
}

impl Svd {
    /// Decomposes a matrix.
    pub fn new(a: &Matrix) -> Self {
        let mut svd = Self::default();
        svd.decompose(a.nrows(), a.ncols(), |i, j| a[(i, j)]);
        svd
    }

    /// Decomposes the m × n matrix with these entries (row, column).
    pub fn decompose(&mut self, m: usize, n: usize, entry: impl Fn(usize, usize) -> f64) {
        (self.rows, self.columns) = (m, n);
        let (shorter, longer, stride) = (m.min(n), m.max(n), m + n);
        self.entries.clear();
        for i in 0..shorter {
            self.entries.extend((0..longer).map(|j| if m > n { entry(j, i) } else { entry(i, j) }));
            self.entries.extend((0..shorter).map(|j| if i == j { 1.0 } else { 0.0 }));
        }
        let entries = self.entries.chunks_exact(stride.max(1)).flat_map(|row| &row[..longer]);
        let size = entries.fold(0.0, |size: f64, entry| size.max(entry.abs()));
        self.unit = if size.is_normal() { size.log2().floor().exp2() } else { 1.0 };
        for row in self.entries.chunks_exact_mut(stride.max(1)) {
            row[..longer].iter_mut().for_each(|entry| *entry /= self.unit);
        }
        orthogonalize(&mut self.entries, stride, longer);
        let Self { entries, order, sigma, unit, .. } = self;
        sigma.clear();
        let length = |row: &[f64]| row[..longer].iter().map(|x| x * x).sum::<f64>().sqrt();
        sigma.extend(entries.chunks_exact(stride.max(1)).map(|row| length(row) * *unit));
        order.clear();
        order.extend(0..shorter);
        order.sort_unstable_by(|&a, &b| sigma[b].total_cmp(&sigma[a]));
        sigma.sort_unstable_by(|a, b| b.total_cmp(a));
    }

    /// Returns the number of singular values, min(m, n).
    pub fn count(&self) -> usize {
        self.sigma.len()
    }

    /// Returns the singular value of this place, 0 = largest.
    pub fn sigma(&self, place: usize) -> f64 {
        self.sigma[place]
    }

    /// Returns the singular values, largest first.
    pub fn singular_values(&self) -> &[f64] {
        &self.sigma
    }

    /// Returns the smallest singular value; 0 for an empty matrix.
    pub fn smallest(&self) -> f64 {
        self.sigma.last().copied().unwrap_or(0.0)
    }

    /// Returns the number of singular values above `tolerance`.
    pub fn rank(&self, tolerance: f64) -> usize {
        self.sigma.iter().take_while(|&&sigma| sigma > tolerance).count()
    }

    /// Returns the left singular vector of a singular value that is not zero, m.
    pub fn left(&self, place: usize) -> impl Iterator<Item = f64> {
        self.vector(place, self.rows > self.columns)
    }

    /// Returns the right singular vector of a singular value that is not zero, n.
    pub fn right(&self, place: usize) -> impl Iterator<Item = f64> {
        self.vector(place, self.rows <= self.columns)
    }

    fn vector(&self, place: usize, is_longer: bool) -> impl Iterator<Item = f64> {
        let (longer, stride) = (self.rows.max(self.columns), self.rows + self.columns);
        let row = &self.entries[self.order[place] * stride..][..stride];
        let length = self.sigma(place) / self.unit;
        let (own, length) = if is_longer { (&row[..longer], length) } else { (&row[longer..], 1.0) };
        own.iter().map(move |entry| entry / length)
    }

    /// Returns the first `rank` left singular vectors, m × rank.
    pub fn range(&self, rank: usize) -> Matrix {
        Matrix::from_iterator(self.rows, rank, (0..rank).flat_map(|place| self.left(place)))
    }

    /// Returns the projector onto the first `rank` right singular vectors, n × n.
    pub fn row_projector(&self, rank: usize) -> Matrix {
        let vectors = self.first_right(rank);
        &vectors * vectors.transpose()
    }

    /// Returns Aᵀ(A Aᵀ + λ² I)⁻¹ from the `rank` largest singular values, n × m; the pseudo-inverse for λ = 0.
    pub fn inverse(&self, rank: usize, lambda: f64) -> Matrix {
        let mut scaled = self.first_right(rank);
        for (place, mut column) in scaled.column_iter_mut().enumerate() {
            let sigma = self.sigma(place);
            column *= sigma / (sigma * sigma + lambda * lambda);
        }
        scaled * self.range(rank).transpose()
    }

    /// Returns Aᵀ(A Aᵀ + λ² I)⁻¹ b from the `rank` largest singular values.
    pub fn solve(&self, rank: usize, lambda: f64, b: &Vector) -> Vector {
        self.inverse(rank, lambda) * b
    }

    /// Returns the first `rank` right singular vectors, n × rank.
    fn first_right(&self, rank: usize) -> Matrix {
        Matrix::from_iterator(self.columns, rank, (0..rank).flat_map(|place| self.right(place)))
    }
}

/// Rotates pairs of rows of `stride` entries until their first `columns` entries are orthogonal to each other.
fn orthogonalize(entries: &mut [f64], stride: usize, columns: usize) {
    let count = entries.len() / stride.max(1);
    for _ in 0..MAX_SWEEPS {
        let mut rotated = false;
        for q in 1..count {
            let (above, below) = entries.split_at_mut(q * stride);
            for row in above.chunks_exact_mut(stride) {
                rotated |= rotate(row, &mut below[..stride], columns);
            }
        }
        if !rotated {
            return;
        }
    }
}

/// Makes two rows orthogonal; returns whether they were not.
fn rotate(x: &mut [f64], y: &mut [f64], columns: usize) -> bool {
    let (x_own, y_own) = (&x[..columns], &y[..columns]);
    let (a, b, c) = (dot(x_own, x_own), dot(y_own, y_own), dot(x_own, y_own));
    if c.abs() <= TOLERANCES.orthogonal * (a * b).sqrt() || c == 0.0 {
        return false;
    }
    let zeta = (b - a) / (2.0 * c);
    let tangent = 1.0_f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    let sine = cosine * tangent;
    for (x, y) in x.iter_mut().zip(y) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
    true
}

#[cfg(test)]
mod tests;
