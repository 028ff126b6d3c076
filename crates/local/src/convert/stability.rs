//! `POST /v1/stability`.

use revprio_api::wire;
use revprio_core::controller::{ContactLoop, MAX_DELAY_PERIODS, Margin};

use super::checks::{Missing, Result, check};
use super::numbers::{inertia, not_negative};
use super::resolve::positive_period;

/// Error text for a loop whose eigenvalues cannot be computed.
pub const NOT_COMPUTABLE: &str =
    "the stability of this loop cannot be computed; use quantities with a smaller ratio of largest to smallest";

/// Reads a request.
pub fn contact_loop(request: &wire::StabilityRequest) -> Result<ContactLoop> {
    let wire::StabilityRequest { environment, .. } = request;
    let detail = format_args!("give at most {MAX_DELAY_PERIODS} periods");
    check(request.delay_periods <= MAX_DELAY_PERIODS, "/delay_periods", detail)?;
    Ok(ContactLoop {
        inertia: inertia(request.inertia, "/inertia")?,
        damping: not_negative(request.damping, "/damping")?,
        stiffness: not_negative(request.stiffness, "/stiffness")?,
        environment_inertia: not_negative(environment.inertia, "/environment/inertia")?,
        environment_damping: not_negative(environment.damping, "/environment/damping")?,
        environment_stiffness: not_negative(environment.stiffness, "/environment/stiffness")?,
        period_s: positive_period(request.period_s, "/period_s")?,
        lag_s: not_negative(request.lag_s, "/lag_s")?,
        delay_periods: request.delay_periods,
        velocity_measured: request.velocity_measured,
    })
}

/// Computes the stability margins of the loop. `is_abandoned` ends the computation early; nobody reads its error then.
pub fn margin(contact: &ContactLoop, is_abandoned: impl Fn() -> bool) -> Result<Margin> {
    let margin = contact.margin_unless(&is_abandoned).ok();
    margin.filter(|margin| margin.spectral_radius.is_finite()).or_invalid("", NOT_COMPUTABLE)
}

/// Returns the body of the answer.
pub fn margin_answer(margin: &Margin) -> wire::StabilityAnswer {
    wire::StabilityAnswer {
        stable: margin.is_stable(),
        spectral_radius: margin.spectral_radius,
        largest_lag_s: margin.largest_lag_s.filter(|lag| lag.is_finite()),
        stable_at_any_lag: margin.largest_lag_s.is_some_and(f64::is_infinite),
        largest_delay_periods: margin.largest_delay_periods,
        smallest_damping: margin.smallest_damping,
        largest_damping: margin.largest_damping,
    }
}
