//! Eigenvalues of small square matrices.

use nalgebra::{Complex, Schur};

use crate::linalg::Matrix;

/// Sweeps per eigenvalue. Francis' method needs two or three.
const SWEEPS_PER_EIGENVALUE: usize = 100;

/// Sweeps of balancing. A few are enough; each one is a similarity transformation, so that stopping early is harmless.
const BALANCING_SWEEPS: usize = 50;

/// The eigenvalues are not numbers, or did not converge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the eigenvalue decomposition did not converge")]
pub struct EigenvalueError;

/// Returns all eigenvalues of a square matrix, in no particular order. The number of steps is bounded for every input.
pub fn eigenvalues(a: &Matrix) -> Result<Vec<Complex<f64>>, EigenvalueError> {
    if !a.iter().all(|entry| entry.is_finite()) {
        return Err(EigenvalueError);
    }
    let mut balanced = a.clone();
    balance(&mut balanced);
    let schur = Schur::try_new(balanced, f64::EPSILON, SWEEPS_PER_EIGENVALUE * a.nrows()).ok_or(EigenvalueError)?;
    let values = eigenvalues_of_blocks(&schur.unpack().1);
    if values.iter().all(|value| value.re.is_finite() && value.im.is_finite()) {
        Ok(values)
    } else {
        Err(EigenvalueError)
    }
}

/// Returns the eigenvalues of a block triangular matrix with blocks of one or two rows.
///
/// nalgebra's own function returns NaN for a block whose two eigenvalues are equal up to rounding.
fn eigenvalues_of_blocks(blocks: &Matrix) -> Vec<Complex<f64>> {
    let (size, mut values, mut i) = (blocks.nrows(), Vec::with_capacity(blocks.nrows()), 0);
    while i < size {
        let first = blocks[(i, i)];
        if i + 1 == size || blocks[(i + 1, i)] == 0.0 {
            values.push(Complex::from(first));
            i += 1;
            continue;
        }
        let last = blocks[(i + 1, i + 1)];
        let (middle, half) = (0.5 * (first + last), 0.5 * (first - last));
        let square = half * half + blocks[(i, i + 1)] * blocks[(i + 1, i)];
        let root = Complex::from(square).sqrt();
        values.extend([middle + root, middle - root]);
        i += 2;
    }
    values
}

/// Scales rows and columns by powers of two, so that both have about the same norm. The eigenvalues stay the same.
///
/// This is the method of Parlett and Reinsch. Unlike nalgebra's function it ends for norms that overflow.
fn balance(a: &mut Matrix) {
    for _ in 0..BALANCING_SWEEPS {
        let mut changed = false;
        for i in 0..a.nrows() {
            let (column, row) = (a.column(i).norm(), a.row(i).norm());
            let factor = (0.5 * (row / column).log2()).round().exp2();
            let gains = (column * factor).hypot(row / factor) < 0.97 * column.hypot(row);
            if gains && factor.is_normal() && (1.0 / factor).is_normal() {
                a.column_mut(i).scale_mut(factor);
                a.row_mut(i).scale_mut(1.0 / factor);
                changed = true;
            }
        }
        if !changed {
            return;
        }
    }
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

    #[test]
    fn eigenvalues_of_badly_scaled_matrices_are_exact() {
        // Similar to [[2, 1], [1, 2]] by a diagonal matrix: eigenvalues 1 and 3.
        let mut values = eigenvalues(&Matrix::from_row_slice(2, 2, &[2.0, 1e30, 1e-30, 2.0])).unwrap();
        values.sort_by(|a, b| a.re.total_cmp(&b.re));
        assert!((values[0].re - 1.0).abs() < 1e-14 && (values[1].re - 3.0).abs() < 1e-14, "{values:?}");
    }

    #[test]
    fn blocks_with_equal_and_with_real_eigenvalues_have_eigenvalues() {
        for (entry, expected) in [(0.0, [1.0, 1.0]), (-1e-18, [1.0, 1.0]), (1e-18, [1.0, 1.0]), (0.25, [0.5, 1.5])] {
            let blocks = Matrix::from_row_slice(2, 2, &[1.0, 1.0, entry, 1.0]);
            let mut real: Vec<f64> = eigenvalues_of_blocks(&blocks).iter().map(|value| value.re).collect();
            real.sort_by(f64::total_cmp);
            assert!(real.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-8), "{real:?}");
        }
    }

    #[test]
    fn extreme_entries_end_with_eigenvalues_or_an_error() {
        for size in [1e-320, 1e-200, 1e-160, 1e160, 1e200, 1e308, f64::INFINITY, f64::NAN] {
            for other in [0.0, 1e-300, 1.0, 1e300] {
                let entries = [1.0, size, other, -size, other, 1.0, size, 0.0, -1.0];
                let values = eigenvalues(&Matrix::from_row_slice(3, 3, &entries));
                let finite = |values: Vec<Complex<f64>>| values.iter().all(|v| v.re.is_finite() && v.im.is_finite());
                assert!(values.is_err() || values.is_ok_and(finite), "{size} {other}");
            }
        }
    }
}
