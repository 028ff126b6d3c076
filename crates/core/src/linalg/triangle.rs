//! The inverse of a lower triangle; the Cholesky factor and the smallest eigenvalue of a symmetric matrix.

use super::laguerre::outermost_root;
use super::{Row, add_scaled, dot};

/// Returns the smallest eigenvalue of a positive semidefinite matrix M of this size, exact to the rounding of its trace t. M is
/// overwritten.
///
/// It is t (1 − x) for the largest eigenvalue x of I − M/t.
pub fn smallest_eigenvalue(matrix: &mut [f64], size: usize, scratch: &mut Vec<f64>) -> f64 {
    let trace: f64 = matrix.iter().step_by(size + 1).sum();
    if !(trace.is_normal() && size > 1) {
        return trace;
    }
    for entry in &mut *matrix {
        *entry /= trace;
    }
    scratch.clear();
    scratch.resize(3 * size, 0.0);
    let (diagonal, rest) = scratch.split_at_mut(size);
    let (off_square, w) = rest.split_at_mut(size);
    for k in (0..size).rev() {
        let (before, row) = matrix.split_at_mut(k * size);
        diagonal[k] = 1.0 - row[k];
        if k > 0 {
            off_square[k - 1] = reduce(before, size, &mut row[..k], w);
        }
    }
    trace * (1.0 - largest_eigenvalue(diagonal, off_square)).max(0.0)
}

/// Reflects the first k rows and columns of a symmetric matrix so that of the next row, whose first k entries are `v`, one entry
/// before the diagonal is left; returns its square. `w` is scratch.
fn reduce(matrix: &mut [f64], stride: usize, v: &mut [f64], w: &mut [f64]) -> f64 {
    let k = v.len();
    let (square, head) = (dot(v, v), v[k - 1]);
    if square == 0.0 || k == 1 {
        return square;
    }
    let (length, w) = (square.sqrt(), &mut w[..k]);
    v[k - 1] += length.copysign(head);
    let gain = 1.0 / (length * (length + head.abs()));
    // p = g M v, w = p − (g/2)(pᵀv) v, M ← M − v wᵀ − w vᵀ.
    for (row, w) in matrix.chunks_exact(stride).zip(&mut *w) {
        *w = gain * dot(&row[..k], v);
    }
    let half = 0.5 * gain * dot(w, v);
    w.iter_mut().zip(&*v).for_each(|(w, v)| *w -= half * v);
    for (i, row) in matrix.chunks_exact_mut(stride).enumerate() {
        let (v_i, w_i) = (v[i], w[i]);
        for (entry, (v, w)) in row.iter_mut().zip(v.iter().zip(&*w)) {
            *entry -= v_i * w + w_i * v;
        }
    }
    square
}

/// Factorises M = L Lᵀ in place, in the lower triangle; returns whether M is positive definite.
pub fn cholesky(matrix: &mut [f64], size: usize) -> bool {
    for i in 0..size {
        let (above, row) = matrix.split_at_mut(i * size);
        for (j, other) in above.chunks_exact(size).enumerate() {
            row[j] = (row[j] - dot(&row[..j], &other[..j])) / other[j];
        }
        let rest = row[i] - dot(&row[..i], &row[..i]);
        if !(rest > 0.0) {
            return false;
        }
        row[i] = rest.sqrt();
    }
    true
}

/// Returns whether all eigenvalues of a symmetric matrix certainly exceed `bound`, but for the rounding of its entries. Overwrites the matrix.
pub fn eigenvalues_exceed(matrix: &mut [f64], size: usize, bound: f64) -> bool {
    matrix.iter_mut().step_by(size + 1).for_each(|entry| *entry -= bound);
    cholesky(matrix, size)
}

/// Adds a aᵀ for a row a to a square matrix.
pub fn add_outer_square(matrix: &mut [f64], row: &[f64]) {
    for (sums, entry) in matrix.chunks_exact_mut(row.len()).zip(row) {
        add_scaled(sums, *entry, row);
    }
}

/// Writes the rows of L⁻¹ for the lower triangle L with these rows and reciprocal diagonal entries; returns ‖L⁻¹‖_F ≥ 1/σ_min.
pub fn write_inverse<'a, const N: usize>(
    rows: impl Iterator<Item = (&'a Row<N>, f64)>,
    inverse: &mut Vec<Row<N>>,
) -> f64 {
    inverse.clear();
    let mut square = 0.0;
    for (i, (row, reciprocal)) in rows.enumerate() {
        let mut inverse_row = Row::ZERO;
        for (j, (above, entry)) in inverse.iter().zip(&row.0).enumerate() {
            inverse_row.add_scaled_before(j + 1, -reciprocal * entry, above);
        }
        inverse_row.0[i] = reciprocal;
        square += inverse_row.dot(&inverse_row);
        inverse.push(inverse_row);
    }
    square.sqrt()
}

/// Returns the largest eigenvalue of a positive semidefinite tridiagonal matrix of a size about 1, to rounding.
fn largest_eigenvalue(diagonal: &[f64], off_square: &[f64]) -> f64 {
    let interval = (upper_bound(diagonal, off_square), 0.0);
    outermost_root(diagonal.len(), interval, |x| log_derivatives(diagonal, off_square, x))
}

/// Returns Σ 1/(x − λ_i) and Σ 1/(x − λ_i)² over the eigenvalues; `None` where x does not exceed all of them.
///
/// They are derivatives of the sum of the logarithms of the pivots of x I − T. Pivots are exact for a matrix that differs from T
/// by rounding, however close eigenvalues are; the characteristic polynomial is not.
fn log_derivatives(diagonal: &[f64], off_square: &[f64], x: f64) -> Option<(f64, f64)> {
    let (mut g, mut h) = (0.0, 0.0);
    // e²/q, its derivative, and half its second derivative, for the pivot q before.
    let (mut carry, mut slope, mut curvature) = (0.0, 0.0, 0.0);
    for (a, off) in diagonal.iter().zip(off_square) {
        let q = x - a - carry;
        if !(q > 0.0) {
            return None;
        }
        let reciprocal = 1.0 / q;
        // q'/q and q''/(2 q).
        let (first, second) = ((1.0 - slope) * reciprocal, -curvature * reciprocal);
        g += first;
        h += first * first - 2.0 * second;
        carry = off * reciprocal;
        slope = -carry * first;
        curvature = carry * (first * first - second);
    }
    Some((g, h))
}

/// Returns the least of Gershgorin's bound, the trace and the norm.
fn upper_bound(diagonal: &[f64], off_square: &[f64]) -> f64 {
    let (mut before, mut gershgorin) = (0.0, 0.0_f64);
    let (mut trace, mut squares) = (0.0, 0.0);
    for (a, off_square) in diagonal.iter().zip(off_square) {
        let off = off_square.sqrt();
        gershgorin = gershgorin.max(a + before + off);
        trace += a;
        squares += a * a + 2.0 * off_square;
        before = off;
    }
    gershgorin.min(trace).min(squares.sqrt()) * (1.0 + 1e-15)
}

#[cfg(test)]
mod tests;
