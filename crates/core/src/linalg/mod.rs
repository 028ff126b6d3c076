//! The linear algebra that is not in nalgebra: padded rows, singular values that are right where they coincide, the smallest
//! singular value of a triangle, damping, eigenvalues with a bound on the steps.

mod damping;
mod row;
mod spectrum;
mod svd;
mod task_vector;
mod triangle;

pub use damping::Damping;
pub use row::Row;
pub use spectrum::{EigenvalueError, eigenvalues};
pub use svd::{Svd, write_singular_values};
pub use task_vector::TaskVector;
pub use triangle::Triangle;

/// Singular values below this fraction of a matrix's Frobenius norm count as zero.
pub const RANK_TOLERANCE: f64 = 1e-10;

/// A matrix of any shape.
pub type Matrix = nalgebra::DMatrix<f64>;
/// A column of any length.
pub type Vector = nalgebra::DVector<f64>;

/// Puts `top` over `bottom`. Both have the same number of columns.
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
