//! Warnings about new controllers and about streamed targets: sentences that say what to change.

mod contact;
mod free_space;
mod targets;

use revprio_api::wire;
use revprio_core::controller::{ControllerConfig, SteepGain};

use super::error::ApiError;

pub use targets::warn as warn_about_targets;

/// Reaches of arms that the default characteristic length of 1 m suits, m.
const ORDINARY_REACH_M: std::ops::RangeInclusive<f64> = 0.3..=4.0;

/// Returns the warnings about a controller, which must be checked before: unstable contacts, laws that are unstable in free space,
/// steep gains, then a damping that does not suit the size of the arm.
pub fn of_controller(request: &wire::Controller, config: &ControllerConfig) -> Result<Vec<String>, ApiError> {
    let mut warnings = contact::warnings(request)?;
    warnings.extend(free_space::warnings(request, config));
    warnings.extend(config.steep_gains().map(|steep| describe(&steep)));
    warnings.extend(unusual_size(request, config));
    Ok(warnings)
}

/// Singular values of linear rows are proportional to the size of the arm, and the thresholds of damping are not.
#[expect(clippy::float_cmp, reason = "any other length is a choice of the user")]
fn unusual_size(request: &wire::Controller, config: &ControllerConfig) -> Option<String> {
    let (reach, chosen) = (config.robot.reach(), request.characteristic_length_m != 1.0);
    (config.damping.is_some() && !chosen && !ORDINARY_REACH_M.contains(&reach)).then(|| {
        format!(
            "the arm reaches {reach:.2} m, and a characteristic length of 1 m suits arms of about that reach; set \
             `characteristic_length_m` to {reach:.2}, or damping begins at the wrong distance from singularities"
        )
    })
}

fn describe(steep: &SteepGain) -> String {
    let SteepGain { task, gain, joint, ratio, brakes } = steep;
    let consequence = if *brakes {
        "far from its target, the law brakes with the joints' acceleration instead of this gain"
    } else {
        "the arm may pass its target; lower the gain, or omit `braking`"
    };
    format!(
        "task `{task}`: the gain {gain} 1/s is above {ratio:.2} 1/s, the ratio of the acceleration and speed limits of joint \
         `{joint}`; {consequence}"
    )
}
