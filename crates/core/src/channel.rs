//! Extra channels: a gripper, a suction cup, a lamp. They pass through a controller with its timing and within their own bounds.
//!
//! A channel has one number. Its targets come with the measurements, alone or with the actions of a [chunk](crate::streaming), and are
//! due when the actions are due: delayed, moved and replaced with them. Between two targets the channel follows the line, after the last
//! one it stays. Its command stays within its range, and changes by at most the maximum rate there. No target ever moves the arm.

use revprio_robot::profile::Profile;

/// Maximum number of channels of a controller.
pub const MAX_CHANNELS: usize = 16;

/// Maximum number of targets that a channel keeps.
pub const MAX_CHANNEL_TARGETS: usize = 514;

/// What the number of a channel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelKind {
    /// A position, such as the opening of a gripper, m or rad.
    Position,
    /// A force, such as that of a grip, N or N·m.
    Force,
}

/// One channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelConfig {
    /// Name that states, actions and answers use.
    pub name: String,
    /// What its number is.
    pub kind: ChannelKind,
    /// The smallest command.
    pub lower: f64,
    /// The largest command.
    pub upper: f64,
    /// Largest change of the command, per second.
    pub max_rate: f64,
    /// Target over time, one row, until another one comes; `None`: the channel waits for its first target.
    pub target: Option<Profile>,
}

/// Why a channel is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ChannelError {
    /// The range is empty or not finite.
    #[error("a range from {lower} to {upper}; give finite numbers, the smaller one first")]
    Range {
        /// The smallest command.
        lower: f64,
        /// The largest command.
        upper: f64,
    },
    /// The rate is not positive.
    #[error("a rate of {0}; give a positive number per second")]
    Rate(f64),
    /// The target has not one row.
    #[error("a target of {0} rows; a channel has one number")]
    Target(usize),
    /// Two channels share a name.
    #[error("two channels are named `{0}`; give each its own name")]
    Twice(String),
    /// There are too many channels.
    #[error("{0} channels; give at most {MAX_CHANNELS}")]
    TooMany(usize),
}

/// What arrives for a channel with a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelInput {
    /// Index of the channel, from 0.
    pub channel: usize,
    /// The measured number, from which the first command starts; `None`: not measured, then it starts at the first target.
    pub measured: Option<f64>,
    /// A target for now and later, in place of all that came before.
    pub target: Option<f64>,
}

/// A target of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelTarget {
    /// Time at which it is due, s.
    pub time_s: f64,
    /// The number.
    pub value: f64,
}

/// The state of a channel from period to period.
#[derive(Debug, PartialEq, Default)]
pub struct ChannelState {
    /// The last command; `None`: none was given.
    pub command: Option<f64>,
    /// Targets in the order of time: at most one that is past, then those to come.
    pub targets: Vec<ChannelTarget>,
}

impl ChannelConfig {
    /// Checks the channels of a controller; the index of the first one that is refused, and why.
    pub(crate) fn check_all(channels: &[Self]) -> Result<(), (usize, ChannelError)> {
        if channels.len() > MAX_CHANNELS {
            return Err((MAX_CHANNELS, ChannelError::TooMany(channels.len())));
        }
        for (index, channel) in channels.iter().enumerate() {
            let is_taken = channels[..index].iter().any(|earlier| earlier.name == channel.name);
            let taken = is_taken.then(|| ChannelError::Twice(channel.name.clone()));
            taken.map_or_else(|| channel.check(), Err).map_err(|error| (index, error))?;
        }
        Ok(())
    }

    fn check(&self) -> Result<(), ChannelError> {
        let Self { lower, upper, max_rate, .. } = *self;
        if !(lower.is_finite() && upper.is_finite() && lower < upper) {
            return Err(ChannelError::Range { lower, upper });
        }
        if !(max_rate.is_finite() && max_rate > 0.0) {
            return Err(ChannelError::Rate(max_rate));
        }
        match self.target.as_ref().map(Profile::rows).filter(|rows| *rows != 1) {
            Some(rows) => Err(ChannelError::Target(rows)),
            None => Ok(()),
        }
    }
}

impl ChannelState {
    /// Takes what arrived with a measurement at `time_s`.
    pub(crate) fn accept(&mut self, config: &ChannelConfig, input: ChannelInput, time_s: f64) {
        if let (None, Some(measured)) = (self.command, input.measured) {
            self.command = Some(measured.clamp(config.lower, config.upper));
        }
        if let Some(value) = input.target {
            self.targets.clear();
            self.targets.push(ChannelTarget { time_s, value });
        }
    }

    /// Stays where it is from `time_s` on if a target is to come, because its chunk is followed no more.
    pub(crate) fn stay(&mut self, time_s: f64) {
        if self.targets.last().is_some_and(|last| last.time_s > time_s) {
            self.targets.clear();
            self.targets.extend(self.command.map(|value| ChannelTarget { time_s, value }));
        }
    }

