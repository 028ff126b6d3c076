//! All inequalities of a problem as one list of rows.
#![allow(non_snake_case)]

use crate::limits::{Inequality, VelocityBox};
use crate::linalg::{Matrix, Vector, concatenate, stack};
use crate::resolution::problem::Problem;

/// lower ≤ [x_1 … x_n; planes · x] ≤ upper: a row for each of the first n entries of x, the joints, then the planes,
/// whose rows have length 1 and no lower bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Constraints {
    joints: usize,
    planes: Matrix,
    lower: Vector,
    upper: Vector,
}

impl Constraints {
    /// The box and the inequalities.
    pub fn new(limits: &VelocityBox, inequalities: &[Inequality]) -> Self {
        let mut constraints = Self {
            joints: limits.joint_count(),
            planes: Matrix::zeros(0, limits.joint_count()),
            lower: limits.lower().clone(),
            upper: limits.upper().clone(),
        };
        for inequality in inequalities {
            // One without content has no length to be divided by.
            let norm = Some(inequality.coefficients().norm()).filter(|norm| *norm > 0.0).unwrap_or(1.0);
            constraints.push(&(inequality.coefficients() / norm), inequality.bound() / norm);
        }
        constraints
    }

    /// Those of a problem.
    pub fn of(problem: &Problem) -> Self {
        Self::new(&problem.limits, &problem.inequalities)
    }

    /// No constraint on n joints.
    pub fn none(n: usize) -> Self {
        Self::new(&VelocityBox::unbounded(n), &[])
    }

    /// Adds row · x ≤ bound; ‖row‖ = 1.
    pub fn push(&mut self, row: &Vector, bound: f64) {
        self.planes = stack(&self.planes, &Matrix::from_row_slice(1, row.len(), row.as_slice()));
        self.lower = concatenate(&self.lower, &Vector::from_element(1, f64::NEG_INFINITY));
        self.upper = concatenate(&self.upper, &Vector::from_element(1, bound));
    }

    /// The same constraints on x with one more entry, which they leave alone.
    pub fn with_one_more_unknown(&self) -> Self {
        let last = self.planes.ncols();
        Self { planes: self.planes.clone().insert_column(last, 0.0), ..self.clone() }
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
    pub fn lower(&self) -> &Vector {
        &self.lower
    }

    /// Upper bounds of the rows.
    pub fn upper(&self) -> &Vector {
        &self.upper
    }

    /// Rows per column of a matrix of as many rows as x has entries.
    pub fn rows_of(&self, M: &Matrix) -> Matrix {
        stack(&M.rows(0, self.joints).into_owned(), &(&self.planes * M))
    }

    /// The rows' values at x.
    pub fn values(&self, x: &Vector) -> Vector {
        concatenate(&x.rows(0, self.joints).into_owned(), &(&self.planes * x))
    }

    /// One row as a vector, of as many entries as x.
    pub fn row(&self, row: usize) -> Vector {
        if row < self.joints {
            Vector::from_fn(self.planes.ncols(), |i, _| f64::from(u8::from(i == row)))
        } else {
            self.planes.row(row - self.joints).transpose()
        }
    }

    /// x with its joints moved into their bounds.
    pub fn clamp_joints(&self, x: &Vector) -> Vector {
        Vector::from_fn(x.len(), |i, _| if i < self.joints { x[i].max(self.lower[i]).min(self.upper[i]) } else { x[i] })
    }

    /// By how much the planes are exceeded at x, 0 where they are not.
    pub fn excess(&self, x: &Vector) -> Vector {
        let bounds = self.upper.rows_range(self.joints..);
        (&self.planes * x - bounds).map(|excess| excess.max(0.0))
    }

    /// Moves the bounds of planes that x exceeds to where x is.
    pub fn admit(&mut self, x: &Vector) {
        let values = &self.planes * x;
        for (plane, &value) in values.iter().enumerate() {
            let bound = &mut self.upper[self.joints + plane];
            *bound = bound.max(value);
        }
    }
}
