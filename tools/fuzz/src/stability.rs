//! The target `stability`: a body for `/v1/stability`.

use std::time::Duration;

use revprio_api::wire::StabilityAnswer;

use crate::Defect;
use crate::answers::value;
use crate::timed_service::TimedService;

/// Deadline of stability margins. Shorter than the default, so that the fuzzer makes progress.
pub const TIMEOUT: Duration = Duration::from_millis(500);

/// A loop whose margins cannot be computed, which is known soon.
const REFUSED_MARGIN: &[u8] =
    br#"{"inertia": 1e-300, "damping": 1e300, "environment": {"stiffness": 1e300}, "period_s": 0.001}"#;

/// Sends a body. Margins have workers of their own and may be late. Then their work must stop.
pub fn check(service: &TimedService, body: &[u8]) -> Result<(), Defect> {
    let answer = service.timed(2 * TIMEOUT, || {
        let answer = service.untimed().post("/v1/stability", "application/json", body)?;
        if answer.status == 503 {
            // This work starts when the work before it has stopped.
            service.untimed().post("/v1/stability", "application/json", REFUSED_MARGIN)?;
        }
        Ok(answer)
    })?;
    value::<StabilityAnswer>(&answer, true).map(drop)
}
