//! Eigenvalues of small square matrices.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, Schur};

use super::Matrix;

/// Sweeps per eigenvalue. Francis' method needs two or three.
const SWEEPS_PER_EIGENVALUE: usize = 100;

/// The eigenvalues did not converge. No finite matrix is known for which this happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the eigenvalue decomposition did not converge")]
pub struct EigenvalueError;

/// Returns all eigenvalues of a square matrix, in no particular order.
pub fn eigenvalues(a: &Matrix) -> Result<Vec<Complex<f64>>, EigenvalueError> {
    let mut balanced = a.clone();
    balance_parlett_reinsch(&mut balanced);
    let schur = Schur::try_new(balanced, f64::EPSILON, SWEEPS_PER_EIGENVALUE * a.nrows()).ok_or(EigenvalueError)?;
    Ok(schur.complex_eigenvalues().iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_has_the_eigenvalues_of_its_angle() {
        let (sin, cos) = 0.7_f64.sin_cos();
        let mut values = eigenvalues(&Matrix::from_row_slice(2, 2, &[cos, -sin, sin, cos])).unwrap();
        values.sort_by(|a, b| a.im.total_cmp(&b.im));
        assert!((values[1] - Complex::new(cos, sin)).norm() < 1e-14);
        assert!((values[0] - Complex::new(cos, -sin)).norm() < 1e-14);
    }
}
