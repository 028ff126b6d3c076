//! Singular value decomposition with a rank decision.

use faer::MatRef;

use super::{Damping, Matrix, Vector};

/// Singular values below this fraction of the matrix's Frobenius norm count as zero; of a product A N with an
/// orthonormal N, below this fraction of the norm of A.
///
/// Rounding in a product of task matrices leaves some 1e-15 of the scale, and rows that an engineer calls
/// independent differ by far more than 1e-8; the decision sits between.
pub const RANK_TOLERANCE: f64 = 1e-10;

/// Matrices smaller than this have rank zero.
const SMALLEST_SCALE: f64 = 1e-140;

/// The decomposition did not converge, neither of the matrix nor of its transpose; no finite matrix is known to do so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the singular value decomposition did not converge")]
pub struct SvdError;

/// A = U Σ Vᵀ, with the rank decided once.
///
/// Paper: Eqs. (16), (17).
#[derive(Debug, Clone)]
pub struct Svd {
    u: Matrix,
    sigma: Vec<f64>,
    v: Matrix,
    rank: usize,
}

impl Svd {
    /// Decomposes `a` (m × n, either may be zero); rank relative to its own norm.
    pub fn new(a: &Matrix) -> Result<Self, SvdError> {
        Self::with_scale(a, a.norm())
    }

    /// Decomposes `a`; rank relative to `scale`.
    ///
    /// A product like J_2 N, whose rows may be pure rounding, takes the norm of J_2.
    pub fn with_scale(a: &Matrix, scale: f64) -> Result<Self, SvdError> {
        let Factors { u, sigma, v } = decompose(a).or_else(|_| Ok(decompose(&a.transpose())?.transposed()))?;
        // The norm of rows below some 1e-154 underflows to zero: such rows count as zero themselves.
        let cut = RANK_TOLERANCE * scale.max(SMALLEST_SCALE);
        Ok(Self { u, rank: sigma.iter().filter(|&&s| s > cut).count(), sigma, v })
    }

    /// Number of singular values that count as non-zero.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// All min(m, n) singular values, largest first.
    pub fn singular_values(&self) -> &[f64] {
        &self.sigma
    }

    /// σ_min, the min(m, n)-th singular value; 0 for an empty matrix.
    pub fn smallest(&self) -> f64 {
        self.sigma.last().copied().unwrap_or(0.0)
    }

    /// σ_max; 0 for an empty matrix.
    pub fn largest(&self) -> f64 {
        self.sigma.first().copied().unwrap_or(0.0)
    }

    /// Product of the singular values, √det(A Aᵀ) for m ≤ n; the largest number where the product is larger.
    pub fn manipulability(&self) -> f64 {
        self.sigma.iter().product::<f64>().min(f64::MAX)
    }

    /// λ that `damping` gives at σ_min; 0 without damping.
    pub fn damping_factor(&self, damping: Option<Damping>) -> f64 {
        damping.map_or(0.0, |damping| damping.factor(self.smallest()))
    }

    /// A⁺ b: the shortest x that minimises ‖A x − b‖.
    pub fn solve(&self, b: &Vector) -> Vector {
        self.damped_solve(b, 0.0)
    }

    /// Aᵀ(A Aᵀ + λ² I)⁻¹ b, which is A⁺ b for λ = 0: the x that minimises ‖A x − b‖² + λ² ‖x‖².
    ///
    /// Paper: Eqs. (15), (18).
    pub fn damped_solve(&self, b: &Vector, lambda: f64) -> Vector {
        let mut x = Vector::zeros(self.v.nrows());
        for (i, &sigma) in self.sigma.iter().enumerate().take(self.rank) {
            let gain = sigma / (sigma * sigma + lambda * lambda);
            x.axpy(gain * self.u.column(i).dot(b), &self.v.column(i), 1.0);
        }
        x
    }

    /// A A⁺ b − A x for the damped x of [`Svd::damped_solve`]: what damping gives up of the reachable part of b.
    pub fn damping_loss(&self, b: &Vector, lambda: f64) -> Vector {
        let mut loss = Vector::zeros(self.u.nrows());
        for (i, &sigma) in self.sigma.iter().enumerate().take(self.rank) {
            let share = lambda * lambda / (sigma * sigma + lambda * lambda);
            loss.axpy(share * self.u.column(i).dot(b), &self.u.column(i), 1.0);
        }
        loss
    }

    /// A⁺, n × m.
    pub fn pseudo_inverse(&self) -> Matrix {
        let mut inverse = Matrix::zeros(self.v.nrows(), self.u.nrows());
        for (i, &sigma) in self.sigma.iter().enumerate().take(self.rank) {
            inverse.ger(1.0 / sigma, &self.v.column(i), &self.u.column(i), 1.0);
        }
        inverse
    }

    /// An orthonormal basis of {A x}, m × rank.
    pub fn range(&self) -> Matrix {
        self.u.columns_range(..self.rank).into_owned()
    }

    /// An orthonormal basis of {x : A x = 0}, n × (n − rank).
    pub fn null_space(&self) -> Matrix {
        self.v.columns_range(self.rank..).into_owned()
    }
}

/// U, the singular values in descending order, V.
struct Factors {
    u: Matrix,
    sigma: Vec<f64>,
    v: Matrix,
}

