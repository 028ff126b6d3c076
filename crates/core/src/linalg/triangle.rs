//! The smallest singular value of a well-conditioned lower triangle.

use super::Row;

/// A lower triangle's inverse, and room for its tridiagonal form.
#[derive(Debug, Default)]
pub struct Triangle<const N: usize> {
    inverse: Vec<Row<N>>,
    gram: Vec<Row<N>>,
}

impl<const N: usize> Triangle<N> {
    /// Inverts the triangle L with these rows and reciprocal diagonal entries; returns the lower bound 1/‖L⁻¹‖_F of σ_min.
    pub fn invert<'a>(&mut self, rows: impl Iterator<Item = &'a Row<N>>, reciprocals: &[f64]) -> f64 {
        self.inverse.clear();
        let mut square = 0.0;
        for (i, (row, reciprocal)) in rows.zip(reciprocals).enumerate() {
            let mut inverse = Row::ZERO;
            for (above, entry) in self.inverse.iter().zip(&row.0) {
                inverse.add_scaled(-reciprocal * entry, above);
            }
            inverse.0[i] = *reciprocal;
            square += inverse.dot(&inverse);
            self.inverse.push(inverse);
        }
        1.0 / square.sqrt()
    }

    /// Returns σ_min = 1/‖L⁻¹‖₂ of the triangle inverted last, from the largest eigenvalue of (L⁻¹)ᵀ L⁻¹. Squares lose digits
    /// of small values only, so it is exact to rounding.
    pub fn smallest_singular_value(&mut self) -> f64 {
        let n = self.inverse.len();
        let size = self.inverse.iter().map(|row| row.dot(row)).sum::<f64>().sqrt();
        if !(size.is_normal() && n > 1) {
            return 1.0 / size;
        }
        let unit = 1.0 / size;
        self.gram.clear();
        self.gram.resize(n, Row::ZERO);
        for (i, row) in self.inverse.iter().enumerate() {
            for (gram, entry) in self.gram.iter_mut().zip(&row.0[..=i]) {
                gram.add_scaled(entry * unit * unit, row);
            }
        }
        let (mut diagonal, mut off_square) = (Row::<N>::ZERO, Row::<N>::ZERO);
        for k in (1..n).rev() {
            let (before, row) = self.gram.split_at_mut(k);
            diagonal.0[k] = row[0].0[k];
            off_square.0[k - 1] = reduce(before, &row[0], k);
        }
        diagonal.0[0] = self.gram[0].0[0];
        1.0 / (size * largest_eigenvalue(&diagonal.0[..n], &off_square.0[..n]).sqrt())
    }
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

/// Maximum number of Laguerre steps. About four are needed.
const MAX_STEPS: usize = 40;

/// Returns the largest eigenvalue of a positive semidefinite tridiagonal matrix of trace 1, by Laguerre's iteration from
/// above, which never passes the largest root.
fn largest_eigenvalue(diagonal: &[f64], off_square: &[f64]) -> f64 {
    let n = diagonal.len() as f64;
    let mut x = upper_bound(diagonal, off_square);
    let mut last_step = x;
    for _ in 0..MAX_STEPS {
        // p, p' and p''/2 of the characteristic polynomial by its three-term recurrence.
        let (mut p, mut dp, mut ddp) = (1.0, 0.0, 0.0);
        let (mut p_before, mut dp_before, mut ddp_before) = (0.0, 0.0, 0.0);
        let mut off = 0.0;
        for (a, off_next) in diagonal.iter().zip(off_square) {
            let gap = x - a;
            let next = gap * p - off * p_before;
            let dnext = gap * dp + p - off * dp_before;
            let ddnext = gap * ddp + dp - off * ddp_before;
            (p_before, dp_before, ddp_before) = (p, dp, ddp);
            (p, dp, ddp) = (next, dnext, ddnext);
            off = *off_next;
        }
        if !(p > 0.0 && dp > 0.0) {
            break;
        }
        let g = dp / p;
        let h = g * g - 2.0 * ddp / p;
        let root = ((n - 1.0) * (n * h - g * g)).max(0.0).sqrt();
        let step = n / (g + root);
        x -= step;
        // Convergence is cubic, but linear on the way to roots that lie close together.
        let ratio = step / last_step;
        if step <= 1e-15 * x || (ratio < 1e-2 && ratio.powi(3) * step <= 1e-17 * x) {
            break;
        }
        last_step = step;
    }
    x
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
