//! Warnings about targets of channels that are outside their ranges.

use revprio_core::channel::{ChannelConfig, ChannelKind};
use revprio_core::controller::{Controller, Measurement};

/// Part of the range of a channel by which a target may be outside it without a warning: rounding, and the overshoot of a policy.
const ROUNDING: f64 = 0.01;

/// Adds a warning for each channel that has a target outside its range. Its command stays at the end of the range.
pub fn warn(warnings: &mut Vec<String>, controller: &Controller, measurement: &Measurement) {
    for (index, channel) in controller.config().channels.iter().enumerate() {
        let alone = measurement.channels.iter().filter(|input| input.channel == index).filter_map(|input| input.target);
        let chunks = measurement.chunks.iter().flat_map(|chunk| &chunk.channels).filter(|chunk| chunk.channel == index);
        let with_actions = chunks.flat_map(|chunk| &chunk.targets).map(|target| target.value);
        warnings.extend(alone.chain(with_actions).find_map(|target| outside(channel, target)));
    }
}

/// Describes a target outside the range of a channel.
fn outside(channel: &ChannelConfig, target: f64) -> Option<String> {
    let ChannelConfig { name, kind, lower, upper, .. } = channel;
    let tolerance = ROUNDING * (upper - lower);
    let is_outside = target > upper + tolerance || target < lower - tolerance;
    let unit = match kind {
        ChannelKind::Position => "m or rad",
        ChannelKind::Force => "N or N·m",
    };
    is_outside.then(|| {
        format!(
            "channel `{name}`: the target {target} is outside its range {lower} … {upper}, and its command stays inside; targets are in \
             {unit}, not a share or percent"
        )
    })
}
