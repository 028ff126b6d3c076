//! Matrices of the size of a task, to be overwritten again and again.
#![allow(non_snake_case)]

use std::ops::{Index, IndexMut, Mul};

use super::lanes::{LANES, Lanes, add_rows, add_scaled, dot, groups, rows_times};
use super::{Matrix, TaskVector};

/// Length of a row, relative to what it was before a product with an orthonormal basis, that is rounding.
const ROUNDING: f64 = 4e-15;

/// A matrix whose rows are treated one by one. It keeps its memory: overwritten, it allocates only where it grows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TaskMatrix {
    rows: usize,
    columns: usize,
    /// Groups per row.
    stride: usize,
    lanes: Vec<Lanes>,
}

impl TaskMatrix {
    /// Zeros.
    #[inline]
    pub fn zeros(rows: usize, columns: usize) -> Self {
        let stride = groups(columns);
        Self { rows, columns, stride, lanes: vec![[0.0; LANES]; rows * stride] }
    }

    /// Becomes zeros.
    #[inline]
    pub fn reset(&mut self, rows: usize, columns: usize) {
        (self.rows, self.columns, self.stride) = (rows, columns, groups(columns));
        self.lanes.clear();
        self.lanes.resize(rows * self.stride, [0.0; LANES]);
    }

    /// Becomes a copy.
    #[inline]
    pub fn copy_from(&mut self, other: &Self) {
        (self.rows, self.columns, self.stride) = (other.rows, other.columns, other.stride);
        self.lanes.clear();
        self.lanes.extend_from_slice(&other.lanes);
    }

    /// Becomes a copy.
    #[inline]
    pub fn copy_from_matrix(&mut self, other: &Matrix) {
        self.reset(other.nrows(), other.ncols());
        let (width, entries) = (LANES * self.stride, self.lanes.as_flattened_mut());
        for (j, column) in other.as_slice().chunks_exact(self.rows.max(1)).enumerate() {
            column.iter().enumerate().for_each(|(i, x)| entries[i * width + j] = *x);
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
        let mut identity = Self::default();
        identity.become_identity(n);
        identity
    }

    /// Becomes I.
    #[inline]
    pub fn become_identity(&mut self, n: usize) {
        self.reset(n, n);
        (0..n).for_each(|i| self[i][i] = 1.0);
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

    /// All rows, one after the other.
    #[inline]
    pub(super) fn lanes(&self) -> &[Lanes] {
        &self.lanes
    }

    #[inline]
    pub(super) fn row(&self, i: usize) -> &[Lanes] {
        &self.lanes[i * self.stride..][..self.stride]
    }

    #[inline]
    pub(super) fn row_mut(&mut self, i: usize) -> &mut [Lanes] {
        &mut self.lanes[i * self.stride..][..self.stride]
    }

    /// The rows from `first` on.
    #[inline]
    pub(super) fn rows_from_mut(&mut self, first: usize) -> &mut [Lanes] {
        &mut self.lanes[first * self.stride..]
    }

    /// The rows before the i-th, and the others.
    #[inline]
    pub(super) fn split_rows_mut(&mut self, i: usize) -> (&mut [Lanes], &mut [Lanes]) {
        self.lanes.split_at_mut(i * self.stride)
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

    #[inline]
    pub(super) fn swap_rows(&mut self, i: usize, j: usize) {
        if i != j {
            let (upper, lower) = self.pair(i.min(j), i.max(j));
            upper.iter_mut().zip(lower).for_each(|(x, y)| std::mem::swap(x, y));
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
        let stride = self.stride;
        let (before, after) = self.lanes.split_at_mut(q * stride);
        (&mut before[p * stride..(p + 1) * stride], &mut after[..stride])
    }

    /// Adds a row; of the first one, its length is the number of columns.
    #[inline]
    pub fn push_row(&mut self, row: &[f64]) {
        if self.rows == 0 {
            (self.columns, self.stride) = (row.len(), groups(row.len()));
        }
        self.rows += 1;
        self.lanes.resize(self.rows * self.stride, [0.0; LANES]);
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

    /// Keeps the first `count` rows.
    #[inline]
    pub fn truncate(&mut self, count: usize) {
        self.rows = count;
        self.lanes.truncate(count * self.stride);
    }

    /// The first `count` rows.
    #[must_use]
    #[inline]
    pub fn first_rows(&self, count: usize) -> Self {
        let lanes = self.lanes[..count * self.stride].into();
        Self { rows: count, columns: self.columns, stride: self.stride, lanes }
    }

    /// Becomes A with its columns in another order.
    #[inline]
    pub(super) fn columns_in_order(&mut self, A: &Self, order: &[usize]) {
        self.reset(A.rows, A.columns);
        for i in 0..A.rows {
            self[i].iter_mut().zip(order).for_each(|(x, &column)| *x = A[i][column]);
        }
    }

    /// Keeps the columns from `first` on.
    #[inline]
    pub fn keep_columns_from(&mut self, first: usize) {
        let (columns, before) = (self.columns - first, self.stride);
        (self.columns, self.stride) = (columns, groups(columns));
        let (after, entries) = (self.stride, self.lanes.as_flattened_mut());
        for i in 0..self.rows {
            let (from, to) = (LANES * before * i + first, LANES * after * i);
            entries.copy_within(from..from + columns, to);
            entries[to + columns..to + LANES * after].fill(0.0);
        }
        self.lanes.truncate(self.rows * after);
    }

    /// Becomes A B.
    #[inline]
    pub fn become_product(&mut self, A: &Self, B: &Self) {
        self.reset(A.rows, B.columns);
        for i in 0..A.rows {
            add_rows(self.row_mut(i), &A[i], &B.lanes);
        }
    }

    /// Aᵀ x.
    #[inline]
    pub fn transposed_times(&self, x: &TaskVector) -> TaskVector {
        let mut product = TaskVector::zeros(self.columns);
        add_rows(product.lanes_mut(), x, &self.lanes);
        product
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
        rows_times(&self.lanes, x.lanes(), &mut product);
        product
    }
}

impl Mul for &TaskMatrix {
    type Output = TaskMatrix;

    #[inline]
    fn mul(self, other: Self) -> TaskMatrix {
        let mut product = TaskMatrix::default();
        product.become_product(self, other);
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