    /// Goes on to a lone target after the clock went back from `before_s` to `time_s`.
    pub(crate) fn go_on(&mut self, before_s: f64, time_s: f64) {
        if let [target] = &mut self.targets[..]
            && target.time_s <= before_s
        {
            target.time_s = target.time_s.min(time_s);
        }
    }

    /// Replaces the targets from the first one of a chunk on, at `time_s`. At most [`MAX_CHANNEL_TARGETS`] are kept, the nearest ones. If the
    /// chunk begins later and none is kept until then, the line to it begins now.
    pub(crate) fn merge(&mut self, targets: impl Iterator<Item = ChannelTarget>, time_s: f64) {
        let mut targets = targets.peekable();
        let Some(first) = targets.peek() else { return };
        let present = self.followed(time_s);
        let kept = self.targets.partition_point(|target| target.time_s < first.time_s);
        self.targets.truncate(kept);
        let has_gap = first.time_s > time_s && self.targets.last().is_some_and(|last| last.time_s < time_s);
        self.targets.extend(present.filter(|_| has_gap).map(|value| ChannelTarget { time_s, value }));
        self.targets.extend(targets);
        self.targets.truncate(MAX_CHANNEL_TARGETS);
    }

    /// Computes the command of the period at `time_s`; `period`: T, s; `profile_s`: time on the clock of profiles, s.
    pub(crate) fn advance(&mut self, config: &ChannelConfig, time_s: f64, profile_s: f64, period: f64) {
        let past = self.targets.partition_point(|target| target.time_s <= time_s);
        if past > 1 {
            self.targets.drain(..past - 1);
        }
        let Some(wanted) = self.wanted(config, time_s, profile_s) else { return };
        let wanted = wanted.clamp(config.lower, config.upper);
        let change = config.max_rate * period;
        // The range comes before the rate: a controller that replaces another one may have a narrower range.
        let command = self.command.map_or(wanted, |last| last + (wanted - last).clamp(-change, change));
        self.command = Some(command.clamp(config.lower, config.upper));
    }

    /// Returns the target of now; `None`: there is none yet.
    fn wanted(&self, config: &ChannelConfig, time_s: f64, profile_s: f64) -> Option<f64> {
        match self.targets.as_slice() {
            [] => config.target.as_ref().map(|profile| profile.at(profile_s).value[0]),
            _ => self.followed(time_s),
        }
    }

    /// Returns the value on the line through the targets; `None`: the first one is still to come.
    fn followed(&self, time_s: f64) -> Option<f64> {
        let past = self.targets.partition_point(|target| target.time_s <= time_s);
        let from = self.targets[..past].last()?;
        let Some(to) = self.targets.get(past) else { return Some(from.value) };
        let share = (time_s - from.time_s) / (to.time_s - from.time_s);
        Some(from.value + share * (to.value - from.value))
    }

    /// Returns whether the numbers are finite and the times in order.
    pub(crate) fn is_valid(&self) -> bool {
        let targets = &self.targets;
        self.command.is_none_or(f64::is_finite)
            && targets.len() <= MAX_CHANNEL_TARGETS
            && targets.iter().all(|target| target.time_s.is_finite() && target.value.is_finite())
            && targets.windows(2).all(|pair| pair[0].time_s < pair[1].time_s)
    }
}

impl Clone for ChannelState {
    fn clone(&self) -> Self {
        Self { command: self.command, targets: self.targets.clone() }
    }