impl Factors {
    fn transposed(self) -> Self {
        Self { u: self.v, sigma: self.sigma, v: self.u }
    }
}

/// One in some 10⁸ matrices of task size does not converge; its transpose then does.
fn decompose(a: &Matrix) -> Result<Factors, SvdError> {
    let (m, n) = a.shape();
    let svd = MatRef::from_column_major_slice(a.as_slice(), m, n).svd().map_err(|_| SvdError)?;
    Ok(Factors {
        u: Matrix::from_fn(m, m, |i, j| svd.U()[(i, j)]),
        sigma: svd.S().column_vector().iter().copied().collect(),
        v: Matrix::from_fn(n, n, |i, j| svd.V()[(i, j)]),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_matrix_that_only_its_transpose_decomposes_is_decomposed() {
        let row = [
            0.075_745_780_072_727_1,
            -0.537_888_331_430_944_6,
            -0.599_217_202_747_414_4,
            -0.055_647_383_717_284_16,
            0.496_452_656_519_369_3,
        ];
        let unit = [0, 1, 2, 4];
        let a = Matrix::from_fn(5, 5, |i, j| if i < 4 { f64::from(u8::from(unit[i] == j)) } else { row[j] });
        assert!(decompose(&a).is_err(), "a newer faer decomposes it: the detour may go");
        let svd = Svd::new(&a).unwrap();
        assert!((svd.pseudo_inverse() * &a - Matrix::identity(5, 5)).amax() < 1e-13);
    }

    fn any_matrix() -> impl Strategy<Value = Matrix> {
        (1..8_usize, 1..8_usize, 0..4_usize).prop_flat_map(|(m, n, dependent)| {
            prop::collection::vec(-1.0..1.0_f64, m * n).prop_map(move |entries| {
                let mut a = Matrix::from_vec(m, n, entries);
                for row in 0..dependent.min(m - 1) {
                    let copy = a.row(row + 1) * -0.5;
                    a.set_row(row, &copy);
                }
                a
            })
        })
    }

    proptest! {
        #[test]
        fn pseudo_inverse_satisfies_the_four_penrose_conditions(a in any_matrix()) {
            let p = Svd::new(&a).unwrap().pseudo_inverse();
            let scale = 1.0 + p.norm() * p.norm();
            prop_assert!((&a * &p * &a - &a).norm() < 1e-12 * scale);
            prop_assert!((&p * &a * &p - &p).norm() < 1e-12 * scale);
            prop_assert!((&a * &p - (&a * &p).transpose()).norm() < 1e-12 * scale);
            prop_assert!((&p * &a - (&p * &a).transpose()).norm() < 1e-12 * scale);
        }

        #[test]
        fn null_space_is_orthonormal_complete_and_annihilated(a in any_matrix()) {
            let svd = Svd::new(&a).unwrap();
            let n = svd.null_space();
            prop_assert_eq!(n.ncols() + svd.rank(), a.ncols());
            prop_assert!((&a * &n).norm() < 1e-12);
            prop_assert!((n.transpose() * &n - Matrix::identity(n.ncols(), n.ncols())).norm() < 1e-12);
        }

        #[test]
        fn damped_solution_satisfies_its_normal_equations(a in any_matrix(), lambda in 0.01..1.0_f64) {
            let b = Vector::from_fn(a.nrows(), |i, _| i as f64 - 1.5);
            let x = Svd::new(&a).unwrap().damped_solve(&b, lambda);
            let gradient = a.transpose() * (&a * &x - &b) + x * (lambda * lambda);
            prop_assert!(gradient.norm() < 1e-12 * (1.0 + b.norm()));
        }
    }

    #[test]
    fn rank_is_relative_to_the_scale() {
        let diagonal = |s: f64| Matrix::from_diagonal(&Vector::from_vec(vec![1.0, s]));
        assert_eq!(Svd::new(&diagonal(1.1e-10)).unwrap().rank(), 2);
        assert_eq!(Svd::new(&diagonal(0.9e-10)).unwrap().rank(), 1);
        assert_eq!(Svd::new(&(diagonal(0.5) * 1e-30)).unwrap().rank(), 2);
        assert_eq!(Svd::new(&(diagonal(0.5) * 1e-200)).unwrap().rank(), 0);
        assert_eq!(Svd::with_scale(&(diagonal(0.5) * 1e-15), 1.0).unwrap().rank(), 0);
    }

    #[test]
    fn empty_matrices_have_rank_zero_and_a_full_null_space() {
        let none = Svd::new(&Matrix::zeros(0, 3)).unwrap();
        assert_eq!((none.rank(), none.null_space()), (0, Matrix::identity(3, 3)));
        assert_eq!(Svd::new(&Matrix::zeros(2, 0)).unwrap().solve(&Vector::zeros(2)).len(), 0);
    }

    #[test]
    fn coinciding_singular_values_are_harmless() {
        let a = Matrix::from_row_slice(2, 3, &[0.0, 2.0, 0.0, 0.0, 0.0, -2.0]);
        assert!((&a * Svd::new(&a).unwrap().pseudo_inverse() - Matrix::identity(2, 2)).norm() < 1e-15);
    }
}
