//! How much lag, delay and damping a loop permits.

use super::contact_loop::ContactLoop;
use super::search::{StableDamping, largest_delay, largest_lag, stable_dampings};
use super::stability_error::StabilityError;

/// The stability margins of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// Largest |eigenvalue| of the map from period to period. The loop is stable below 1.
    pub spectral_radius: f64,
    /// Maximum τ, s, at which the loop is stable with its delay; infinite if any; `None` if there is none. A loop that is unstable at a
    /// shorter τ needs a longer one.
    pub largest_lag_s: Option<f64>,
    /// The last d of the run of stable ones that has its own d, or else zero, up to [`MAX_DELAY_PERIODS`](super::MAX_DELAY_PERIODS); `None`
    /// if the loop is unstable at both. Other d may be stable again.
    pub largest_delay_periods: Option<usize>,
    /// Minimum B_d at which the loop is stable with its lag and delay; `None` if there is none.
    pub smallest_damping: Option<f64>,
    /// B_d above the minimum at which the loop becomes unstable again; `None` if there is no minimum, or no such B_d.
    pub largest_damping: Option<f64>,
}

impl Margin {
    /// Returns whether the loop is stable.
    pub fn is_stable(&self) -> bool {
        self.spectral_radius < 1.0
    }
}

impl ContactLoop {
    /// Computes the spectral radius and the margins. It computes the eigenvalues of the loop at most 750 times.
    pub fn margin(&self) -> Result<Margin, StabilityError> {
        self.margin_unless(&|| false)
    }

    /// Computes the spectral radius and the margins, and ends early with an error once `stop` returns true.
    pub fn margin_unless(&self, stop: &dyn Fn() -> bool) -> Result<Margin, StabilityError> {
        let is_stable = |axis: Self| if stop() { Err(StabilityError::Stopped) } else { Ok(axis.is_stable()?) };
        let dampings = stable_dampings(self.max_damping(), |damping| is_stable(Self { damping, ..*self }))?;
        Ok(Margin {
            spectral_radius: self.spectral_radius()?,
            largest_lag_s: largest_lag(self.period_s, self.lag_s, |lag_s| is_stable(Self { lag_s, ..*self }))?,
            largest_delay_periods: largest_delay(self.delay_periods, |delay_periods| {
                is_stable(Self { delay_periods, ..*self })
            })?,
            smallest_damping: dampings.map(|dampings| dampings.smallest),
            largest_damping: dampings.and_then(|dampings| dampings.largest),
        })
    }

    /// Computes the interval of B_d in which the loop is stable; `None` if no B_d is. The loop's own B_d does not matter.
    pub fn stable_dampings(&self) -> Result<Option<StableDamping>, StabilityError> {
        stable_dampings(self.max_damping(), |damping| Ok(Self { damping, ..*self }.is_stable()?))
    }

    /// Returns a B_d above which no loop is stable.
    ///
    /// In free space and without delay, B_d = 2 (1 + e)/(1 − e) M_d/T is the limit if the velocity is measured, with
    /// e = exp(−T/τ), and 2 M_d/T otherwise. (1 + e)/(1 − e) is at most 1 + 2τ/T.
    fn max_damping(&self) -> f64 {
        10.0 * self.inertia / self.period_s * (1.0 + 2.0 * self.lag_s / self.period_s)
    }
}
