//! Householder reflections, one after the other, and the triangle that they make of the rows of a matrix.
#![allow(non_snake_case)]

use super::lanes::{Lanes, add_scaled, dot, reflect_all, reflect_all_back, reflect_rows};
use super::{TaskMatrix, TaskVector};

/// Fraction of a row's squared norm below which what is left of it is computed anew rather than by subtraction.
const CANCELLED: f64 = 1e-3;

/// A = L Qᵀ: each row of A as a combination of the first few columns of Q.
///
/// Q = H_1 H_2 … with H_k = I − v_k v_kᵀ g_k, acting on the coordinates from `first` on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reflections {
    /// Coordinates before this one stay as they are.
    pub first: usize,
    /// Rows of A in the order in which they were taken.
    pub order: Vec<usize>,
    /// The rows in that order, in the coordinates that Q makes: lower trapezoidal from `first` on, up to what the
    /// reflections leave of rows that they did not take.
    pub L: TaskMatrix,
    /// v_k.
    v: TaskMatrix,
    /// g_k.
    gains: Vec<f64>,
    /// Squared norms of what is left of the rows, and as they were when last computed from entries.
    squares: Vec<[f64; 2]>,
    /// √Σ of the squares that the reflections leave of the rows.
    pub left_over: f64,
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
        self.L.copy_from(A);
        self.v.reset(most, n);
        self.squares.clear();
        self.squares.extend((0..m).map(|i| [square(A.row(i), first); 2]));
        for k in 0..most {
            if let Order::LongestAbove(_) = order {
                self.bring_longest(k);
            }
            let v = &mut self.v[k][first + k..];
            v.copy_from_slice(&self.L[k][first + k..]);
            let length = dot(self.v.row(k), self.v.row(k)).sqrt();
            if matches!(order, Order::LongestAbove(limit) if !(length > limit)) {
                break;
            }
            self.reflect(k, length);
        }
        let taken = self.count();
        self.left_over = (taken..m).map(|i| square(self.L.row(i), first + taken)).sum::<f64>().sqrt();
    }

    /// r, the number of reflections.
    pub fn count(&self) -> usize {
        self.gains.len()
    }

    /// Swaps the longest of the rows from place k on to place k.
    fn bring_longest(&mut self, k: usize) {
        let mut longest = k;
        for (place, square) in self.squares.iter().enumerate().skip(k + 1) {
            if square[0] > self.squares[longest][0] {
                longest = place;
            }
        }
        if longest != k {
            self.order.swap(k, longest);
            self.squares.swap(k, longest);
            self.L.swap_rows(k, longest);
        }
    }

    /// Makes the row at place k, of which v_k is a copy, one of coordinate `first + k` alone, and reflects those after it.
    fn reflect(&mut self, k: usize, length: f64) {
        let place = self.first + k;
        let head = &mut self.v[k][place];
        let alpha = -length.copysign(*head);
        *head -= alpha;
        // ‖v‖²/2 = ‖x‖ (‖x‖ + |x_k|); nothing to do for no row at all.
        let half = length * head.abs();
        let gain = if half > 0.0 { 1.0 / half } else { 0.0 };
        self.gains.push(gain);
        self.L[k][place..].fill(0.0);
        self.L[k][place] = alpha;
        let squares = &mut self.squares[k + 1..];
        reflect_rows(self.L.rows_from_mut(k + 1), self.v.row(k), gain, |i, x| {
            let [left, reference] = &mut squares[i];
            let coordinate = x.as_flattened()[place];
            *left -= coordinate * coordinate;
            if *left < CANCELLED * *reference {
                *left = square(x, place + 1);
                *reference = *left;
            }
        });
    }

    /// The vectors v_k, one after the other.
    #[inline]
    fn vs(&self) -> &[Lanes] {
        self.v.lanes()
    }

    /// x ← Qᵀ x.
    #[inline]
    pub fn turn(&self, x: &mut [Lanes]) {
        reflect_all(x, self.vs(), &self.gains);
    }

    /// x ← Q x.
    #[inline]
    pub fn turn_back(&self, x: &mut [Lanes]) {
        reflect_all_back(x, self.vs(), &self.gains);
    }

    /// x, n, of the coordinates of Q, with L x = b at the rows that were taken; zero elsewhere.
    pub fn solve(&self, b: &TaskVector) -> TaskVector {
        let mut x = TaskVector::zeros(self.L.ncols());
        for (k, &row) in self.order.iter().enumerate().take(self.count()) {
            let known = dot(self.L.row(k), x.lanes());
            x[self.first + k] = (b[row] - known) / self.L[k][self.first + k];
        }
        x
    }

    /// y with Lᵀ y = c, c in the coordinates of Q, for as many rows as reflections.
    pub fn solve_transposed(&self, c: &TaskVector) -> TaskVector {
        let mut left = c.clone();
        let mut y = TaskVector::zeros(self.count());
        for k in (0..self.count()).rev() {
            y[k] = left[self.first + k] / self.L[k][self.first + k];
            let (y_k, row) = (y[k], self.L.row(k));
            add_scaled(left.lanes_mut(), -y_k, row);
        }
        y
    }

    /// Becomes the transpose of L as far as Q takes it: one row per reflection, one column per row of A, in A's order.
    pub fn write_upright(&self, R: &mut TaskMatrix) {
        R.reset(self.count(), self.order.len());
        for (i, &row) in self.order.iter().enumerate() {
            for k in 0..self.count().min(i + 1) {
                R[k][row] = self.L[i][self.first + k];
            }
        }
    }
}

/// Σ x_i² from the entry `first` on.
#[inline]
fn square(x: &[Lanes], first: usize) -> f64 {
    x.as_flattened()[first..].iter().map(|x| x * x).sum()
}
