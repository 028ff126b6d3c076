//! All inequalities of a problem as one list of rows.
#![allow(non_snake_case)]

use crate::limits::{Inequality, VelocityBox};
use crate::linalg::{TaskMatrix, TaskVector};

/// lower ≤ [x_1 … x_n; planes · x] ≤ upper: a row for each of the first n entries of x, the joints, then the planes,
/// whose rows have length 1 and no lower bound.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Constraints {
    joints: usize,
    planes: TaskMatrix,
    lower: TaskVector,
    upper: TaskVector,
}

impl Constraints {
    /// Becomes the box and the inequalities.
    pub fn become_those_of(&mut self, limits: &VelocityBox, inequalities: &[Inequality]) {
        self.joints = limits.joint_count();
        self.planes.reset(0, self.joints);
        self.lower = limits.lower().into();
        self.upper = limits.upper().into();
        for inequality in inequalities {
            // One without content has no length to be divided by.
            let norm = Some(inequality.coefficients().norm()).filter(|norm| *norm > 0.0).unwrap_or(1.0);
            let row = &TaskVector::from(inequality.coefficients()) * (1.0 / norm);
            self.push(&row, inequality.bound() / norm);
        }
    }

    /// Become no constraint on n joints.
    pub fn become_none(&mut self, n: usize) {
        self.joints = n;
        self.planes.reset(0, n);
        self.lower = TaskVector::from_fn(n, |_| f64::NEG_INFINITY);
        self.upper = TaskVector::from_fn(n, |_| f64::INFINITY);
    }

    /// Adds row · x ≤ bound; ‖row‖ = 1.
    pub fn push(&mut self, row: &[f64], bound: f64) {
        self.planes.push_row(row);
        self.lower.push(f64::NEG_INFINITY);
        self.upper.push(bound);
    }

    /// The same constraints on x with one more entry, which they leave alone.
    pub fn with_one_more_unknown(&self) -> Self {
        let (rows, n) = (self.planes.nrows(), self.planes.ncols());
        let planes = TaskMatrix::from_fn(rows, n + 1, |i, j| if j < n { self.planes[i][j] } else { 0.0 });
        Self { planes, ..self.clone() }
    }

    /// n, the number of rows that are joints.
    pub fn joints(&self) -> usize {
        self.joints
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.lower.len()
    }

    /// Lower bounds of the rows.
    pub fn lower(&self) -> &TaskVector {
        &self.lower
    }

    /// Upper bounds of the rows.
    pub fn upper(&self) -> &TaskVector {
        &self.upper
    }

    /// Writes the rows per column of a matrix of as many rows as x has entries.
    pub fn write_rows_of(&self, M: &TaskMatrix, rows: &mut TaskMatrix) {
        rows.copy_from(M);
        rows.truncate(self.joints);
        if self.planes.nrows() > 0 {
            rows.push_rows(&(&self.planes * M));
        }
    }

    /// The rows' values at x.
    pub fn values(&self, x: &TaskVector) -> TaskVector {
        if self.planes.nrows() == 0 {
            return x.clone();
        }
        x.first(self.joints).concatenated(&(&self.planes * x))
    }

    /// One row as a vector, of as many entries as x.
    pub fn row(&self, row: usize) -> TaskVector {
        if row < self.joints {
            TaskVector::from_fn(self.planes.ncols(), |i| f64::from(u8::from(i == row)))
        } else {
            self.planes.row_vector(row - self.joints)
        }
    }

    /// One row times a matrix.
    pub fn row_of(&self, row: usize, M: &TaskMatrix) -> TaskVector {
        if row < self.joints { M.row_vector(row) } else { M.transposed_times(&self.row(row)) }
    }

    /// x with its joints moved into their bounds.
    pub fn clamp_joints(&self, mut x: TaskVector) -> TaskVector {
        for (x, (lower, upper)) in x.iter_mut().zip(self.lower.iter().zip(self.upper.iter())).take(self.joints) {
            *x = x.max(*lower).min(*upper);
        }
        x
    }

    /// By how much the planes are exceeded at x, 0 where they are not.
    pub fn excess(&self, x: &TaskVector) -> TaskVector {
        let mut excess = &self.planes * x;
        excess.iter_mut().zip(&self.upper[self.joints..]).for_each(|(value, bound)| *value = (*value - bound).max(0.0));
        excess
    }

    /// Moves the bounds of planes that x exceeds to where x is.
    pub fn admit(&mut self, x: &TaskVector) {
        let values = &self.planes * x;
        for (plane, &value) in values.iter().enumerate() {
            let bound = &mut self.upper[self.joints + plane];
            *bound = bound.max(value);
        }
    }
}
