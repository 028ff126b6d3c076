//! The environment that a controller states.

use revprio_api::wire::{self, Axis, EnvironmentAxis};

use super::checks::{Result, check};
use super::numbers::not_negative;

/// Maximum delay in the environment of a controller, control periods. The cost of a warning grows with the cube of the
/// delay, and other requests wait for it.
pub const MAX_ENVIRONMENT_DELAY: usize = 8;

/// Checks the numbers of an environment.
pub fn check_environment(request: &wire::Controller) -> Result<()> {
    let Some(environment) = &request.environment else { return Ok(()) };
    for axis in Axis::ALL {
        if let Some(contact) = environment.along(axis) {
            check_contact(&contact).map_err(|error| error.inside(&format!("/environment/{axis}")))?;
        }
    }
    not_negative(environment.lag_s, "/environment/lag_s")?;
    let detail =
        format_args!("give at most {MAX_ENVIRONMENT_DELAY} periods; for longer delays, use POST /v1/stability");
    check(environment.delay_periods <= MAX_ENVIRONMENT_DELAY, "/environment/delay_periods", detail)
}

fn check_contact(contact: &EnvironmentAxis) -> Result<()> {
    not_negative(contact.stiffness, "/stiffness")?;
    not_negative(contact.damping, "/damping")?;
    not_negative(contact.inertia, "/inertia").map(drop)
}
