//! Searches for the boundaries of stability. The number of tests of each is bounded.

use super::stability_error::StabilityError;

/// Maximum delay that is examined, periods. The computation time grows with its cube.
pub const MAX_DELAY_PERIODS: usize = 64;

/// The interval of B_d in which a loop is stable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StableDamping {
    /// Minimum B_d.
    pub smallest: f64,
    /// B_d above the minimum at which the loop becomes unstable again; `None` if there is none.
    pub largest: Option<f64>,
}

/// Relative accuracy of the margins.
const ACCURACY: f64 = 1e-9;

/// Bisections of a margin. About 30 reach the accuracy; a boundary at zero ends here.
pub(super) const MAX_BISECTIONS: usize = 100;

/// Steps by 1.25 from 10⁻³ to 10⁹ periods: 124.
pub(super) const MAX_LAG_STEPS: usize = 200;

/// Steps by 1.1 from 10⁻⁹ of the largest examined damping to the largest: 218.
pub(super) const MAX_DAMPING_STEPS: usize = 300;

/// Returns the maximum lag, s, from a test of one lag: that of the interval of stable lags with the `stated` one, or else of the
/// first interval. The number of tests is bounded whatever the test returns.
pub(super) fn largest_lag(
    period_s: f64,
    stated: f64,
    with_lag: impl Fn(f64) -> Result<bool, StabilityError>,
) -> Result<Option<f64>, StabilityError> {
    let mut stable = first_stable([stated, 0.0], &with_lag)?;
    let mut lag = (1.25 * stable.unwrap_or(0.0)).max(period_s * 1e-3);
    // No inner loop has a lag of 10^9 periods. If such a lag is stable, every lag counts as stable.
    for _ in 0..MAX_LAG_STEPS {
        match (stable, with_lag(lag)?) {
            (Some(stable), false) => return bisect(stable, lag, with_lag).map(Some),
            (None, false) => {}
            (_, true) => stable = Some(lag),
        }
        if lag > 1e9 * period_s {
            break;
        }
        lag *= 1.25;
    }
    Ok(stable.map(|_| f64::INFINITY))
}

/// Returns the maximum delay, periods, from a test of one delay: that of the interval of stable delays with the `stated` one, or else
/// with zero.
pub(super) fn largest_delay(
    stated: usize,
    with_delay: impl Fn(usize) -> Result<bool, StabilityError>,
) -> Result<Option<usize>, StabilityError> {
    let Some(mut stable) = first_stable([stated, 0], &with_delay)? else { return Ok(None) };
    // One by one: odd delays may be stable and even ones not.
    while stable < MAX_DELAY_PERIODS && with_delay(stable + 1)? {
        stable += 1;
    }
    Ok(Some(stable))
}

/// Returns the first of two values that is stable.
fn first_stable<T: Copy>(
    values: [T; 2],
    is_stable: impl Fn(T) -> Result<bool, StabilityError>,
) -> Result<Option<T>, StabilityError> {
    for value in values {
        if is_stable(value)? {
            return Ok(Some(value));
        }
    }
    Ok(None)
}

/// Returns the stable dampings from a test of one damping. The number of tests is bounded whatever the test returns.
pub(super) fn stable_dampings(
    maximum: f64,
    with_damping: impl Fn(f64) -> Result<bool, StabilityError>,
) -> Result<Option<StableDamping>, StabilityError> {
    let mut smallest = with_damping(0.0)?.then_some(0.0);
    let (mut last, mut damping) = (0.0, 1e-9 * maximum);
    for _ in 0..MAX_DAMPING_STEPS {
        if damping >= maximum {
            break;
        }
        match (smallest, with_damping(damping)?) {
            (None, true) => smallest = Some(bisect(damping, last, &with_damping)?),
            (Some(smallest), false) => {
                let largest = Some(bisect(last, damping, &with_damping)?);
                return Ok(Some(StableDamping { smallest, largest }));
            }
            (None, false) | (Some(_), true) => {}
        }
        (last, damping) = (damping, 1.1 * damping);
    }
    Ok(smallest.map(|smallest| StableDamping { smallest, largest: None }))
}

/// Returns the stable side of the boundary between a stable and an unstable value.
pub(super) fn bisect(
    mut stable: f64,
    mut unstable: f64,
    is_stable: impl Fn(f64) -> Result<bool, StabilityError>,
) -> Result<f64, StabilityError> {
    for _ in 0..MAX_BISECTIONS {
        if (stable - unstable).abs() <= ACCURACY * stable.abs().max(unstable.abs()) {
            break;
        }
        let middle = f64::midpoint(stable, unstable);
        if is_stable(middle)? {
            stable = middle;
        } else {
            unstable = middle;
        }
    }
    Ok(stable)
}