    // Without allocating.
    fn clone_from(&mut self, source: &Self) {
        self.command = source.command;
        self.targets.clone_from(&source.targets);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gripper() -> ChannelConfig {
        let name = "gripper".to_owned();
        ChannelConfig { name, kind: ChannelKind::Position, lower: 0.0, upper: 0.08, max_rate: 0.1, target: None }
    }

    #[test]
    fn a_channel_starts_where_it_is_measured_and_keeps_rate_and_range() {
        let (config, mut state) = (gripper(), ChannelState::default());
        state.advance(&config, 0.0, 0.0, 0.01);
        assert_eq!(state.command, None);
        state.accept(&config, ChannelInput { channel: 0, measured: Some(0.05), target: Some(-1.0) }, 0.0);
        for period in 1..100_u32 {
            let before = state.command.unwrap();
            state.advance(&config, f64::from(period) * 0.01, 0.0, 0.01);
            let change = before - state.command.unwrap();
            assert!((-1e-15..=0.001 + 1e-12).contains(&change), "{change}");
        }
        assert_eq!(state.command, Some(0.0));
        state.advance(&ChannelConfig { lower: 0.03, ..config }, 1.0, 0.0, 0.01);
        assert_eq!(state.command, Some(0.03), "a narrower range holds at once");
    }

    #[test]
    fn targets_are_due_at_their_times_and_replaced_by_later_chunks() {
        let (config, mut state) = (ChannelConfig { max_rate: 1e6, ..gripper() }, ChannelState::default());
        let target = |time_s: f64, value: f64| ChannelTarget { time_s, value };
        state.merge([target(1.0, 0.0), target(2.0, 0.04)].into_iter(), 0.5);
        state.advance(&config, 0.5, 0.0, 0.01);
        assert_eq!(state.command, None);
        state.advance(&config, 1.5, 0.0, 0.01);
        assert!((state.command.unwrap() - 0.02).abs() < 1e-12);
        state.merge([target(1.75, 0.08), target(3.0, 0.08)].into_iter(), 1.5);
        state.advance(&config, 2.5, 0.0, 0.01);
        assert!((state.command.unwrap() - 0.08).abs() < 1e-12);
        state.advance(&config, 30.0, 0.0, 0.01);
        assert_eq!((state.command, state.targets.len()), (Some(0.08), 1));
    }

    /// The last target was due long ago.
    #[test]
    fn a_chunk_that_begins_later_does_not_move_a_channel_at_once() {
        let (config, mut state) = (ChannelConfig { max_rate: 1e6, ..gripper() }, ChannelState::default());
        let target = |time_s: f64, value: f64| ChannelTarget { time_s, value };
        state.merge([target(2.0, 0.0)].into_iter(), 2.0);
        state.advance(&config, 9.99, 0.0, 0.01);
        state.merge([target(10.5, 0.08)].into_iter(), 10.0);
        for (time_s, expected) in [(10.0, 0.0), (10.25, 0.04), (10.5, 0.08)] {
            state.advance(&config, time_s, 0.0, 0.01);
            assert!((state.command.unwrap() - expected).abs() < 1e-12, "{time_s}: {:?}", state.command);
        }
        assert!(state.is_valid());
        // A chunk that takes over half way goes on from there.
        state.merge([target(11.0, 0.0)].into_iter(), 10.6);
        state.advance(&config, 10.7, 0.0, 0.01);
        state.merge([target(10.8, 0.08)].into_iter(), 10.75);
        state.advance(&config, 10.75, 0.0, 0.01);
        assert!((state.command.unwrap() - 0.05).abs() < 1e-12, "{:?}", state.command);
    }

    #[test]
    fn a_channel_stays_where_its_chunk_is_forgotten_and_goes_on_to_a_lone_target() {
        let config = gripper();
        let target = |time_s: f64, value: f64| ChannelTarget { time_s, value };
        let mut opening = ChannelState::default();
        opening.merge([target(100.0, 0.0), target(101.0, 0.0), target(101.1, 0.08)].into_iter(), 100.0);
        opening.advance(&config, 100.5, 0.0, 0.01);
        opening.go_on(100.5, 100.4);
        assert_eq!(opening.targets.len(), 3, "a chunk keeps its times");
        opening.stay(100.4);
        opening.advance(&config, 101.2, 0.0, 0.01);
        assert_eq!((opening.command, opening.targets.len()), (Some(0.0), 1));
        let mut closing = ChannelState::default();
        closing.accept(&config, ChannelInput { channel: 0, measured: Some(0.05), target: Some(0.0) }, 100.0);
        closing.go_on(100.1, 3.0);
        closing.advance(&config, 3.0, 0.0, 1.0);
        assert_eq!(closing.command, Some(0.0));
        closing.accept(&config, ChannelInput { channel: 0, measured: None, target: Some(0.08) }, 4.0);
        closing.stay(4.5);
        closing.advance(&config, 4.5, 0.0, 1.0);
        assert_eq!(closing.command, Some(0.08), "a target of now is not to come");
        let mut waiting = ChannelState::default();
        waiting.stay(3.0);
        assert_eq!(waiting, ChannelState::default());
        assert!([&opening, &closing].into_iter().all(ChannelState::is_valid));
    }

    #[test]
    fn channels_without_sense_are_refused() {
        let refused = [
            ChannelConfig { lower: 0.1, upper: 0.1, ..gripper() },
            ChannelConfig { max_rate: 0.0, ..gripper() },
            ChannelConfig { max_rate: f64::INFINITY, ..gripper() },
            ChannelConfig { target: Some(Profile::constant(vec![0.0; 2]).unwrap()), ..gripper() },
        ];
        for channel in refused {
            assert!(ChannelConfig::check_all(&[gripper(), ChannelConfig { name: "b".to_owned(), ..channel }]).is_err());
        }
        let twice = ChannelConfig::check_all(&[gripper(), gripper()]);
        assert_eq!(twice, Err((1, ChannelError::Twice("gripper".to_owned()))));
    }
}
