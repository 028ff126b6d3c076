//! The smallest singular value of a well-conditioned lower triangle, and the smallest eigenvalue of a symmetric matrix.

use super::{Matrix, Row};

/// Returns σ_min and the product of the singular values of a matrix with independent rows, at most as many as columns and at
/// most 136; both are 0 without rows.
///
/// They are those of the triangle L in A = L Qᵀ: σ_min = 1/‖L⁻¹‖₂ from the largest eigenvalue of (L⁻¹)ᵀ L⁻¹. Squares lose digits
/// of small values only, so it is exact to rounding. The product is |det L|.
pub fn smallest_and_product(matrix: &Matrix) -> (f64, f64) {
    match matrix.ncols() {
        _ if matrix.nrows() == 0 => (0.0, 0.0),
        0..=8 => smallest_and_product_of_width::<8>(matrix),
        9..=40 => smallest_and_product_of_width::<40>(matrix),
        _ => smallest_and_product_of_width::<136>(matrix),
    }
}

fn smallest_and_product_of_width<const N: usize>(matrix: &Matrix) -> (f64, f64) {
    let mut rows = vec![Row::<N>::ZERO; matrix.nrows()];
    for (j, column) in matrix.as_slice().chunks_exact(matrix.nrows()).enumerate() {
        rows.iter_mut().zip(column).for_each(|(row, entry)| row.0[j] = *entry);
    }
    let mut product = 1.0;
    for c in 0..rows.len() {
        product *= reflect_rows(&mut rows[c..], c);
    }
    let mut inverse = Vec::with_capacity(rows.len());
    let with_reciprocals = rows.iter().enumerate().map(|(i, row)| (row, 1.0 / row.0[i]));
    let size = write_inverse(with_reciprocals, &mut inverse);
    (smallest_from_inverse(&inverse, size, &mut rows), product)
}

/// Reflects the columns from c on so that the first row ends at the diagonal; returns the length of what it had from there on.
fn reflect_rows<const N: usize>(rows: &mut [Row<N>], c: usize) -> f64 {
    let [row, later @ ..] = rows else { return 1.0 };
    let mut v = *row;
    v.0[..c].fill(0.0);
    let (length, head) = (v.norm(), v.0[c]);
    let alpha = -length.copysign(head);
    v.0[c] -= alpha;
    let gain = 1.0 / (length * (length + head.abs()));
    for row in later {
        row.add_scaled(-gain * v.dot(row), &v);
    }
    row.0[c..].fill(0.0);
    row.0[c] = alpha;
    length
}

/// Returns σ_min of a triangle from its inverse and the norm of that, the results of [`write_inverse`]; `gram` is room.
pub fn smallest_from_inverse<const N: usize>(inverse: &[Row<N>], size: f64, gram: &mut Vec<Row<N>>) -> f64 {
    let n = inverse.len();
    if !(size.is_normal() && n > 1) {
        return 1.0 / size;
    }
    let unit = 1.0 / size;
    gram.clear();
    gram.resize(n, Row::<N>::ZERO);
    for (i, row) in inverse.iter().enumerate() {
        for (gram, entry) in gram.iter_mut().zip(&row.0[..=i]) {
            gram.add_scaled(entry * unit * unit, row);
        }
    }
    let (diagonal, off_square) = tridiagonal(gram);
    1.0 / (size * largest_eigenvalue(&diagonal.0[..n], &off_square.0[..n]).sqrt())
}

/// Returns the smallest eigenvalue of a positive semidefinite matrix M, exact to the rounding of its trace t. `matrix` holds the
/// rows of M and is overwritten.
///
/// It is t (1 − x) for the largest eigenvalue x of I − M/t.
pub fn smallest_eigenvalue<const N: usize>(matrix: &mut [Row<N>]) -> f64 {
    let n = matrix.len();
    let trace: f64 = matrix.iter().enumerate().map(|(i, row)| row.0[i]).sum();
    if !(trace.is_normal() && n > 1) {
        return trace;
    }
    for row in matrix.iter_mut() {
        row.0.iter_mut().for_each(|entry| *entry /= trace);
    }
    let (mut diagonal, off_square) = tridiagonal(matrix);
    diagonal.0.iter_mut().for_each(|entry| *entry = 1.0 - *entry);
    let largest = largest_eigenvalue(&diagonal.0[..n], &off_square.0[..n]);
    trace * (1.0 - largest).max(0.0)
}

