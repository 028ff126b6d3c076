//! Singular value decompositions by faer, and what follows from them.

use nalgebra::DMatrixView;
use revprio_problem::{Matrix, Vector};

/// Singular values below this fraction of a matrix's Frobenius norm count as zero.
pub const RANK_TOLERANCE: f64 = 1e-10;

/// Singular values between these fractions of the norm: rounding may have decided a rank.
pub const UNCERTAIN_RANK: std::ops::Range<f64> = 1e-13..1e-6;

/// Error of a projected row along a direction of length one.
pub const PROJECTION_ERROR: f64 = 4e-15;

/// A = U diag(σ) Vᵀ with min(m, n) singular values in descending order.
pub struct Svd {
    /// At least the first min(m, n) left singular vectors, as columns.
    u: Matrix,
    sigma: Vec<f64>,
    /// All right singular vectors, n × n; the last ones belong to singular values of zero.
    v: Matrix,
}

impl Svd {
    /// Decomposes an m × n matrix. The singular values of a matrix that is not finite are NaN, and so are those of one whose
    /// decomposition does not converge.
    pub fn new(a: &Matrix) -> Self {
        let (m, n) = a.shape();
        let count = m.min(n);
        let size = a.amax();
        let unit = if size.is_normal() { size } else { 1.0 };
        let scaled = a / unit;
        let view = faer::MatRef::from_column_major_slice(scaled.as_slice(), m, n);
        // Of a wide matrix all right singular vectors are wanted, and its left ones are few.
        let found = if size.is_finite() && count > 0 {
            if m < n { view.svd().ok() } else { view.thin_svd().ok() }
        } else {
            None
        };
        let Some(found) = found else {
            let sigma = if size.is_finite() && size == 0.0 { 0.0 } else { f64::NAN };
            return Self { u: Matrix::identity(m, count), sigma: vec![sigma; count], v: Matrix::identity(n, n) };
        };
        let (u, s, v) = (found.U(), found.S().column_vector(), found.V());
        Self {
            // A row of zeros takes no part, to the last bit.
            u: Matrix::from_fn(m, count, |i, j| if a.row(i).amax() > 0.0 { u[(i, j)] } else { 0.0 }),
            sigma: (0..count).map(|i| s[i] * unit).collect(),
            v: Matrix::from_fn(n, n, |i, j| v[(i, j)]),
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
    pub fn range(&self, rank: usize) -> DMatrixView<'_, f64> {
        self.u.columns(0, rank)
    }

    /// Returns the first `rank` right singular vectors, n × rank.
    pub fn row_space(&self, rank: usize) -> DMatrixView<'_, f64> {
        self.v.columns(0, rank)
    }

    /// Returns the other right singular vectors, n × (n − rank).
    pub fn null_space(&self, rank: usize) -> DMatrixView<'_, f64> {
        self.v.columns(rank, self.v.ncols() - rank)
    }

    /// Returns the projector onto the first `rank` right singular vectors, n × n.
    pub fn row_projector(&self, rank: usize) -> Matrix {
        let v = self.row_space(rank);
        v * v.transpose()
    }

    /// Returns the damped inverse of the first `rank` singular values, n × m: V diag(σ/(σ² + λ²)) Uᵀ.
    pub fn inverse(&self, rank: usize, lambda: f64) -> Matrix {
        let mut scaled = self.row_space(rank).into_owned();
        for (mut column, &sigma) in scaled.column_iter_mut().zip(&self.sigma) {
            // Without squares, which underflow.
            column /= sigma + lambda * (lambda / sigma);
        }
        scaled * self.range(rank).transpose()
    }

    /// Returns the damped inverse times b (m): the x with the smallest ‖A x − b‖² + λ² ‖x‖².
    pub fn solve(&self, rank: usize, lambda: f64, b: &Vector) -> Vector {
        let mut asked = self.range(rank).tr_mul(b);
        for (part, &sigma) in asked.iter_mut().zip(&self.sigma) {
            *part /= sigma + lambda * (lambda / sigma);
        }
        self.row_space(rank) * asked
    }
}

/// Returns the Frobenius norm, also of entries whose squares underflow or overflow.
pub fn norm(a: &Matrix) -> f64 {
    a.iter().copied().fold(0.0, f64::hypot)
}

/// Puts `top` over `bottom`. Both have the same number of columns.
pub fn stack(top: &Matrix, bottom: &Matrix) -> Matrix {
    let mut stacked = Matrix::zeros(top.nrows() + bottom.nrows(), top.ncols());
    stacked.rows_mut(0, top.nrows()).copy_from(top);
    stacked.rows_mut(top.nrows(), bottom.nrows()).copy_from(bottom);
    stacked
}

/// Puts `top` over `bottom`.
pub fn concatenate(top: &Vector, bottom: &Vector) -> Vector {
    Vector::from_iterator(top.len() + bottom.len(), top.iter().chain(bottom.iter()).copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: usize, columns: usize, seed: usize) -> Matrix {
        Matrix::from_fn(rows, columns, |i, j| ((seed + 7 * i + 3 * j * j) as f64).sin())
    }

    #[test]
    fn decompositions_give_the_matrix_back() {
        for (m, n) in [(1, 1), (1, 7), (3, 7), (7, 7), (7, 3), (9, 2)] {
            let a = matrix(m, n, m + n);
            let svd = Svd::new(&a);
            let count = m.min(n);
            let back = svd.range(count)
                * Matrix::from_diagonal(&Vector::from_row_slice(svd.singular_values()))
                * svd.row_space(count).transpose();
            assert!((back - &a).amax() < 1e-14, "{m} × {n}");
            assert!((a * svd.null_space(count)).amax().max(0.0) < 1e-14);
        }
    }

    #[test]
    fn damped_inverses_solve_the_damped_least_squares_problem() {
        let (a, b, lambda) = (matrix(3, 5, 1), Vector::from_vec(vec![1.0, -2.0, 0.5]), 0.3);
        let x = Svd::new(&a).solve(3, lambda, &b);
        let gradient = a.tr_mul(&(&a * &x - &b)) + lambda * lambda * &x;
        assert!(gradient.amax() < 1e-14);
        assert!((Svd::new(&a).inverse(3, lambda) * b - x).amax() < 1e-14);
    }

    #[test]
    fn zero_and_extreme_matrices_have_singular_values() {
        assert_eq!(Svd::new(&Matrix::zeros(2, 3)).singular_values(), [0.0, 0.0]);
        assert!((Svd::new(&(matrix(2, 3, 5) * 1e300)).smallest() / 1e300).is_finite());
        assert!(Svd::new(&(matrix(2, 3, 5) * 1e-300)).smallest() > 1e-301);
        assert!(Svd::new(&Matrix::from_element(2, 2, f64::INFINITY)).smallest().is_nan());
    }
}
