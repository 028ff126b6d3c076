//! How near the tasks are to singularities.

use crate::{EquationRows, Matrix, Task};

/// Computes σ_min and the product of the singular values of all rows.
type Compute = fn(&Matrix) -> (f64, f64);

/// How near the tasks are to singularities. Inequality tasks do not count.
///
/// No decision of a resolution needs the values where they are far from zero, so they can be computed on demand.
#[derive(Debug, Clone, Default)]
pub struct Singularity {
    /// Whether a task depends on lower ones although neither is singular by itself. Paper: Eq. (12).
    pub algorithmic: bool,
    /// σ_min and the product of the singular values where they are known; otherwise they are computed from `rows`.
    known: Option<(f64, f64)>,
    /// The rows of all equations.
    rows: EquationRows,
    compute: Option<Compute>,
}

impl Singularity {
    /// Returns σ_min of all rows together; 0 without rows.
    pub fn smallest_singular_value(&self) -> f64 {
        self.values().0
    }

    /// Returns the product of the singular values of all rows together; 0 without rows.
    pub fn manipulability(&self) -> f64 {
        self.values().1
    }

    /// Returns [`Self::smallest_singular_value`] and [`Self::manipulability`].
    pub fn values(&self) -> (f64, f64) {
        let computed = || self.compute.map_or((0.0, 0.0), |compute| compute(&self.rows.matrix()));
        let (smallest, product) = self.known.unwrap_or_else(computed);
        // ∞ · 0 is no number.
        (smallest, if smallest == 0.0 { 0.0 } else { product.min(f64::MAX) })
    }

    /// Sets σ_min and the product of the singular values.
    pub fn set(&mut self, smallest: f64, product: f64) {
        self.known = Some((smallest, product));
    }

    /// Sets the rows that σ_min and the product of the singular values belong to, and the function that computes them.
    pub fn set_rows(&mut self, tasks: &[Task], compute: Compute) {
        self.known = None;
        self.rows.set(tasks);
        self.compute = Some(compute);
    }
}

impl PartialEq for Singularity {
    fn eq(&self, other: &Self) -> bool {
        (self.algorithmic, self.values()) == (other.algorithmic, other.values())
    }
}
