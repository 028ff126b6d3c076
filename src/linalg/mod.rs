//! Pseudo-inverses whose rank is decided at a stated tolerance, and their damped relatives.
//!
//! Matrices are dynamic (`DMatrix`), because the number of joints and of task rows is data.

mod damping;
mod spectrum;
mod svd;

pub use damping::Damping;
pub use spectrum::{EigenvalueError, eigenvalues};
pub use svd::{RANK_TOLERANCE, Svd, SvdError};

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
