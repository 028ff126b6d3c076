//! Pseudo-inverses whose rank is decided at a stated tolerance, and their damped relatives.
//!
//! [`Matrix`] and [`Vector`] stand in what the crate takes and gives. What is computed with in every period is a
//! [`TaskMatrix`] or [`TaskVector`], which need no heap at the size of a task.

mod conditioning;
mod damping;
mod decomposition;
mod lanes;
mod reflections;
mod singular;
mod spectrum;
mod task_matrix;
mod task_vector;
#[cfg(test)]
mod tests;
mod triangle;

pub use conditioning::Conditioning;
pub use damping::Damping;
pub use decomposition::{Decomposition, RANK_TOLERANCE};
pub use spectrum::{EigenvalueError, eigenvalues};
pub use task_matrix::TaskMatrix;
pub use task_vector::TaskVector;

/// A matrix of any shape.
pub type Matrix = nalgebra::DMatrix<f64>;
/// A column of any length.
pub type Vector = nalgebra::DVector<f64>;

/// Puts `top` over `bottom`; both have the same number of columns.
pub fn stack(top: &Matrix, bottom: &Matrix) -> Matrix {
    let mut stacked = Matrix::zeros(top.nrows() + bottom.nrows(), top.ncols());
    stacked.rows_mut(0, top.nrows()).copy_from(top);
    stacked.rows_mut(top.nrows(), bottom.nrows()).copy_from(bottom);
    stacked
}

/// Puts `top` over `bottom`.
pub fn concatenate(top: &Vector, bottom: &Vector) -> Vector {
    Vector::from_iterator(top.len() + bottom.len(), top.iter().chain(bottom.iter()).copied())
}
