//! Matrices of the size of a task: stored in place, on the heap only where they are larger.
#![allow(non_snake_case)]

use std::ops::{Index, IndexMut, Mul};

use smallvec::SmallVec;

use super::lanes::{LANES, Lanes, add_scaled, dot};
use super::{Matrix, TaskVector};

/// Length of a row, relative to what it was before a product with an orthonormal basis, that is rounding.
const ROUNDING: f64 = 4e-15;

/// Groups in place.
const IN_PLACE: usize = 24;

/// A matrix whose rows are treated one by one; in place up to, for example, 12 × 8.
#[derive(Debug, PartialEq, Default)]
pub struct TaskMatrix {
    rows: usize,
    columns: usize,
    lanes: SmallVec<[Lanes; IN_PLACE]>,
}

impl Clone for TaskMatrix {
    #[inline]
    fn clone(&self) -> Self {
        Self { rows: self.rows, columns: self.columns, lanes: SmallVec::from_slice(&self.lanes) }
    }

    #[inline]
    fn clone_from(&mut self, other: &Self) {
        self.copy_from(other);
    }
}

impl TaskMatrix {
    /// Zeros.
    #[inline]
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, lanes: SmallVec::from_elem([0.0; LANES], rows * columns.div_ceil(LANES)) }
    }

    /// Becomes zeros.
    #[inline]
    pub fn reset(&mut self, rows: usize, columns: usize) {
        (self.rows, self.columns) = (rows, columns);
        let groups = rows * columns.div_ceil(LANES);
        if self.lanes.len() == groups {
            self.lanes.fill([0.0; LANES]);
        } else {
            self.lanes.clear();
            self.lanes.resize(groups, [0.0; LANES]);
        }
    }

    /// Becomes a copy.
    #[inline]
    pub fn copy_from(&mut self, other: &Self) {
        (self.rows, self.columns) = (other.rows, other.columns);
        self.lanes.clear();
        self.lanes.extend_from_slice(&other.lanes);
    }

    /// Becomes a copy.
    #[inline]
    pub fn copy_from_matrix(&mut self, other: &Matrix) {
        self.reset(other.nrows(), other.ncols());
        for i in 0..self.rows {
            self[i].iter_mut().enumerate().for_each(|(j, x)| *x = other[(i, j)]);
        }
    }

    /// Entry by entry.
    #[inline]
    pub fn from_fn(rows: usize, columns: usize, mut entry: impl FnMut(usize, usize) -> f64) -> Self {
        let mut matrix = Self::zeros(rows, columns);
        for i in 0..rows {
            matrix[i].iter_mut().enumerate().for_each(|(j, x)| *x = entry(i, j));
        }
        matrix
    }

    /// I.
    #[inline]
    pub fn identity(n: usize) -> Self {
        Self::from_fn(n, n, |i, j| f64::from(u8::from(i == j)))
    }

    /// As a matrix of any size.
    #[inline]
    pub fn to_matrix(&self) -> Matrix {
        Matrix::from_fn(self.rows, self.columns, |i, j| self[i][j])
    }

    /// m, the number of rows.
    #[inline]
    pub fn nrows(&self) -> usize {
        self.rows
    }

    /// n, the number of columns.
    #[inline]
    pub fn ncols(&self) -> usize {
        self.columns
    }

    /// Groups per row.
    #[inline]
    pub(super) fn stride(&self) -> usize {
        self.columns.div_ceil(LANES)
    }

    #[inline]
    pub(super) fn row(&self, i: usize) -> &[Lanes] {
        let stride = self.stride();
        &self.lanes[i * stride..(i + 1) * stride]
    }

    #[inline]
    pub(super) fn row_mut(&mut self, i: usize) -> &mut [Lanes] {
        let stride = self.stride();
        &mut self.lanes[i * stride..(i + 1) * stride]
    }

    #[inline]
    pub(super) fn row_lanes(&self) -> impl Iterator<Item = &[Lanes]> {
        self.lanes.chunks_exact(self.stride().max(1))
    }

    /// Row i times x.
    #[inline]
    pub fn row_times(&self, i: usize, x: &TaskVector) -> f64 {
        dot(self.row(i), x.lanes())
    }

    /// A ← A − x yᵀ.
    #[inline]
    pub fn subtract_outer(&mut self, x: &TaskVector, y: &TaskVector) {
        for (i, &x) in x.iter().enumerate() {
            add_scaled(self.row_mut(i), -x, y.lanes());
        }
    }

    /// Row i as a vector.
    #[inline]
    pub fn row_vector(&self, i: usize) -> TaskVector {
        TaskVector::from_slice(&self[i])
    }

    /// Norm of row i.
    #[inline]
    pub fn row_norm(&self, i: usize) -> f64 {
        dot(self.row(i), self.row(i)).sqrt()
    }

    /// Frobenius norm.
    #[inline]
    pub fn norm(&self) -> f64 {
        dot(&self.lanes, &self.lanes).sqrt()
    }

    /// A ← factor A.
    #[inline]
    pub(super) fn scale(&mut self, factor: f64) {
        self.lanes.as_flattened_mut().iter_mut().for_each(|x| *x *= factor);
    }

    /// This matrix is a product of `B` with an orthonormal basis: of rows that it leaves nothing but rounding, the entries
    /// from column `first` on become zero.
    ///
    /// Such a row can stand for a demand that nothing meets. Least squares multiplies what is left of it by that demand,
    /// and divides twice by the smallest singular value of the other rows.
    #[inline]
    pub fn without_rounding(&mut self, first: usize, B: &Self) {
        for i in 0..self.rows {
            let left = &mut self[i][first..];
            let square: f64 = left.iter().map(|x| x * x).sum();
            if square <= ROUNDING * ROUNDING * dot(B.row(i), B.row(i)) {
                left.fill(0.0);
            }
        }
    }

    /// Keeps the first `count` rows.
    #[inline]
    pub(super) fn truncate(&mut self, count: usize) {
        self.rows = count;
        self.lanes.truncate(count * self.stride());
    }

    #[inline]
    pub(super) fn swap_rows(&mut self, i: usize, j: usize) {
        if i != j {
            let (upper, lower) = self.pair(i.min(j), i.max(j));
            upper.swap_with_slice(lower);
        }
    }

    /// Row p ← cosine p − sine q, row q ← sine p + cosine q; p < q.
    #[inline]
    pub(super) fn rotate_rows(&mut self, p: usize, q: usize, cosine: f64, sine: f64) {
        let (upper, lower) = self.pair(p, q);
        for (x, y) in upper.as_flattened_mut().iter_mut().zip(lower.as_flattened_mut()) {
            (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
        }
    }

    /// Rows p < q.
    #[inline]
    fn pair(&mut self, p: usize, q: usize) -> (&mut [Lanes], &mut [Lanes]) {
        let stride = self.stride();
        let (before, after) = self.lanes.split_at_mut(q * stride);
        (&mut before[p * stride..(p + 1) * stride], &mut after[..stride])
    }

    /// Adds a row; of the first one, its length is the number of columns.
    #[inline]
    pub fn push_row(&mut self, row: &[f64]) {
        if self.rows == 0 {
            self.columns = row.len();
        }
        self.rows += 1;
        self.lanes.resize(self.rows * self.stride(), [0.0; LANES]);
        let last = self.rows - 1;
        self[last].copy_from_slice(row);
    }

    /// Adds the rows of another matrix of as many columns below.
    #[inline]
    pub fn push_rows(&mut self, other: &Self) {
        if self.rows == 0 {
            self.copy_from(other);
        } else {
            self.rows += other.rows;
            self.lanes.extend_from_slice(&other.lanes);
        }
    }

    /// The first `count` rows.
    #[must_use]
    #[inline]
    pub fn first_rows(&self, count: usize) -> Self {
        Self { rows: count, columns: self.columns, lanes: self.lanes[..count * self.stride()].into() }
    }

    /// The columns from `first` on.
    #[must_use]
    #[inline]
    pub fn columns_from(&self, first: usize) -> Self {
        Self::from_fn(self.rows, self.columns - first, |i, j| self[i][first + j])
    }

    /// Aᵀ x.
    #[inline]
    pub fn transposed_times(&self, x: &TaskVector) -> TaskVector {
        let mut product = TaskVector::zeros(self.columns);
        for (row, &x) in self.row_lanes().zip(x.iter()) {
            add_scaled(product.lanes_mut(), x, row);
        }
        product
    }

    /// Aᵀ.
    #[must_use]
    #[inline]
    pub fn transposed(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |i, j| self[j][i])
    }
}

