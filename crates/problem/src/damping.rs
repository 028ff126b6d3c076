//! The parameters of damping near singularities.

/// Fraction of δ below which a task gradually leaves the direction of a singular value to lower tasks.
const FADING: f64 = 0.25;

/// Longest reaction time of a control loop for which [`FADING`] is wide enough, s.
const FADING_REACTION: f64 = 0.005;

/// The parameters of the damping that sets in near a singularity.
///
/// With the smallest singular value σ_min, the damping factor is λ² = (1 − (σ_min/δ)²) λ_max² for σ_min < δ, otherwise 0.
/// Each solver evaluates this formula itself.
///
/// Paper: Eqs. (18), (19). Departs: the paper squares twice; this is the usual form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Damping {
    threshold: f64,
    max_factor: f64,
    fading: f64,
}

impl Damping {
    /// δ = 0.05, λ_max = 0.1: the values of the paper's singular scenarios.
    pub const STANDARD: Self = Self { threshold: 0.05, max_factor: 0.1, fading: FADING };
    /// δ = λ_max = 0.15: the default of controllers, for arms with a reach of about 1 m. `docs/guides/choose-damping.md`
    /// has the measurements.
    pub const ARM: Self = Self { threshold: 0.15, max_factor: 0.15, fading: FADING };

    /// Damping below the singular value `threshold` (δ > 0), at most `max_factor` (λ_max ≥ 0);
    /// `None` if either is out of range or not finite.
    pub fn new(threshold: f64, max_factor: f64) -> Option<Self> {
        let valid = threshold.is_finite() && threshold > 0.0 && max_factor.is_finite() && max_factor >= 0.0;
        valid.then_some(Self { threshold, max_factor, fading: FADING })
    }

    /// Returns the damping of a loop that reacts after this time (s): beyond 5 ms directions fade over a range that grows with
    /// it, up to δ. In a narrower one the velocity of an arm that is held back at a singularity would change faster with the
    /// posture than the loop can follow, so that the arm would move back and forth.
    #[must_use]
    pub fn for_reaction(self, reaction: f64) -> Self {
        Self { fading: FADING * (reaction / FADING_REACTION).clamp(1.0, 1.0 / FADING), ..self }
    }

    /// δ, the singular value below which damping acts.
    pub fn threshold(&self) -> f64 {
        self.threshold
    }

    /// λ_max, the damping factor at a singular value of zero.
    pub fn max_factor(&self) -> f64 {
        self.max_factor
    }

    /// The singular value below which a task gradually leaves its direction to lower tasks: a quarter of δ, or what
    /// [`Self::for_reaction`] says.
    pub fn fading_threshold(&self) -> f64 {
        self.fading * self.threshold
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_dampings_do_not_exist() {
        for (threshold, factor) in [(0.0, 0.1), (-1.0, 0.1), (0.05, -0.1), (f64::NAN, 0.1), (0.05, f64::INFINITY)] {
            assert!(Damping::new(threshold, factor).is_none());
        }
    }

    #[test]
    fn slow_loops_fade_over_at_most_the_whole_threshold() {
        let fading = |reaction| Damping::STANDARD.for_reaction(reaction).fading_threshold() / 0.05;
        for (reaction, expected) in [(0.0, 0.25), (0.005, 0.25), (0.01, 0.5), (1.0, 1.0)] {
            assert!((fading(reaction) - expected).abs() < 1e-15);
        }
    }
}
