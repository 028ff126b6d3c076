//! The linear algebra that is not in nalgebra: padded rows, singular values that are right where they coincide, the smallest
//! eigenvalue of a symmetric matrix, damping.

mod damping;
mod laguerre;
mod row;
mod singular_values;
mod svd;
mod triangle;

pub use damping::DampingFactor;
pub use revprio_problem::{Damping, Matrix, Vector};
pub use row::Row;
pub use singular_values::{SingularValues, reflect_row, smallest_and_product};
pub use svd::Svd;
pub use triangle::{add_outer_square, cholesky, eigenvalues_exceed, smallest_eigenvalue, write_inverse};

use crate::tolerances::TOLERANCES;

/// [`Tolerances::rank`](crate::tolerances::Tolerances::rank): singular values below this fraction of a matrix's Frobenius norm count as zero.
pub const RANK_TOLERANCE: f64 = TOLERANCES.rank;

/// Returns whether all entries are finite numbers.
#[inline]
pub fn all_finite(entries: &[f64]) -> bool {
    // 0 times infinity or NaN is NaN.
    let (chunks, rest) = entries.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for chunk in chunks {
        for lane in 0..4 {
            sums[lane] += 0.0 * chunk[lane];
        }
    }
    rest.iter().all(|entry| entry.is_finite()) && (sums[0] + sums[2]) + (sums[1] + sums[3]) == 0.0
}

/// Returns a·b of two lists of the same length.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    sum_over_pairs(a, b, |a, b| a * b)
}

/// Returns ‖a − b‖² of two lists of the same length.
#[inline]
pub fn distance_square(a: &[f64], b: &[f64]) -> f64 {
    sum_over_pairs(a, b, |a, b| (a - b) * (a - b))
}

/// Returns Σ term(a_i, b_i), four terms at a time.
#[inline]
fn sum_over_pairs(a: &[f64], b: &[f64], term: impl Fn(f64, f64) -> f64) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..4 {
            sums[lane] += term(a[lane], b[lane]);
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| term(*a, *b)).sum();
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// Adds factor · other to the entries.
pub fn add_scaled(entries: &mut [f64], factor: f64, other: &[f64]) {
    entries.iter_mut().zip(other).for_each(|(entry, other)| *entry += factor * other);
}

/// Returns a·x for one row a of a matrix.
#[inline]
pub fn row_times(matrix: &Matrix, row: usize, x: &[f64]) -> f64 {
    // Columns are contiguous.
    let columns = matrix.as_slice().chunks_exact(matrix.nrows());
    columns.zip(x).map(|(column, x)| column[row] * x).sum()
}

/// Writes A x, one entry per row of A.
#[inline]
pub fn write_product(matrix: &Matrix, x: &[f64], product: &mut [f64]) {
    product.fill(0.0);
    for (column, x) in matrix.as_slice().chunks_exact(matrix.nrows()).zip(x) {
        for (sum, entry) in product.iter_mut().zip(column) {
            *sum += entry * x;
        }
    }
}

/// Puts `top` over `bottom`. Both have the same number of columns.
pub fn stack(top: &Matrix, bottom: &Matrix) -> Matrix {
    let mut stacked = Matrix::zeros(top.nrows() + bottom.nrows(), top.ncols());
    stacked.rows_mut(0, top.nrows()).copy_from(top);
    stacked.rows_mut(top.nrows(), bottom.nrows()).copy_from(bottom);
    stacked
}
