//! Singular values of triangles.
#![allow(non_snake_case)]
// What the callers know of the number of groups reaches loops by inlining alone.
#![expect(clippy::inline_always)]

use super::lanes::{LANES, Lanes, add_scaled, dot, groups, with_known};
use super::{TaskMatrix, TaskVector};

/// L ← L⁻¹ of a lower triangle; without a meaning where a diagonal entry is zero.
pub fn invert(L: &mut TaskMatrix) {
    let n = L.nrows();
    with_known!(groups(n), |groups| (0..n).for_each(|i| invert_row(L, i, groups)));
}

/// Row i of the inverse in place of that of L, after the rows above it.
#[inline(always)]
fn invert_row(L: &mut TaskMatrix, i: usize, groups: usize) {
    let (above, of_L) = L.split_rows_mut(i);
    let of_L = &mut of_L[..groups];
    let gain = 1.0 / of_L.as_flattened()[i];
    let mut row = TaskVector::zeros(LANES * groups);
    let row = &mut row.lanes_mut()[..groups];
    for (above, entry) in above.chunks_exact(groups).zip(of_L.as_flattened()) {
        add_scaled(row, -gain * entry, above);
    }
    of_L.copy_from_slice(row);
    of_L.as_flattened_mut()[i] = gain;
}

/// ‖X‖₂ of a lower triangle, as the root of the largest eigenvalue of Xᵀ X: exact to rounding, for the squares lose digits
/// of small values alone. `M` is room to work in.
pub fn spectral_norm(X: &TaskMatrix, M: &mut TaskMatrix) -> f64 {
    let n = X.nrows();
    let size = X.norm();
    if !(size.is_normal() && n > 1) {
        return size;
    }
    M.reset(n, n);
    let (mut diagonal, mut off_squared) = (TaskVector::zeros(n), TaskVector::zeros(n));
    let M = M.rows_from_mut(0);
    with_known!(groups(n), |width| {
        for (i, row) in X.lanes().chunks_exact(width).enumerate() {
            add_outer(M, row, &row.as_flattened()[..=i], size);
        }
        for k in (1..n).rev() {
            let (before, row) = M.split_at_mut(k * width);
            diagonal[k] = row.as_flattened()[k];
            // The entries before the diagonal.
            with_known!(groups(k), |used| off_squared[k - 1] = reduce(before, width, &mut row[..used], k));
        }
    });
    diagonal[0] = M.as_flattened()[0];
    size * largest_eigenvalue(&diagonal, &off_squared).sqrt()
}

/// M ← M + x xᵀ / size², where x ends with the entry that `entries` ends with.
#[inline(always)]
fn add_outer(M: &mut [Lanes], x: &[Lanes], entries: &[f64], size: f64) {
    let unit = 1.0 / size;
    for (row, entry) in M.chunks_exact_mut(x.len()).zip(entries) {
        add_scaled(row, entry * unit * unit, x);
    }
}

/// A reflection of the first k rows and columns of a symmetric matrix, `M`, leaves of row k before the diagonal, which `v`
/// begins with, the last entry alone; its square.
#[inline(always)]
fn reduce(M: &mut [Lanes], groups: usize, v: &mut [Lanes], k: usize) -> f64 {
    v.as_flattened_mut()[k..].fill(0.0);
    let square = dot(v, v);
    if square == 0.0 || k == 1 {
        return square;
    }
    let length = square.sqrt();
    let head = v.as_flattened()[k - 1];
    v.as_flattened_mut()[k - 1] += length.copysign(head);
    let gain = 1.0 / (length * (length + head.abs()));
    // p = g M v, w = p − (g/2)(pᵀv) v, M ← M − v wᵀ − w vᵀ.
    let mut w = TaskVector::zeros(LANES * v.len());
    let w = &mut w.lanes_mut()[..v.len()];
    for (row, w) in M.chunks_exact(groups).zip(w.as_flattened_mut()) {
        *w = gain * dot(&row[..v.len()], v);
    }
    let half = 0.5 * gain * dot(w, v);
    add_scaled(w, -half, v);
    let entries = v.as_flattened().iter().zip(w.as_flattened());
    for (row, (v_i, w_i)) in M.chunks_exact_mut(groups).zip(entries) {
        let row = &mut row[..v.len()];
        add_scaled(row, -v_i, w);
        add_scaled(row, -w_i, v);
    }
    square
}

/// Newton steps that a largest eigenvalue may take; Laguerre's take some four.
const MOST_STEPS: usize = 40;

/// The largest eigenvalue of a positive semidefinite tridiagonal matrix of trace 1, by Laguerre's iteration from above,
/// which never passes the largest root.
fn largest_eigenvalue(diagonal: &[f64], off_squared: &[f64]) -> f64 {
    let n = diagonal.len() as f64;
    let mut x = upper_bound(diagonal, off_squared);
    let mut last_step = x;
    for _ in 0..MOST_STEPS {
        // p, p', p''/2 of the characteristic polynomial by its three-term recurrence.
        let (mut p, mut dp, mut ddp) = (1.0, 0.0, 0.0);
        let (mut p_before, mut dp_before, mut ddp_before) = (0.0, 0.0, 0.0);
        let mut off = 0.0;
        for (a, off_next) in diagonal.iter().zip(off_squared) {
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

/// The least of Gershgorin's bound, the trace and the norm.
fn upper_bound(diagonal: &[f64], off_squared: &[f64]) -> f64 {
    let (mut before, mut gershgorin) = (0.0, 0.0_f64);
    let (mut trace, mut squares) = (0.0, 0.0);
    for (a, off_squared) in diagonal.iter().zip(off_squared) {
        let off = off_squared.sqrt();
        gershgorin = gershgorin.max(a + before + off);
        trace += a;
        squares += a * a + 2.0 * off_squared;
        before = off;
    }
    gershgorin.min(trace).min(squares.sqrt()) * (1.0 + 1e-15)
}
