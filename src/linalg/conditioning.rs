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
    /// Whether L⁻¹ says enough; else σ_min was computed.
    is_regular: bool,
    /// L⁻¹.
    inverse: TaskMatrix,
    smallest: f64,
    product: f64,
    /// Room to work in.
    room: TaskMatrix,
    decomposition: Decomposition,
}

impl Conditioning {
    /// Becomes that of [A; B], whose Frobenius norm is `norm`.
    ///
    /// `own` decomposes A, and `next` what B is in the frame of A, `below`, from the first open coordinate on.
    pub fn update(
        &mut self,
        [A, B]: [&TaskMatrix; 2],
        norm: f64,
        own: &Decomposition,
        (below, next): (&TaskMatrix, &Decomposition),
        damping: Option<Damping>,
    ) {
        let bound = damping.map_or(0.0, |damping| damping.threshold()).max(WELL_CONDITIONED * norm);
        if own.write_triangle(below, next, &mut self.inverse) {
            self.rank = self.inverse.nrows();
            self.product = (0..self.rank).map(|i| self.inverse[i][i].abs()).product();
            triangle::invert(&mut self.inverse);
            self.is_regular = 1.0 / self.inverse.norm() >= bound;
            if self.is_regular {
                return;
            }
        }
        self.is_regular = false;
        self.room.copy_from(A);
        self.room.push_rows(B);
        self.decomposition.decompose_singular(&self.room, 0, norm);
        self.rank = self.decomposition.rank();
        self.smallest = self.decomposition.smallest();
        self.product = self.decomposition.singular_values().iter().product();
    }

    /// Whether the rows are independent, far from losing rank and above the threshold of damping.
    pub fn is_regular(&self) -> bool {
        self.is_regular
    }

    /// Number of singular values that count as non-zero.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// λ that `damping` gives at σ_min; 0 without damping.
    pub fn damping_factor(&self, damping: Option<Damping>) -> f64 {
        match damping {
            Some(damping) if !self.is_regular => damping.factor(self.smallest),
            _ => 0.0,
        }
    }

    /// σ_min, the min(m, n)-th singular value; 0 for an empty matrix.
    pub fn smallest(&mut self) -> f64 {
        if self.is_regular { 1.0 / triangle::spectral_norm(&self.inverse, &mut self.room) } else { self.smallest }
    }

    /// Product of the singular values, √det(A Aᵀ) for m ≤ n; the largest number where the product is larger.
    pub fn manipulability(&self) -> f64 {
        self.product.min(f64::MAX)
    }
}
