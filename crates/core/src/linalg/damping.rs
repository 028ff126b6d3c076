//! The variable damping factor of damped least squares.

use revprio_problem::Damping;

/// The damping factor as a function of the smallest singular value.
pub trait DampingFactor {
    /// Returns λ for a matrix whose smallest singular value is `sigma_min`: λ² = (1 − (σ_min/δ)²) λ_max² below δ, otherwise
    /// 0.
    ///
    /// Paper: Eqs. (18), (19). Departs: the paper squares twice; this is the usual form.
    fn factor(&self, sigma_min: f64) -> f64;

    /// Returns how much a task keeps the direction of a singular value from lower tasks: 0 at zero, 1 from
    /// [`Damping::fading_threshold`] on.
    fn keeps(&self, sigma: f64) -> f64;
}

impl DampingFactor for Damping {
    fn factor(&self, sigma_min: f64) -> f64 {
        let ratio = sigma_min / self.threshold();
        if ratio < 1.0 { self.max_factor() * (1.0 - ratio * ratio).sqrt() } else { 0.0 }
    }

    fn keeps(&self, sigma: f64) -> f64 {
        let ratio = (sigma / self.fading_threshold()).min(1.0);
        ratio * ratio * (3.0 - 2.0 * ratio)
    }
}

#[cfg(test)]
mod tests;
