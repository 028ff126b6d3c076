//! Rows of a task in comparable units.
//!
//! Linear rows of the tool are in m/s, angular ones in rad/s. With the characteristic length L the problem contains v/L in
//! place of v: a point at the distance L from an axis of rotation then moves with 1 for a rotation of 1 rad/s. Targets,
//! laws and answers are in m/s.

use super::controller_config::ControllerConfig;
use crate::law::TaskVector;
use crate::linalg::Matrix;

impl ControllerConfig {
    /// Returns the weight of a row of task `k`: 1/L for linear rows of the tool, 1 for others.
    pub(in crate::controller) fn weight(&self, k: usize, row: usize) -> f64 {
        if self.tasks[k].rows.is_linear(row) { 1.0 / self.characteristic_length_m } else { 1.0 }
    }

    /// Multiplies the rows of the Jacobian of task `k` by their weights.
    pub(in crate::controller) fn weigh_jacobian(&self, k: usize, jacobian: &mut Matrix) {
        if !self.is_unweighted() {
            for (row, mut entries) in jacobian.row_iter_mut().enumerate() {
                entries.scale_mut(self.weight(k, row));
            }
        }
    }

    /// Returns velocities of task `k`, one per row, times their weights.
    pub(in crate::controller) fn weighed(&self, k: usize, velocity: &[f64]) -> TaskVector {
        if self.is_unweighted() {
            return TaskVector::from_slice(velocity);
        }
        TaskVector::from_fn(velocity.len(), |row| velocity[row] * self.weight(k, row))
    }

    /// Returns whether all weights are 1.
    #[expect(clippy::float_cmp, reason = "any other length changes numbers")]
    pub(in crate::controller) fn is_unweighted(&self) -> bool {
        self.characteristic_length_m == 1.0
    }
}
