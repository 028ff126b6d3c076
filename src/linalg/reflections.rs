//! Householder reflections, one after the other, and the triangle that they make of the rows of a matrix.
#![allow(non_snake_case)]

use smallvec::SmallVec;

use super::lanes::{Lanes, add_scaled, dot};
use super::{TaskMatrix, TaskVector};

/// Fraction of a row's squared norm below which what is left of it is computed anew rather than by subtraction.
const CANCELLED: f64 = 1e-3;

/// A = R̃ᵀ Qᵀ: each row of A as a combination of the first few columns of Q.
///
/// Q = H_1 H_2 … with H_k = I − v_k v_kᵀ g_k, acting on the coordinates from `first` on. Column i of R̃ has the
/// coordinates of row i of A; with the rows in the order of `order` it is upper trapezoidal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reflections {
    /// Coordinates before this one stay as they are.
    pub first: usize,
    /// Rows of A in the order in which they were taken.
    pub order: SmallVec<[usize; 16]>,
    /// R̃, one row per reflection, one column per row of A.
    pub R: TaskMatrix,
    /// v_k.
    v: TaskMatrix,
    /// g_k.
    gains: SmallVec<[f64; 16]>,
    /// √Σ of the squares that the reflections leave of the rows.
    pub left_over: f64,
}

/// Rows that are being taken apart.
struct Rest {
    /// What the reflections so far leave of A.
    rows: TaskMatrix,
    /// Squared norms of the rows, and as they were when last computed from entries.
    squares: SmallVec<[[f64; 2]; 16]>,
}

impl Rest {
    fn of(A: &TaskMatrix, first: usize) -> Self {
        let mut rows = A.clone();
        for i in (0..A.nrows()).filter(|_| first > 0) {
            rows[i][..first].fill(0.0);
        }
        let squares = (0..A.nrows()).map(|i| [dot(rows.row(i), rows.row(i)); 2]).collect();
        Self { rows, squares }
    }

    /// Takes `coordinate` off the square of a row.
    fn shorten(&mut self, row: usize, coordinate: f64) {
        let [left, reference] = &mut self.squares[row];
        *left -= coordinate * coordinate;
        if *left < CANCELLED * *reference {
            *left = dot(self.rows.row(row), self.rows.row(row));
            *reference = *left;
        }
    }
}

/// Which row comes next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// The longest one, until all are at most this long.
    LongestAbove(f64),
    /// As they come.
    Given,
}

impl Reflections {
    /// Takes the rows of `A` apart, as they are from the coordinate `first` on.
    pub fn make(&mut self, A: &TaskMatrix, first: usize, order: Order) {
        let (m, n) = (A.nrows(), A.ncols());
        let most = m.min(n - first);
        self.first = first;
        self.order.clear();
        self.order.extend(0..m);
        self.gains.clear();
        self.R.reset(most, m);
        self.v.reset(most, n);
        let mut rest = Rest::of(A, first);
        for k in 0..most {
            if let Order::LongestAbove(_) = order {
                self.bring_longest(k, &rest);
            }
            let row = rest.rows.row(self.order[k]);
            let length = dot(row, row).sqrt();
            if matches!(order, Order::LongestAbove(limit) if !(length > limit)) {
                break;
            }
            self.reflect(k, length, &mut rest);
        }
        let count = self.gains.len();
        self.R.truncate(count);
        self.v.truncate(count);
        let left = self.order[count..].iter().map(|&row| dot(rest.rows.row(row), rest.rows.row(row)));
        self.left_over = left.sum::<f64>().sqrt();
    }

    /// r, the number of reflections.
    pub fn count(&self) -> usize {
        self.gains.len()
    }

    /// Swaps the longest of the rows from place k on to place k.
    fn bring_longest(&mut self, k: usize, rest: &Rest) {
        let mut longest = k;
        for place in k + 1..self.order.len() {
            if rest.squares[self.order[place]][0] > rest.squares[self.order[longest]][0] {
                longest = place;
            }
        }
        self.order.swap(k, longest);
    }

    /// Makes the row at place k one of coordinate `first + k` alone, and takes that coordinate off the rows after it.
    fn reflect(&mut self, k: usize, length: f64, rest: &mut Rest) {
        let (place, pivot) = (self.first + k, self.order[k]);
        let v = self.v.row_mut(k);
        v.copy_from_slice(rest.rows.row(pivot));
        let head = &mut v.as_flattened_mut()[place];
        let alpha = -length.copysign(*head);
        *head -= alpha;
        // ‖v‖²/2 = ‖x‖ (‖x‖ + |x_k|); nothing to do for no row at all.
        let half = length * head.abs();
        let gain = if half > 0.0 { 1.0 / half } else { 0.0 };
        self.gains.push(gain);
        self.R[k][pivot] = alpha;
        let v = self.v.row(k);
        let coordinates = self.R.row_mut(k).as_flattened_mut();
        for &row in &self.order[k + 1..] {
            let x = rest.rows.row_mut(row);
            add_scaled(x, -gain * dot(v, x), v);
            coordinates[row] = std::mem::take(&mut x.as_flattened_mut()[place]);
            rest.shorten(row, coordinates[row]);
        }
    }

    /// x ← Qᵀ x.
    #[inline]
    pub fn turn(&self, x: &mut [Lanes]) {
        for (v, gain) in self.v.row_lanes().zip(&self.gains) {
            add_scaled(x, -gain * dot(v, x), v);
        }
    }

    /// x ← Q x.
    #[inline]
    pub fn turn_back(&self, x: &mut [Lanes]) {
        for k in (0..self.count()).rev() {
            let v = self.v.row(k);
            add_scaled(x, -self.gains[k] * dot(v, x), v);
        }
    }

    /// y with Rᵀ y = b at the rows of the triangle, for as many rows as reflections.
    pub fn solve_transposed(&self, b: &TaskVector) -> TaskVector {
        let mut left = b.clone();
        let mut y = TaskVector::zeros(self.count());
        for (k, row) in self.R.row_lanes().enumerate() {
            let pivot = self.order[k];
            y[k] = left[pivot] / row.as_flattened()[pivot];
            add_scaled(left.lanes_mut(), -y[k], row);
        }
        y
    }

    /// y with R y = c, R in the order of the rows, for as many rows as reflections.
    pub fn solve(&self, c: &[f64]) -> TaskVector {
        let mut y = TaskVector::zeros(self.count());
        for k in (0..self.count()).rev() {
            let row = &self.R[k];
            let known: f64 = (k + 1..self.count()).map(|j| row[self.order[j]] * y[j]).sum();
            y[k] = (c[k] - known) / row[self.order[k]];
        }
        y
    }

    /// The leading triangle transposed: row i has the coordinates of the i-th row taken.
    pub fn triangle(&self) -> TaskMatrix {
        let r = self.count();
        TaskMatrix::from_fn(r, r, |i, j| if j <= i { self.R[j][self.order[i]] } else { 0.0 })
    }
}
