//! Householder reflections, one after the other, and the triangle that they make of the rows of a matrix.
#![allow(non_snake_case)]
// What the callers know of the number of groups reaches loops by inlining alone.
#![expect(clippy::inline_always)]

use super::lanes::{LANES, Lanes, add_scaled, dot, groups, reflect_all, reflect_all_back, with_known};
use super::{TaskMatrix, TaskVector};

/// A = Rᵀ Qᵀ: each row of A as a combination of the first few columns of Q.
///
/// Q = H_1 H_2 … with H_k = I − v_k v_kᵀ g_k, acting on the coordinates from `first` on. Column i of R has the
/// coordinates of row i of A; with the rows in the order of `order` it is upper trapezoidal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reflections {
    /// Coordinates before this one stay as they are.
    pub first: usize,
    /// Rows of A in the order in which they were taken.
    pub order: Vec<usize>,
    /// R, one row per reflection, one column per row of A.
    pub R: TaskMatrix,
    /// v_k in place of the rows that were taken, and what the reflections leave of the others.
    rest: TaskMatrix,
    /// g_k.
    gains: Vec<f64>,
    /// Squared norms of what is left of the rows.
    squares: Vec<f64>,
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
        self.squares.clear();
        self.rest.copy_from(A);
        (0..m).filter(|_| first > 0).for_each(|i| self.rest[i][..first].fill(0.0));
        self.R.reset(m.min(n - first), m);
        with_known!(groups(n), |groups| self.take(m.min(n - first), groups, order));
        self.left_over = self.squares[self.count()..].iter().sum::<f64>().sqrt();
        self.R.truncate(self.count());
    }

    /// Takes at most so many rows, `groups` groups each.
    #[inline(always)]
    fn take(&mut self, most: usize, groups: usize, order: Order) {
        self.squares.extend(self.rest.lanes().chunks_exact(groups).map(|row| dot(row, row)));
        for k in 0..most {
            if let Order::LongestAbove(_) = order {
                self.bring_longest(k);
            }
            let length = self.squares[k].sqrt();
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
        let (mut longest, mut most) = (k, self.squares[k]);
        for (place, &square) in self.squares.iter().enumerate().skip(k + 1) {
            if square > most {
                (longest, most) = (place, square);
            }
        }
        if longest != k {
            self.order.swap(k, longest);
            self.squares.swap(k, longest);
            self.rest.swap_rows(k, longest);
        }
    }

    /// Makes the row at place k one of coordinate `first + k` alone, and takes that coordinate off the rows after it.
    #[inline(always)]
    fn reflect(&mut self, k: usize, groups: usize, length: f64) {
        let place = self.first + k;
        let (taken, rest) = self.rest.split_rows_mut(k + 1);
        let (v, coordinates) = (&mut taken[k * groups..][..groups], &mut self.R[k]);
        let head = &mut v.as_flattened_mut()[place];
        let alpha = -length.copysign(*head);
        *head -= alpha;
        // ‖v‖²/2 = ‖x‖ (‖x‖ + |x_k|); nothing to do for no row at all.
        let half = length * head.abs();
        let gain = if half > 0.0 { 1.0 / half } else { 0.0 };
        self.gains.push(gain);
        coordinates[self.order[k]] = alpha;
        let places = self.order[k + 1..].iter().zip(&mut self.squares[k + 1..]);
        for (x, (&row, square)) in rest.chunks_exact_mut(groups).zip(places) {
            add_scaled(x, -gain * dot(v, x), v);
            coordinates[row] = std::mem::take(&mut x.as_flattened_mut()[place]);
            *square = dot(x, x);
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

    /// x, n, in the coordinates of Q, with Rᵀ x = b at the rows that were taken; zero elsewhere.
    pub fn solve_transposed(&self, b: &TaskVector) -> TaskVector {
        let (mut left, mut x) = (b.clone(), TaskVector::zeros(self.rest.ncols()));
        with_known!(groups(b.len()), |groups| {
            let (left, x) = (&mut left.lanes_mut()[..groups], &mut x[self.first..]);
            let rows = self.R.lanes().chunks_exact(groups).zip(&self.order);
            for ((coordinates, &pivot), x) in rows.zip(x) {
                *x = left.as_flattened()[pivot] / coordinates.as_flattened()[pivot];
                add_scaled(left, -*x, coordinates);
            }
        });
        x
    }

    /// y with R y = c, for rows that were taken as they come and all of them.
    pub fn solve(&self, c: &TaskVector) -> TaskVector {
        let mut y = TaskVector::zeros(self.count());
        for k in (0..self.count()).rev() {
            y[k] = (c[k] - self.R.row_times(k, &y)) / self.R[k][k];
        }
        y
    }

    /// Overwrites `L` with the lower triangle whose row i has the coordinates of the row that was taken as the i-th.
    pub fn write_triangle(&self, L: &mut TaskMatrix) {
        L.reset(self.count(), self.count());
        let (entries, width) = (self.R.lanes().as_flattened(), LANES * groups(self.R.ncols()));
        for (i, &row) in self.order.iter().enumerate().take(self.count()) {
            let column = entries.chunks_exact(width).map(|coordinates| coordinates[row]);
            L[i][..=i].iter_mut().zip(column).for_each(|(to, from)| *to = from);
        }
    }
}
