//! The damping factors, from the formulas.

use revprio_problem::Damping;

/// Returns λ with λ² = (1 − (σ_min/δ)²) λ_max² for σ_min < δ, otherwise 0; 0 without damping.
///
/// Paper: Eqs. (18), (19). Departs: the paper squares twice; this is the usual form.
pub fn factor(damping: Option<Damping>, sigma_min: f64) -> f64 {
    let Some(damping) = damping else { return 0.0 };
    let squared = 1.0 - (sigma_min / damping.threshold()).powi(2);
    if squared > 0.0 { squared.sqrt() * damping.max_factor() } else { 0.0 }
}

/// Returns how much a task keeps the direction of a singular value from lower tasks, S(σ/σ_f) with σ_f the threshold of
/// fading; 1 without damping.
pub fn kept_share(damping: Option<Damping>, sigma: f64) -> f64 {
    damping.map_or(1.0, |damping| smoothstep(sigma / damping.fading_threshold()))
}

/// S(t) = t²(3 − 2t) for 0 ≤ t ≤ 1, 0 below, 1 above.
pub fn smoothstep(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns the ways to keep the directions of the `rank` largest singular values, with the share of the answer of each: all of
/// them, unless the smallest ones fade.
pub fn kept_directions(sigma: &[f64], rank: usize, damping: Option<Damping>) -> Vec<(usize, f64)> {
    // f_0 = 1, f_{r+1} = 0: the average Σ (f_i − f_{i+1}) y_i.
    let f = |i: usize| match i {
        0 => 1.0,
        i if i > rank => 0.0,
        i => kept_share(damping, sigma[i - 1]),
    };
    (0..=rank).rev().map(|kept| (kept, f(kept) - f(kept + 1))).filter(|(_, share)| *share > 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_is_zero_from_the_threshold_on_and_full_at_zero() {
        let damping = Some(Damping::STANDARD);
        assert_eq!([0.05, 1.0].map(|sigma| factor(damping, sigma)), [0.0, 0.0]);
        assert_eq!(factor(damping, 0.0), 0.1);
        assert!((factor(damping, 0.03).powi(2) - (1.0 - 0.36) * 0.01).abs() < 1e-15);
        assert_eq!(factor(None, 0.0), 0.0);
    }

    #[test]
    fn weak_directions_have_shares_that_add_up_to_one() {
        let shares = kept_directions(&[1.0, 0.006, 0.001], 3, Some(Damping::STANDARD));
        assert_eq!(shares.iter().map(|(kept, _)| *kept).collect::<Vec<_>>(), [3, 2, 1]);
        assert!((shares.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-15);
        assert_eq!(kept_directions(&[1.0, 0.006], 2, None), [(2, 1.0)]);
    }
}
