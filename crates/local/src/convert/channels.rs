//! Channels besides the joints.

use std::collections::BTreeMap;

use revprio_api::wire;
use revprio_core::channel::{ChannelConfig, ChannelInput, ChannelKind, ChannelState, ChannelTarget};
use revprio_core::controller::{Command, Controller, ControllerConfig};
use revprio_core::streaming::ChannelChunk;

use super::checks::{Inside, Result, check_name, each, foreign};
use super::numbers::{number, time};
use super::profile::PerRow;
use crate::error::{ApiError, escape_pointer};

/// Reads the channels of a controller.
pub fn channels(given: &[wire::Channel]) -> Result<Vec<ChannelConfig>> {
    each("/channels", given, |_, channel| {
        check_name(&channel.name, "/name")?;
        let target = channel.target.as_ref().map(|profile| PerRow { rows: 1 }.profile(profile)).transpose();
        Ok(ChannelConfig {
            name: channel.name.clone(),
            kind: match channel.kind {
                wire::ChannelKind::Position => ChannelKind::Position,
                wire::ChannelKind::Force => ChannelKind::Force,
            },
            lower: number(channel.lower, "/lower")?,
            upper: number(channel.upper, "/upper")?,
            max_rate: number(channel.max_rate, "/max_rate")?,
            target: target.inside("/target")?,
        })
    })
}

/// Reads what a state brings for channels.
pub fn inputs(given: &BTreeMap<String, wire::ChannelInput>, controller: &Controller) -> Result<Vec<ChannelInput>> {
    let read = |(name, input): (&String, &wire::ChannelInput)| {
        let read = || {
            let channel = index(name, controller.config(), "")?;
            let measured = input.measured.map(|measured| number(measured, "/measured")).transpose()?;
            Ok(ChannelInput { channel, measured, target: input.target.map(|t| number(t, "/target")).transpose()? })
        };
        read().map_err(|error: ApiError| error.inside(&format!("/channels/{}", escape_pointer(name))))
    };
    given.iter().map(read).collect()
}

/// Reads the channels of the actions of a chunk. Pointers begin at the chunk.
pub fn of_actions(actions: &[wire::ChunkAction], config: &ControllerConfig) -> Result<Vec<ChannelChunk>> {
    let mut found: BTreeMap<usize, (usize, Vec<ChannelTarget>)> = BTreeMap::new();
    for (k, action) in actions.iter().enumerate() {
        let gripper = action.gripper.map(|value| ("gripper", value, format!("/{k}/gripper")));
        let named = action
            .channels
            .iter()
            .map(|(name, value)| (name.as_str(), *value, format!("/{k}/channels/{}", escape_pointer(name))));
        for (name, value, pointer) in gripper.into_iter().chain(named) {
            let target = ChannelTarget { time_s: action.time_s, value: number(value, &pointer)? };
            let (last, targets) = found.entry(index(name, config, &pointer)?).or_insert((usize::MAX, Vec::new()));
            if *last == k {
                return Err(ApiError::invalid(pointer, "the channel `gripper` is given twice; omit one of both"));
            }
            *last = k;
            targets.push(target);
        }
    }
    Ok(found.into_iter().map(|(channel, (_, targets))| ChannelChunk { channel, targets }).collect())
}

/// Returns the index of a channel; refuses an unknown one.
fn index(name: &str, config: &ControllerConfig, pointer: &str) -> Result<usize> {
    config.channels.iter().position(|channel| channel.name == name).ok_or_else(|| {
        let known: Vec<_> = config.channels.iter().map(|channel| format!("`{}`", channel.name)).collect();
        let known =
            if known.is_empty() { "none; add it to `channels` of the controller".to_owned() } else { known.join(", ") };
        ApiError::invalid(pointer, format!("there is no channel `{name}`; the channels of this controller: {known}"))
    })
}

/// Returns the commands of the channels by name.
pub fn commands(command: &Command, config: &ControllerConfig) -> BTreeMap<String, f64> {
    let named = config.channels.iter().zip(&command.channels);
    named.filter_map(|(channel, value)| Some((channel.name.clone(), (*value)?))).collect()
}

/// Reads the channels of a memory; those that it does not name have no command.
pub fn memory(given: &[wire::ChannelMemory], config: &ControllerConfig) -> Result<Vec<ChannelState>> {
    let mut states = vec![ChannelState::default(); if given.is_empty() { 0 } else { config.channels.len() }];
    let read: Vec<_> = each("/channels", given, |_, channel| {
        let index = config.channels.iter().position(|known| known.name == channel.channel);
        let index = index.ok_or_else(|| foreign("/channel", "not a channel of this controller"))?;
        let target = |target: &wire::ChannelTarget| {
            Ok(ChannelTarget { time_s: time(target.time_s, "/time_s")?, value: number(target.value, "/value")? })
        };
        let command = channel.command.map(|command| number(command, "/command")).transpose()?;
        Ok((index, ChannelState { command, targets: each("/targets", &channel.targets, |_, given| target(given))? }))
    })?;
    for (index, state) in read {
        states[index] = state;
    }
    Ok(states)
}

/// Returns the channels as a part of a memory.
pub fn memory_answer(states: &[ChannelState], config: &ControllerConfig) -> Vec<wire::ChannelMemory> {
    let answer = |(state, channel): (&ChannelState, &ChannelConfig)| wire::ChannelMemory {
        channel: channel.name.clone(),
        command: state.command,
        targets: state.targets.iter().map(|t| wire::ChannelTarget { time_s: t.time_s, value: t.value }).collect(),
    };
    states.iter().zip(&config.channels).map(answer).collect()
}
