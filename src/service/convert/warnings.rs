//! Warnings about a new controller.

use revprio_api::wire;
use revprio_core::controller::{ControllerConfig, SteepGain};

use super::environment;
use crate::service::error::ApiError;

/// Returns the warnings about a controller, which must be checked before: unstable contacts, then steep gains.
pub fn warnings(request: &wire::Controller, config: &ControllerConfig) -> Result<Vec<String>, ApiError> {
    let mut warnings = environment::warnings(request)?;
    warnings.extend(config.steep_gains().map(|steep| describe(&steep)));
    Ok(warnings)
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
