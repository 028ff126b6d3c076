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
mod tests {
    use super::*;

    #[test]
    fn damping_is_zero_at_and_above_the_threshold_and_full_at_zero() {
        let damping = Damping::STANDARD;
        assert_eq!(damping.factor(0.05), 0.0);
        assert_eq!(damping.factor(1.0), 0.0);
        assert_eq!(damping.factor(0.0), 0.1);
        assert!(damping.factor(0.05 - 1e-9) > 0.0);
        assert!((damping.factor(0.03).powi(2) - (1.0 - 0.36) * 0.01).abs() < 1e-15);
    }
}
