//! Eigenvalues of small square matrices.

use faer::MatRef;
use nalgebra::Complex;

use super::Matrix;

/// The eigenvalues did not converge, which finite matrices are not known to cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the eigenvalue decomposition did not converge")]
pub struct EigenvalueError;

/// All eigenvalues of a square matrix, in no particular order.
pub fn eigenvalues(a: &Matrix) -> Result<Vec<Complex<f64>>, EigenvalueError> {
    let (m, n) = a.shape();
    let values = MatRef::from_column_major_slice(a.as_slice(), m, n).eigenvalues().map_err(|_| EigenvalueError)?;
    Ok(values.iter().map(|value| Complex::new(value.re, value.im)).collect())
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
