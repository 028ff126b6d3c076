//! Householder reflections, one after the other, and the triangle that they make of the rows of a matrix.
#![allow(non_snake_case)]

use super::lanes::{Lanes, add_scaled, dot, groups, reflect_all, reflect_all_back, with_known};
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
    /// The rows in that order, in the coordinates that Q makes, lower trapezoidal from `first` on; without what the
    /// reflections leave of rows that they did not take.
    pub L: TaskMatrix,
    /// v_k in place of the rows that were taken, and what the reflections leave of the others.
    rest: TaskMatrix,
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
        self.first = first;
        self.order.clear();
        self.order.extend(0..m);
        self.gains.clear();
        self.rest.copy_from(A);
        self.L.reset(m, n);
        for i in (0..m).filter(|_| first > 0) {
            self.L[i][..first].swap_with_slice(&mut self.rest[i][..first]);
        }
        with_known!(groups(n), |groups| self.take(m.min(n - first), groups, order));
        let left = (self.count()..m).map(|i| dot(self.rest.row(i), self.rest.row(i)));
        self.left_over = left.sum::<f64>().sqrt();
    }

    /// Takes at most so many rows, `groups` groups each.
    #[inline(always)]
    fn take(&mut self, most: usize, groups: usize, order: Order) {
        self.squares.clear();
        self.squares.extend(self.rest.lanes().chunks_exact(groups).map(|row| [dot(row, row); 2]));
        for k in 0..most {
            if let Order::LongestAbove(_) = order {
                self.bring_longest(k);
            }
            let row = &self.rest.lanes()[k * groups..][..groups];
            let length = dot(row, row).sqrt();
            if matches!(order, Order::LongestAbove(limit) if !(length > limit)) {
                break;
            }
            self.reflect(k, groups, length);
        }
    }

    /// r, the number of reflections.
    pub fn count(&self) -> usize {
        self.gains.len()
    }

    /// Swaps the longest of the rows from place k on to place k.
    #[inline(always)]
    fn bring_longest(&mut self, k: usize) {
        let (mut longest, mut most) = (k, self.squares[k][0]);
        for (place, square) in self.squares.iter().enumerate().skip(k + 1) {
            if square[0] > most {
                (longest, most) = (place, square[0]);
            }
        }
        if longest != k {
            self.order.swap(k, longest);
            self.squares.swap(k, longest);
            self.L.swap_rows(k, longest);
            self.rest.swap_rows(k, longest);
        }
    }

    /// Makes the row at place k one of coordinate `first + k` alone, and takes that coordinate off the rows after it.
    #[inline(always)]
    fn reflect(&mut self, k: usize, groups: usize, length: f64) {
        let place = self.first + k;
        let (taken, rest) = self.rest.split_rows_mut(k + 1);
        let (above, below) = self.L.split_rows_mut(k + 1);
        let v = &mut taken[k * groups..][..groups];
        let head = &mut v.as_flattened_mut()[place];
        let alpha = -length.copysign(*head);
        *head -= alpha;
        // ‖v‖²/2 = ‖x‖ (‖x‖ + |x_k|); nothing to do for no row at all.
        let half = length * head.abs();
        let gain = if half > 0.0 { 1.0 / half } else { 0.0 };
        self.gains.push(gain);
        above[k * groups..].as_flattened_mut()[place] = alpha;
        let rows = rest.chunks_exact_mut(groups).zip(below.chunks_exact_mut(groups));
        for ((x, coordinates), [left, reference]) in rows.zip(&mut self.squares[k + 1..]) {
            add_scaled(x, -gain * dot(v, x), v);
            let coordinate = std::mem::take(&mut x.as_flattened_mut()[place]);
            coordinates.as_flattened_mut()[place] = coordinate;
            *left -= coordinate * coordinate;
            if *left < CANCELLED * *reference {
                *left = dot(x, x);
                *reference = *left;
            }
        }
    }

    /// The vectors v_k, one after the other.
    #[inline]
    fn vs(&self) -> &[Lanes] {
        &self.rest.lanes()[..self.count() * groups(self.rest.ncols())]
    }

    /// x ← Qᵀ x, for one x or several, one after the other.
    #[inline]
    pub fn turn(&self, x: &mut [Lanes]) {
        reflect_all(x, groups(self.rest.ncols()), self.vs(), &self.gains);
    }

    /// x ← Q x.
    #[inline]
    pub fn turn_back(&self, x: &mut [Lanes]) {
        reflect_all_back(x, self.vs(), &self.gains);
    }

    /// x, n, of the coordinates of Q, with L x = b at the rows that were taken; zero elsewhere.
    pub fn solve(&self, b: &TaskVector) -> TaskVector {
        let mut x = TaskVector::zeros(self.L.ncols());
        with_known!(groups(self.L.ncols()), |groups| {
            let (b, x) = (&b[..], &mut x.lanes_mut()[..groups]);
            for (k, (&row, coordinates)) in self.order[..self.count()].iter().zip(self.L.lanes().chunks_exact(groups)).enumerate() {
                let known = dot(coordinates, x);
                let place = self.first + k;
                x.as_flattened_mut()[place] = (b[row] - known) / coordinates.as_flattened()[place];
            }
        });
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