impl Index<usize> for TaskMatrix {
    type Output = [f64];

    #[inline]
    fn index(&self, i: usize) -> &[f64] {
        &self.row(i).as_flattened()[..self.columns]
    }
}

impl IndexMut<usize> for TaskMatrix {
    #[inline]
    fn index_mut(&mut self, i: usize) -> &mut [f64] {
        let columns = self.columns;
        &mut self.row_mut(i).as_flattened_mut()[..columns]
    }
}

impl From<&Matrix> for TaskMatrix {
    #[inline]
    fn from(matrix: &Matrix) -> Self {
        let mut copy = Self::default();
        copy.copy_from_matrix(matrix);
        copy
    }
}

impl Mul<&TaskVector> for &TaskMatrix {
    type Output = TaskVector;

    #[inline]
    fn mul(self, x: &TaskVector) -> TaskVector {
        let mut product = TaskVector::zeros(self.rows);
        product.iter_mut().zip(self.row_lanes()).for_each(|(y, row)| *y = dot(row, x.lanes()));
        product
    }
}

impl Mul for &TaskMatrix {
    type Output = TaskMatrix;

    #[inline]
    fn mul(self, other: Self) -> TaskMatrix {
        let mut product = TaskMatrix::zeros(self.rows, other.columns);
        for i in 0..self.rows {
            for (k, row) in other.row_lanes().enumerate() {
                add_scaled(product.row_mut(i), self[i][k], row);
            }
        }
        product
    }
}

impl Mul<f64> for &TaskMatrix {
    type Output = TaskMatrix;

    #[inline]
    fn mul(self, factor: f64) -> TaskMatrix {
        let mut product = self.clone();
        product.scale(factor);
        product
    }
}
