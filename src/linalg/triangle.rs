//! Singular values of triangles.
#![allow(non_snake_case)]

use super::lanes::{LANES, add_rows, add_scaled, dot, groups};
use super::{TaskMatrix, TaskVector};

/// L ← L⁻¹ of a lower triangle; without a meaning where a diagonal entry is zero.
pub fn invert(L: &mut TaskMatrix) {
    for i in 0..L.nrows() {
        let mut row = TaskVector::zeros(L.ncols());
        let (above, from_i) = L.split_rows_mut(i);
        let of_L = &mut from_i[..groups(row.len())];
        add_rows(row.lanes_mut(), &of_L.as_flattened()[..i], above);
        let gain = -1.0 / of_L.as_flattened()[i];
        of_L.fill([0.0; LANES]);
        add_scaled(of_L, gain, row.lanes());
        of_L.as_flattened_mut()[i] = -gain;
    }
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
    for i in 0..n {
        let row = &X.row_vector(i) * (1.0 / size);
        for j in 0..=i {
            add_scaled(M.row_mut(j), row[j], row.lanes());
        }
    }
    let (diagonal, off_squared) = tridiagonal(M);
    size * largest_eigenvalue(&diagonal, &off_squared).sqrt()
}

/// Diagonal and squared off-diagonal of the tridiagonal matrix that Householder reflections make of a symmetric one.
fn tridiagonal(M: &mut TaskMatrix) -> (TaskVector, TaskVector) {
    let n = M.nrows();
    let mut diagonal = TaskVector::zeros(n);
    let mut off_squared = TaskVector::zeros(n);
    let mut v = TaskVector::zeros(n);
    for k in 0..n.saturating_sub(2) {
        diagonal[k] = M[k][k];
        // Row k beyond the diagonal; what is before it was taken off already.
        v.lanes_mut().copy_from_slice(M.row(k));
        v[..=k].fill(0.0);
        let square = v.dot(&v);
        off_squared[k] = square;
        if square == 0.0 {
            continue;
        }
        let length = square.sqrt();
        let head = v[k + 1];
        v[k + 1] += length.copysign(head);
        let gain = 1.0 / (length * (length + head.abs()));
        // p = g M v, w = p − (g/2)(pᵀv) v, M ← M − v wᵀ − w vᵀ on the rows and columns beyond k.
        let mut w = TaskVector::zeros(n);
        for i in k + 1..n {
            w[i] = gain * dot(M.row(i), v.lanes());
        }
        let half = 0.5 * gain * w.dot(&v);
        w.add_scaled(-half, &v);
        for i in k + 1..n {
            let (v_i, w_i) = (v[i], w[i]);
            add_scaled(M.row_mut(i), -v_i, w.lanes());
            add_scaled(M.row_mut(i), -w_i, v.lanes());
        }
    }
    for k in n.saturating_sub(2)..n {
        diagonal[k] = M[k][k];
    }
    off_squared[n - 2] = M[n - 2][n - 1] * M[n - 2][n - 1];
    (diagonal, off_squared)
}

/// Newton steps that a largest eigenvalue may take; Laguerre's take some four.
const MOST_STEPS: usize = 40;

/// The largest eigenvalue of a positive semidefinite tridiagonal matrix of trace 1, by Laguerre's iteration from above,
/// which never passes the largest root.
fn largest_eigenvalue(diagonal: &[f64], off_squared: &[f64]) -> f64 {
    let n = diagonal.len() as f64;
    let mut x = upper_bound(diagonal, off_squared);
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
        if step <= 1e-15 * x {
            break;
        }
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
