//! Warnings about targets and measured numbers of channels that are outside their ranges.

use revprio_core::channel::{ChannelConfig, ChannelKind};
use revprio_core::controller::{Controller, Measurement};

/// Part of the range of a channel by which a target may be outside it without a warning: rounding, and the overshoot of a policy.
const ROUNDING: f64 = 0.01;

/// Adds a warning for each channel that has a target or a measured number outside its range. Its command stays at the end of the range.
pub fn warn(warnings: &mut Vec<String>, controller: &Controller, measurement: &Measurement) {
    for (index, channel) in controller.config().channels.iter().enumerate() {
        let inputs = || measurement.channels.iter().filter(|input| input.channel == index);
        let measured = inputs()
            .filter_map(|input| input.measured)
            .find_map(|measured| outside(channel, "measured number", measured));
        let alone = inputs().filter_map(|input| input.target);
        let chunks = measurement.chunks.iter().flat_map(|chunk| &chunk.channels).filter(|chunk| chunk.channel == index);
        let with_actions = chunks.flat_map(|chunk| &chunk.targets).map(|target| target.value);
        let target = alone.chain(with_actions).find_map(|target| outside(channel, "target", target));
        warnings.extend(measured.into_iter().chain(target));
    }
}

/// Describes a number outside the range of a channel.
fn outside(channel: &ChannelConfig, what: &str, value: f64) -> Option<String> {
    let ChannelConfig { name, kind, lower, upper, .. } = channel;
    let tolerance = ROUNDING * (upper - lower);
    let is_outside = value > upper + tolerance || value < lower - tolerance;
    let unit = match kind {
        ChannelKind::Position => "m or rad",
        ChannelKind::Force => "N or N·m",
    };
    is_outside.then(|| {
        format!(
            "channel `{name}`: the {what} {value} is outside its range {lower} … {upper}, and its command stays inside; its numbers are in \
             {unit}, not a share or percent"
        )
    })
}
