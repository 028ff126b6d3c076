//! Singular values and vectors by one-sided Jacobi rotations.
#![allow(non_snake_case)]

use super::lanes::{Lanes, add_scaled, dot};
use super::{TaskMatrix, TaskVector};

/// Cosine of the angle between two rows that counts as rounding.
const ORTHOGONAL: f64 = 1e-15;

/// Sweeps over all pairs of rows; some five are needed.
const MOST_SWEEPS: usize = 60;

/// J R = Σ Uᵀ: rotations J that make the rows of R orthogonal.
///
/// Where R comes from reflections of the longest rows first, rows are nearly orthogonal from the start, and small singular
/// values keep their relative accuracy.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Singular {
    values: Vec<f64>,
    /// Uᵀ, rows of length 1, or 0 where the singular value is 0.
    U_t: TaskMatrix,
    J: TaskMatrix,
}

impl Singular {
    /// Becomes the decomposition of R, `count` singular values in descending order: beyond the rows of R they are zero.
    pub fn decompose(&mut self, R: &TaskMatrix, count: usize) {
        let k = R.nrows();
        // At size one, squares neither overflow nor vanish.
        let size = R.norm();
        let unit = if size.is_normal() { 1.0 / size } else { 1.0 };
        self.U_t.copy_from(R);
        self.U_t.scale(unit);
        self.J.reset(k, k);
        (0..k).for_each(|i| self.J[i][i] = 1.0);
        for _ in 0..MOST_SWEEPS {
            if !self.sweep() {
                break;
            }
        }
        self.sort();
        self.values.clear();
        for i in 0..k {
            let sigma = self.U_t.row_norm(i);
            self.values.push(sigma / unit);
            let gain = if sigma > 0.0 { 1.0 / sigma } else { 0.0 };
            self.U_t[i].iter_mut().for_each(|x| *x *= gain);
        }
        self.values.resize(count, 0.0);
    }

    /// One rotation per pair of rows; whether any was needed.
    fn sweep(&mut self) -> bool {
        let mut rotated = false;
        for p in 0..self.U_t.nrows() {
            for q in p + 1..self.U_t.nrows() {
                let (x, y) = (self.U_t.row(p), self.U_t.row(q));
                let (a, b, c) = (dot(x, x), dot(y, y), dot(x, y));
                if c.abs() <= ORTHOGONAL * (a * b).sqrt() || c == 0.0 {
                    continue;
                }
                rotated = true;
                let zeta = (b - a) / (2.0 * c);
                let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                self.U_t.rotate_rows(p, q, cosine, cosine * tangent);
                self.J.rotate_rows(p, q, cosine, cosine * tangent);
            }
        }
        rotated
    }

    /// Largest first.
    fn sort(&mut self) {
        let k = self.U_t.nrows();
        for i in 0..k {
            let norm = |row: usize| self.U_t.row_norm(row);
            let largest = (i + 1..k).fold(i, |largest, row| if norm(row) > norm(largest) { row } else { largest });
            self.U_t.swap_rows(i, largest);
            self.J.swap_rows(i, largest);
        }
    }

    /// The singular values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// u_i, to be multiplied with as many entries as R has columns.
    pub fn left(&self, i: usize) -> &[Lanes] {
        self.U_t.row(i)
    }

    /// x ← J x for the coordinates x, as many as rows.
    pub fn turn(&self, x: &mut [f64]) {
        let before = TaskVector::from_slice(x);
        for (i, x) in x.iter_mut().enumerate() {
            *x = self.J.row_times(i, &before);
        }
    }

    /// x ← Jᵀ x.
    pub fn turn_back(&self, x: &mut [f64]) {
        let mut after = TaskVector::zeros(x.len());
        for (i, &x) in x.iter().enumerate() {
            add_scaled(after.lanes_mut(), x, self.J.row(i));
        }
        x.copy_from_slice(&after);
    }
}