/// Reduces a symmetric matrix to a tridiagonal one with the same eigenvalues; returns its diagonal and the squares beside it.
fn tridiagonal<const N: usize>(matrix: &mut [Row<N>]) -> (Row<N>, Row<N>) {
    let (mut diagonal, mut off_square) = (Row::ZERO, Row::ZERO);
    for k in (1..matrix.len()).rev() {
        let (before, row) = matrix.split_at_mut(k);
        diagonal.0[k] = row[0].0[k];
        off_square.0[k - 1] = reduce(before, &row[0], k);
    }
    diagonal.0[0] = matrix[0].0[0];
    (diagonal, off_square)
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

/// Reflects the first k rows and columns of a symmetric matrix so that row k keeps one entry before the diagonal; returns
/// the square of that entry.
fn reduce<const N: usize>(matrix: &mut [Row<N>], row: &Row<N>, k: usize) -> f64 {
    // Short rows take part with their first group alone.
    if k <= 4 { reduce_width::<N, 4>(matrix, row, k) } else { reduce_width::<N, N>(matrix, row, k) }
}

/// The same with the first W entries of each row, k at most.
fn reduce_width<const N: usize, const W: usize>(matrix: &mut [Row<N>], row: &Row<N>, k: usize) -> f64 {
    let mut v = Row::<W>::from_slice(&row.0[..k]);
    let square = v.dot(&v);
    if square == 0.0 || k == 1 {
        return square;
    }
    let length = square.sqrt();
    let head = v.0[k - 1];
    v.0[k - 1] += length.copysign(head);
    let gain = 1.0 / (length * (length + head.abs()));
    // p = g M v, w = p − (g/2)(pᵀv) v, M ← M − v wᵀ − w vᵀ.
    let mut w = Row::<W>::ZERO;
    for (row, w) in matrix.iter().zip(&mut w.0) {
        *w = gain * Row::<W>::from_slice(&row.0[..W]).dot(&v);
    }
    let half = 0.5 * gain * w.dot(&v);
    w.add_scaled(-half, &v);
    for (row, (v_i, w_i)) in matrix.iter_mut().zip(v.0.iter().zip(&w.0)) {
        for (entry, (v, w)) in row.0[..W].iter_mut().zip(v.0.iter().zip(&w.0)) {
            *entry -= v_i * w + w_i * v;
        }
    }
    square
}

/// Maximum number of steps. About four are needed.
const MAX_STEPS: usize = 100;

/// Returns the largest eigenvalue of a positive semidefinite tridiagonal matrix of a size about 1, to rounding.
///
/// Laguerre's iteration from above, for a root of the multiplicity that its derivatives show: convergence to roots that lie close
/// together would be slow without it. A step that passes the largest eigenvalue is taken back, all but a little.
fn largest_eigenvalue(diagonal: &[f64], off_square: &[f64]) -> f64 {
    let n = diagonal.len() as f64;
    let mut above = upper_bound(diagonal, off_square);
    let (mut below, mut x, mut back) = (0.0, above, 4.0 * f64::EPSILON);
    for _ in 0..MAX_STEPS {
        if let Some((g, h)) = log_derivatives(diagonal, off_square, x) {
            above = x;
            let ratio = g * g / h;
            let multiplicity = ratio.round().clamp(1.0, n);
            let step = n / (g + ((n - multiplicity) / multiplicity * (n * h - g * g)).max(0.0).sqrt());
            x -= step;
            // Convergence to a single root is cubic: its next distance is about the distance times the square of what the ratio is off.
            let is_single = multiplicity == 1.0 && step * (ratio - 1.0).powi(2) <= 1e-17 * x;
            if is_single || step <= 1e-16 * above {
                return x;
            }
        } else {
            below = x;
        }
        if above - below <= 1e-15 * above {
            break;
        }
        if x <= below {
            x = (below + back * above).min(0.5 * (below + above));
            back *= 16.0;
        }
    }
    above
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
#[allow(non_snake_case)]
mod tests {
    use super::*;
    use crate::linalg::Matrix;

    /// M = H diag(λ) H for a reflection H, with λ_min from 0 to about the trace, alone, several times, and with others close to it.
    #[test]
    fn the_smallest_eigenvalue_is_exact_to_the_rounding_of_the_trace() {
        for size in [1, 2, 3, 5, 8] {
            for (smallest, apart) in [0.0, 1e-12, 1e-6, 1e-3, 0.5, 1.0]
                .into_iter()
                .flat_map(|smallest| [0.0, 1e-12, 1e-8, 1e-6, 1e-4, 1e-2].map(|apart| (smallest, apart)))
            {
                for copies in 1..=size {
                    let lambda = |i: usize| smallest + if i < copies { apart * i as f64 } else { (i * i) as f64 };
                    let v = Matrix::from_fn(size, 1, |i, _| 1.0 + (3 * i % 5) as f64);
                    let H = Matrix::identity(size, size) - 2.0 / v.norm_squared() * &v * v.transpose();
                    let M = &H * Matrix::from_fn(size, size, |i, j| if i == j { lambda(i) } else { 0.0 }) * &H;
                    let mut rows: Vec<Row<8>> =
                        (0..size).map(|i| Row::from_slice(&(0..size).map(|j| M[(i, j)]).collect::<Vec<_>>())).collect();
                    let found = smallest_eigenvalue(&mut rows);
                    assert!(
                        (found - smallest).abs() <= 1e-13 * (1.0 + M.trace()),
                        "{size} {smallest} {apart} {copies}: {found:e}"
                    );
                }
            }
        }
    }
}
