//! Singular values and vectors by one-sided Jacobi rotations.
//!
//! The decomposition of nalgebra is not used: it returns wrong vectors where singular values coincide.

use super::{Matrix, Vector, dot};
use crate::tolerances::TOLERANCES;

/// Sweeps over all pairs of rows. About five are needed.
const MAX_SWEEPS: usize = 60;

/// A = U diag(σ) Vᵀ with min(m, n) singular values in descending order.
#[derive(Debug, Clone, PartialEq)]
pub struct Svd {
    /// m × min(m, n).
    u: Matrix,
    sigma: Vec<f64>,
    /// min(m, n) × n.
    v_transposed: Matrix,
}

impl Svd {
    /// Decomposes an m × n matrix.
    pub fn new(a: &Matrix) -> Self {
        if a.nrows() > a.ncols() {
            let Self { u, sigma, v_transposed } = Self::new(&a.transpose());
            return Self { u: v_transposed.transpose(), sigma, v_transposed: u.transpose() };
        }
        let (m, n) = a.shape();
        // Each row of A is followed by the row of the rotations that it has undergone.
        let stride = n + m;
        let size = a.amax();
        let unit = if size.is_normal() { 1.0 / size } else { 1.0 };
        let identity = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let mut entries: Vec<f64> = (0..m)
            .flat_map(|i| (0..stride).map(move |j| if j < n { a[(i, j)] * unit } else { identity(i, j - n) }))
            .collect();
        orthogonalize(&mut entries, stride, n);
        let length = |row: &[f64]| dot(&row[..n], &row[..n]).sqrt();
        let mut rows: Vec<&[f64]> = entries.chunks_exact(stride.max(1)).collect();
        rows.sort_by(|a, b| length(b).total_cmp(&length(a)));
        let sigma: Vec<f64> = rows.iter().map(|row| length(row)).collect();
        let direction = |i: usize, j: usize| if sigma[i] > 0.0 { rows[i][j] / sigma[i] } else { 0.0 };
        Self {
            u: Matrix::from_fn(m, m, |i, j| rows[j][n + i]),
            v_transposed: Matrix::from_fn(m, n, direction),
            sigma: sigma.iter().map(|sigma| sigma / unit).collect(),
        }
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

    /// Returns the first `rank` left singular vectors, m × rank.
    pub fn range(&self, rank: usize) -> Matrix {
        self.u.columns(0, rank).into_owned()
    }

    /// Returns the projector onto the first `rank` right singular vectors, n × n.
    pub fn row_projector(&self, rank: usize) -> Matrix {
        let rows = self.v_transposed.rows(0, rank);
        rows.tr_mul(&rows)
    }

    /// Returns Aᵀ(A Aᵀ + λ² I)⁻¹ from the `rank` largest singular values, n × m; the pseudo-inverse for λ = 0.
    pub fn inverse(&self, rank: usize, lambda: f64) -> Matrix {
        let gain = |i: usize| self.sigma[i] / (self.sigma[i] * self.sigma[i] + lambda * lambda);
        let scaled = Matrix::from_fn(rank, self.u.nrows(), |i, j| gain(i) * self.u[(j, i)]);
        self.v_transposed.rows(0, rank).tr_mul(&scaled)
    }

    /// Returns Aᵀ(A Aᵀ + λ² I)⁻¹ b from the `rank` largest singular values.
    pub fn solve(&self, rank: usize, lambda: f64, b: &Vector) -> Vector {
        self.inverse(rank, lambda) * b
    }
}

/// Rotates pairs of rows of `stride` entries until their first `columns` entries are orthogonal to each other.
pub(super) fn orthogonalize(entries: &mut [f64], stride: usize, columns: usize) {
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
    let tangent = 1.0_f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = cosine * tangent;
    for (x, y) in x.iter_mut().zip(y) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
    true
}
