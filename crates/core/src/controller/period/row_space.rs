//! The joint velocities that move tasks.

use crate::linalg::Vector;
use crate::task::Task;

/// Rows count as dependent if less than this share of them is new. Rounding leaves 1e-16, and a direction that is new by less than
/// 1e-6 would need joint speeds a million times those of its row.
const DEPENDENT: f64 = 1e-6;

/// An orthonormal basis of the rows of the Jacobians of some tasks. The rest of the joint velocities is their null space.
#[derive(Debug, Default)]
pub(super) struct RowSpace {
    /// The vectors of the basis, then memory for more, n each.
    basis: Vec<Vector>,
    rank: usize,
    /// Length of what is new in the row that depends most on the rows before it; infinite without rows. Zero rows do not count.
    smallest: f64,
}

impl RowSpace {
    /// Computes the basis for tasks over the same joints, by Gram-Schmidt.
    pub fn update<'a>(&mut self, tasks: impl IntoIterator<Item = &'a Task>) {
        (self.rank, self.smallest) = (0, f64::INFINITY);
        for row in tasks.into_iter().flat_map(|task| task.jacobian.row_iter()) {
            if self.rank == self.basis.len() {
                self.basis.push(Vector::zeros(row.len()));
            }
            let (known, rest) = self.basis.split_at_mut(self.rank);
            let direction = &mut rest[0];
            direction.tr_copy_from(&row);
            let length = direction.norm();
            remove(known, direction);
            let new = direction.norm();
            if length > 0.0 {
                self.smallest = self.smallest.min(new);
            }
            if new > DEPENDENT * length {
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
