//! The extra channels in one period.

use crate::arm_state::ArmState;
use crate::channel::{ChannelState, ChannelTarget};
use crate::controller::config::ControllerConfig;
use crate::controller::state::{Measurement, Memory};
use crate::streaming::{ActiveStream, StreamedChunk};

/// Overwrites `channels` with those of this period. `streams`: with the chunks of this measurement, which decide what becomes of their
/// channels.
pub(super) fn update(
    channels: &mut [ChannelState],
    previous: &Memory,
    measurement: &Measurement,
    streams: &[ActiveStream],
    (arm, config): (&ArmState, &ControllerConfig),
) {
    for (k, channel) in channels.iter_mut().enumerate() {
        match previous.channels.get(k) {
            Some(known) => channel.clone_from(known),
            None => channel.clone_from(&ChannelState::default()),
        }
    }
    let before_s = previous.answered.as_ref().map_or(arm.time_s, |answered| answered.time_s);
    // The targets to come may be those of a chunk that another task still follows.
    if before_s > arm.time_s && !streams.iter().any(|active| active.stream.has_chunk()) {
        let is_forgotten = streams.iter().any(|active| active.has_forgotten_chunk);
        for channel in channels.iter_mut() {
            channel.go_on(before_s, arm.time_s);
            if is_forgotten {
                channel.stay(arm.time_s);
            }
        }
    }
    for input in &measurement.channels {
        channels[input.channel].accept(&config.channels[input.channel], *input, arm.time_s);
    }
    for chunk in &measurement.chunks {
        merge(channels, chunk, streams, (arm.time_s, config));
    }
    let profile_s = arm.profile_time(arm.time_s);
    for (channel, stated) in channels.iter_mut().zip(&config.channels) {
        channel.advance(stated, arm.time_s, profile_s, config.period_s);
    }
}

/// Adds the channels of a chunk that its task follows.
fn merge(
    channels: &mut [ChannelState],
    chunk: &StreamedChunk,
    streams: &[ActiveStream],
    (time_s, config): (f64, &ControllerConfig),
) {
    let Some(quantity) = chunk.actions.first().map(|action| action.value.quantity()) else { return };
    let Ok(index) = streams.binary_search_by_key(&(chunk.task, quantity), ActiveStream::key) else { return };
    let Some(merged) = streams[index].merged else { return };
    let moved_s = config.tasks[chunk.task].streaming.delay_s + merged.shift_s;
    for entry in &chunk.channels {
        let due = |target: &ChannelTarget| ChannelTarget { time_s: target.time_s + moved_s, ..*target };
        channels[entry.channel].merge(entry.targets.iter().map(due), time_s);
    }
}
