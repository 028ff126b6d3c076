//! How near a matrix is to losing rank.
#![allow(non_snake_case)]

use super::{Damping, Decomposition, TaskMatrix, triangle};

/// Bound of σ_min, relative to the norm, above which a triangle gives it to some twelve digits.
const WELL_CONDITIONED: f64 = 1e-3;

/// The smallest singular value, as far as it is known, with the rank.
///
/// Far from a singularity a triangle of reflections encloses it: 1/‖L⁻¹‖_F ≤ σ_min. That is enough to know that nothing is
/// damped. Nearer, all singular values are computed.
#[derive(Debug, Clone, Default)]
pub struct Conditioning {
    rank: usize,
    /// L and L⁻¹ where they say enough.
    triangle: Option<[TaskMatrix; 2]>,
    /// σ_min and the product of all singular values, where they were computed.
    singular: [f64; 2],
}

impl Conditioning {
    /// Of the rows `A`, of which `triangle` is one with the same singular values where there is one.
    pub fn new(A: &TaskMatrix, triangle: Option<TaskMatrix>, damping: Option<Damping>) -> Self {
        let norm = A.norm();
        let bound = damping.map_or(0.0, |damping| damping.threshold()).max(WELL_CONDITIONED * norm);
        if let Some(L) = triangle {
            let inverse = triangle::inverse(&L);
            if 1.0 / inverse.norm() >= bound {
                return Self { rank: L.nrows(), triangle: Some([L, inverse]), singular: [0.0; 2] };
            }
        }
        let decomposition = Decomposition::singular(A, norm);
        let values = decomposition.singular_values();
        let product = values.iter().product::<f64>().min(f64::MAX);
        let singular = [decomposition.smallest(), product];
        Self { rank: decomposition.rank(), triangle: None, singular }
    }

    /// Number of singular values that count as non-zero.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// λ that `damping` gives at σ_min; 0 without damping.
    pub fn damping_factor(&self, damping: Option<Damping>) -> f64 {
        match damping {
            Some(damping) if self.triangle.is_none() => damping.factor(self.singular[0]),
            _ => 0.0,
        }
    }

    /// σ_min, the min(m, n)-th singular value; 0 for an empty matrix.
    pub fn smallest(&self) -> f64 {
        self.triangle.as_ref().map_or(self.singular[0], |[_, inverse]| 1.0 / triangle::spectral_norm(inverse))
    }

    /// Product of the singular values, √det(A Aᵀ) for m ≤ n; the largest number where the product is larger.
    pub fn manipulability(&self) -> f64 {
        let product = |L: &TaskMatrix| (0..L.nrows()).map(|i| L[i][i].abs()).product::<f64>().min(f64::MAX);
        self.triangle.as_ref().map_or(self.singular[1], |[L, _]| product(L))
    }
}
