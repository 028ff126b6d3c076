//! Pseudo-inverses of 6 × 7 matrices: time and accuracy.

use std::f64::consts::FRAC_PI_6;

use nalgebra::{DMatrix, SMatrix};
use revprio_core::linalg::{Matrix, RANK_TOLERANCE, Svd};
use revprio_robot::built_in;
use revprio_robot::kinematics::Configuration;

use super::plain;
use super::postures::postures;
use crate::error::BenchError;
use crate::row::Row;
use crate::timing::{Budget, Subject, side_by_side};

pub fn rows(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let matrices = jacobians(256)?;
    let fixed: Vec<SMatrix<f64, 6, 7>> = matrices.iter().map(|j| SMatrix::from_column_slice(j.as_slice())).collect();
    let named = |name: &str, invert: fn(&DMatrix<f64>) -> DMatrix<f64>| {
        format!("{name}, error {:.0e}", largest_error(&matrices, invert))
    };
    let [mut ours, mut nalgebra, mut faer] = [(); 3].map(|()| matrices.iter().cycle());
    let mut fixed = fixed.iter().cycle();
    let times = side_by_side(
        budget,
        vec![
            Subject::new(named("pseudo-inverse 6 × 7", pseudo_inverse), || ours.next().map(pseudo_inverse)),
            Subject::new(named("nalgebra pseudo_inverse", plain::nalgebra_pseudo_inverse), || {
                nalgebra.next().map(plain::nalgebra_pseudo_inverse)
            }),
            Subject::new("nalgebra pseudo_inverse, static sizes", || fixed.next().map(|j| j.pseudo_inverse(1e-10))),
            Subject::new(named("faer svd, pseudoinverse", plain::pseudo_inverse), || {
                faer.next().map(plain::pseudo_inverse)
            }),
        ],
    )?;
    Ok(Row::against_each(&times))
}

/// Computes A⁺ with revprio.
fn pseudo_inverse(a: &Matrix) -> Matrix {
    let svd = Svd::new(a);
    svd.inverse(svd.rank(RANK_TOLERANCE * a.norm()), 0.0)
}

/// Returns Jacobians of Sawyer, a quarter of them at multiples of 30°, where singular values coincide.
fn jacobians(count: usize) -> Result<Vec<Matrix>, BenchError> {
    let round = |i: usize| [0, 1, 2, 3, 4, 5, 6].map(|j: usize| FRAC_PI_6 * ((i >> j) % 12) as f64);
    let special = (1..=count / 4).map(|i| round(i * 37));
    let jacobian = |q: [f64; 7]| {
        let configuration = Configuration::new(&built_in()[0], &q).map_err(BenchError::defect)?;
        Ok(Matrix::from_column_slice(6, 7, configuration.jacobian().as_slice()))
    };
    postures(count - count / 4).into_iter().chain(special).map(jacobian).collect()
}

/// Returns the largest ‖A A⁺ A − A‖ / ‖A‖, which is zero for every exact pseudo-inverse.
fn largest_error(matrices: &[Matrix], invert: fn(&DMatrix<f64>) -> DMatrix<f64>) -> f64 {
    let error = |a: &Matrix| (a * invert(a) * a - a).norm() / a.norm();
    matrices.iter().map(error).fold(0.0, f64::max)
}
