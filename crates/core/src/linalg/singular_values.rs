//! Singular values without their vectors.

use super::laguerre::outermost_root;
use super::{Matrix, add_scaled, dot};

/// The singular values of a matrix, in memory that is used again.
///
/// Reflections from both sides turn the matrix into a bidiagonal one. Its singular values σ are the eigenvalues ±σ of a
/// tridiagonal matrix whose entries beside the diagonal are those of the bidiagonal one in turns, and a Sturm sequence counts
/// them below a bound. All results are exact to the rounding of ‖A‖.
#[derive(Debug, Default)]
pub struct SingularValues {
    count: usize,
    /// The largest entry of the matrix, by which the rest is divided.
    unit: f64,
    entries: Vec<f64>,
    sum: Vec<f64>,
    /// d_1², e_1², d_2², e_2², …, for the entries d on the diagonal of the bidiagonal matrix and e below it.
    squares: Vec<f64>,
}

impl SingularValues {
    /// Decomposes the matrix of these entries, row by row; it has at least as many columns as rows.
    pub fn decompose(&mut self, columns: usize, entries: impl Iterator<Item = f64>) {
        self.entries.clear();
        self.entries.extend(entries);
        let size = self.entries.iter().fold(0.0, |size: f64, entry| size.max(entry.abs()));
        self.unit = if size.is_normal() { size } else { 1.0 };
        self.entries.iter_mut().for_each(|entry| *entry /= self.unit);
        self.count = self.entries.len() / columns.max(1);
        self.squares.clear();
        for i in 0..self.count {
            let (above, below) = self.entries.split_at_mut((i + 1) * columns);
            let diagonal = reflect_row(&mut above[i * columns + i..], below, columns);
            self.squares.push(diagonal * diagonal);
            if !below.is_empty() {
                let beside = reflect_column(&mut below[i..], columns, &mut self.sum);
                self.squares.push(beside * beside);
            }
        }
    }

    /// Decomposes a matrix of any shape.
    pub fn decompose_matrix(&mut self, matrix: &Matrix) {
        let (m, n) = matrix.shape();
        let (short, long) = (m.min(n), m.max(n));
        let entry = |i: usize, j: usize| if m <= n { matrix[(i, j)] } else { matrix[(j, i)] };
        self.decompose(long, (0..short).flat_map(|i| (0..long).map(move |j| entry(i, j))));
    }

    /// Returns how many singular values are at least `bound`, and not zero.
    pub fn count_from(&self, bound: f64) -> usize {
        let x = (bound / self.unit).max(f64::MIN_POSITIVE);
        let mut q = -x;
        let mut negative = 1;
        for square in &self.squares {
            // A pivot of zero is a small positive one.
            q = -x - square / if q == 0.0 { f64::MIN_POSITIVE } else { q };
            negative += usize::from(q < 0.0);
        }
        // All −σ are below.
        (2 * self.count).saturating_sub(negative).min(self.count)
    }

    /// Returns whether all singular values are at least `bound`.
    pub fn is_above(&self, bound: f64) -> bool {
        self.count > 0 && self.count_from(bound) == self.count
    }

    /// Returns the smallest singular value; 0 for a matrix without rows.
    pub fn smallest(&self) -> f64 {
        if self.count == 0 || self.squares.iter().step_by(2).any(|square| *square == 0.0) {
            return 0.0;
        }
        outermost_root(self.count, (0.0, f64::INFINITY), |x| self.log_derivatives(x)).sqrt() * self.unit
    }

    /// Returns Σ 1/(σ_i² − x) and Σ 1/(σ_i² − x)²; `None` where x exceeds the smallest σ².
    ///
    /// They are derivatives of the logarithms of the pivots of BᵀB − x I for the bidiagonal matrix B, in differential form (dqds), with
    /// terms of one sign each.
    fn log_derivatives(&self, x: f64) -> Option<(f64, f64)> {
        let (mut g, mut h) = (0.0, 0.0);
        // The pivot without the square beside it, with the amounts of its derivatives, which are negative.
        let (mut rest, mut slope, mut curvature) = (self.squares.first()? - x, 1.0, 0.0);
        for i in 0..self.count {
            let beside = self.squares.get(2 * i + 1).copied().unwrap_or(0.0);
            let pivot = rest + beside;
            if !(pivot > 0.0) {
                return None;
            }
            let reciprocal = 1.0 / pivot;
            let first = slope * reciprocal;
            g += first;
            h += first * first + curvature * reciprocal;
            let Some(next) = self.squares.get(2 * i + 2) else { break };
            let ratio = next * reciprocal;
            let share = beside * reciprocal;
            curvature = ratio * share * (curvature + 2.0 * slope * first);
            slope = ratio * share * slope + 1.0;
            rest = ratio * rest - x;
        }
        Some((g, h))
    }

    /// Returns the product; 1 for a matrix without rows.
    pub fn product(&self) -> f64 {
        self.squares.iter().step_by(2).map(|square| square.sqrt() * self.unit).product()
    }
}

/// Returns σ_min and the product of the singular values of a matrix of any shape; both are 0 without rows.
pub fn smallest_and_product(matrix: &Matrix) -> (f64, f64) {
    let mut singular = SingularValues::default();
    if matrix.nrows() == 0 {
        return (0.0, 0.0);
    }
    singular.decompose_matrix(matrix);
    (singular.smallest(), singular.product())
}

/// Reflects a row onto its first entry, which is returned, and the rows below, of `stride` entries each, alike.
pub fn reflect_row(row: &mut [f64], below: &mut [f64], stride: usize) -> f64 {
    let length = dot(row, row).sqrt();
    let first = -length.copysign(row[0]);
    row[0] -= first;
    let gain = 1.0 / (length * row[0].abs());
    if gain.is_finite() {
        for other in below.chunks_exact_mut(stride) {
            let other = &mut other[stride - row.len()..];
            add_scaled(other, -gain * dot(row, other), row);
        }
    }
    first
}

/// Reflects the column of the first entries of rows, `stride` apart, onto its first entry, which is returned, and the columns
/// behind it alike.
fn reflect_column(rows: &mut [f64], stride: usize, sum: &mut Vec<f64>) -> f64 {
    let width = stride - (rows.len().next_multiple_of(stride) - rows.len());
    let length = rows.iter().step_by(stride).map(|entry| entry * entry).sum::<f64>().sqrt();
    let first = -length.copysign(rows[0]);
    rows[0] -= first;
    let gain = 1.0 / (length * rows[0].abs());
    if gain.is_finite() {
        sum.clear();
        sum.resize(width - 1, 0.0);
        for row in rows.chunks(stride) {
            add_scaled(sum, row[0], &row[1..width]);
        }
        for row in rows.chunks_mut(stride) {
            let factor = -gain * row[0];
            add_scaled(&mut row[1..width], factor, sum);
        }
    }
    first
}

#[cfg(test)]
mod tests;
