//! The joint velocities that move tasks.

use nalgebra::{Dyn, MatrixView, U1};

use crate::linalg::Vector;

/// A row of a Jacobian, n.
type JacobianRow<'a> = MatrixView<'a, f64, U1, Dyn, U1, Dyn>;

/// Rows count as dependent if less than this share of them is new. Rounding leaves 1e-16, and a direction that is new by less than
/// 1e-6 would need joint speeds a million times those of its row.
const DEPENDENT: f64 = 1e-6;

/// Rows shorter than this share of the longest one have no direction but rounding.
const NO_DIRECTION: f64 = 1e-12;

/// An orthonormal basis of the rows of the Jacobians of some tasks. The rest of the joint velocities is their null space.
#[derive(Debug, Default)]
pub(super) struct RowSpace {
    /// The vectors of the basis, then memory for more, n each.
    basis: Vec<Vector>,
    rank: usize,
    /// Length of what is new in the row that depends most on the rows before it; infinite without rows.
    smallest: f64,
}

impl RowSpace {
    /// Computes the basis for rows over the same joints, by Gram-Schmidt.
    pub fn update<'a>(&mut self, rows: impl Iterator<Item = JacobianRow<'a>> + Clone) {
        (self.rank, self.smallest) = (0, f64::INFINITY);
        let longest = rows.clone().map(|row| row.norm()).fold(0.0, f64::max);
        for row in rows {
            if self.rank == self.basis.len() {
                self.basis.push(Vector::zeros(row.len()));
            }
            let (known, rest) = self.basis.split_at_mut(self.rank);
            let direction = &mut rest[0];
            direction.tr_copy_from(&row);
            let length = direction.norm();
            remove(known, direction);
            let new = direction.norm();
            self.smallest = self.smallest.min(new);
            if new > DEPENDENT * length && length > NO_DIRECTION * longest {
                *direction /= new;
                self.rank += 1;
            }
        }
    }

    /// Returns how independent the rows are: at least σ_min of the Jacobian, and small near its singularities.
    pub fn smallest(&self) -> f64 {
        self.smallest
    }

    /// Leaves of a joint velocity (n) the part in the null space of the tasks.
    pub fn remove_from(&self, velocity: &mut Vector) {
        remove(&self.basis[..self.rank], velocity);
    }
}

/// Removes the parts along orthonormal vectors.
fn remove(basis: &[Vector], velocity: &mut Vector) {
    for direction in basis {
        velocity.axpy(-direction.dot(velocity), direction, 1.0);
    }
}
