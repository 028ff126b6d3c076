//! How near a matrix is to losing rank.
#![allow(non_snake_case)]

use super::{Damping, Decomposition, TaskMatrix, triangle};

/// Bound of σ_min, relative to the norm, above which a triangle gives it to some twelve digits.
const WELL_CONDITIONED: f64 = 1e-3;

/// A decomposition that knows how near its matrix is to losing rank.
///
/// Far from a singularity a triangle of reflections encloses the smallest singular value: 1/‖L⁻¹‖_F ≤ σ_min. That is enough
/// to know that nothing is damped. Nearer, the matrix is decomposed by singular values.
#[derive(Debug, Clone, Default)]
pub struct Conditioning {
    decomposition: Decomposition,
    /// Whether L⁻¹ says enough.
    is_regular: bool,
    /// L⁻¹.
    inverse: TaskMatrix,
    product: f64,
    /// Room to work in.
    room: TaskMatrix,
}

impl Conditioning {
    /// Becomes that of A, whose Frobenius norm is `norm`.
    pub fn update(&mut self, A: &TaskMatrix, norm: f64, damping: Option<Damping>) {
        let Self { decomposition, inverse, .. } = self;
        let bound = damping.map_or(0.0, |damping| damping.threshold()).max(WELL_CONDITIONED * norm);
        decomposition.decompose(A, 0, norm);
        self.is_regular = decomposition.write_triangle(inverse) && {
            self.product = (0..inverse.nrows()).map(|i| inverse[i][i].abs()).product();
            triangle::invert(inverse);
            1.0 / inverse.norm() >= bound
        };
        if !self.is_regular {
            decomposition.decompose_singular(A, 0, norm);
            self.product = decomposition.singular_values().iter().product();
        }
    }

    /// The decomposition, by singular values unless the matrix is regular.
    pub fn decomposition(&self) -> &Decomposition {
        &self.decomposition
    }

    /// Whether the rows are independent, far from losing rank and above the threshold of damping.
    pub fn is_regular(&self) -> bool {
        self.is_regular
    }

    /// λ that `damping` gives at σ_min; 0 without damping.
    pub fn damping_factor(&self, damping: Option<Damping>) -> f64 {
        match damping {
            Some(damping) if !self.is_regular => damping.factor(self.decomposition.smallest()),
            _ => 0.0,
        }
    }

    /// σ_min, the min(m, n)-th singular value; 0 for an empty matrix.
    pub fn smallest(&mut self) -> f64 {
        if self.is_regular {
            1.0 / triangle::spectral_norm(&self.inverse, &mut self.room)
        } else {
            self.decomposition.smallest()
        }
    }

    /// Product of the singular values, √det(A Aᵀ) for m ≤ n; the largest number where the product is larger.
    pub fn manipulability(&self) -> f64 {
        self.product.min(f64::MAX)
    }
}
