//! A copy of the rows of all equations.

use crate::{Matrix, Task};

/// The Jacobians of the tasks that are equations, one after the other.
#[derive(Debug, Clone, Default)]
pub struct EquationRows {
    /// Number of rows of each task.
    heights: Vec<usize>,
    /// The entries of each Jacobian, column by column.
    entries: Vec<f64>,
}

impl EquationRows {
    /// Removes all rows.
    pub fn clear(&mut self) {
        self.heights.clear();
        self.entries.clear();
    }

    /// Copies the rows of these tasks.
    pub fn set(&mut self, tasks: &[Task]) {
        self.clear();
        for task in tasks.iter().filter(|task| task.is_equation()) {
            self.heights.push(task.jacobian.nrows());
            self.entries.extend_from_slice(task.jacobian.as_slice());
        }
    }

    /// Returns the number of rows of each task.
    pub fn heights(&self) -> &[usize] {
        &self.heights
    }

    /// Returns the entries of each Jacobian, column by column.
    pub fn entries(&self) -> &[f64] {
        &self.entries
    }

    /// Returns the rows as a matrix.
    pub fn matrix(&self) -> Matrix {
        let rows: usize = self.heights.iter().sum();
        let mut matrix = Matrix::zeros(rows, self.entries.len() / rows.max(1));
        let (mut start, mut rest) = (0, self.entries.as_slice());
        for &height in &self.heights {
            let (own, others) = rest.split_at(height * matrix.ncols());
            matrix.rows_mut(start, height).copy_from_slice(own);
            (start, rest) = (start + height, others);
        }
        matrix
    }
}
