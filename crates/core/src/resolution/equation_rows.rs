//! A copy of the rows of all equations.

use crate::linalg::{Matrix, distance_square, dot};
use crate::task::Task;

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

    /// Returns ‖A − A'‖_F and ‖A‖_F for the rows A of these tasks and the rows A' here; `None` if there are none here, if the
    /// sizes differ, or if a task is not an equation.
    pub fn compare(&self, tasks: &[Task]) -> Option<(f64, f64)> {
        let heights = tasks.iter().map(|task| if task.is_equation() { task.jacobian.nrows() } else { 0 });
        if self.heights.is_empty() || !heights.eq(self.heights.iter().copied()) {
            return None;
        }
        let (mut distance, mut square, mut rest) = (0.0, 0.0, self.entries.as_slice());
        for task in tasks {
            let entries = task.jacobian.as_slice();
            distance += distance_square(entries, rest.split_off(..entries.len())?);
            square += dot(entries, entries);
        }
        rest.is_empty().then(|| (f64::sqrt(distance), f64::sqrt(square)))
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
