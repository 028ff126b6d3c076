//! One stream of targets.

use super::chunk::{Arriving, Chunk, Merged, Unused};
use super::curve::{self, LaterTarget, MIN_INTERVAL};
use super::fade::Fade;
use super::reference::{Bound, Reference, clamp_norm};
use super::settings::Streaming;
use super::streamed_target::MAX_AHEAD;
use super::value::{Quantity, TargetValue};
use crate::law::TaskVector;

/// One target.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Time of the target on the clock of the states, s.
    pub time_s: f64,
    /// The value.
    pub value: TargetValue,
    /// Velocity of the value, a displacement per second. A stream of positions estimates it if it is `None`.
    pub velocity: Option<TaskVector>,
}

/// Where the target of a period comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TargetState {
    /// Interpolated: the newest target is not in the past.
    Following,
    /// Extrapolated from the newest target.
    Extrapolating,
    /// Held: the newest target is too old to be extrapolated.
    Holding,
    /// Braking to rest, or at rest: no target came for too long.
    Braking,
}

/// Why a target is ignored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ignored {
    /// It equals the newest target.
    Repeated,
    /// It is not newer than the newest target by [`MIN_INTERVAL`].
    Older {
        /// Its time, s.
        time_s: f64,
        /// Time of the newest target, s.
        newest_s: f64,
    },
    /// It is a chunk whose actions are all past.
    Late {
        /// Time of its last action, s.
        last_s: f64,
    },
    /// It is a chunk that begins after so many actions of earlier chunks that not all can be kept.
    Full,
}

/// A stream of targets of one quantity of one task: the last two targets, the reference, and what comes.
#[derive(Debug, PartialEq)]
pub struct TargetStream {
    /// Index of the task, from 0.
    pub task: usize,
    /// What the targets are.
    pub quantity: Quantity,
    /// The newest target.
    pub newest: Option<Target>,
    /// The target before it.
    pub previous: Option<Target>,
    /// Targets that were given ahead with the newest one, in the order of their times.
    pub ahead: Vec<LaterTarget>,
    /// The actions of chunks that are followed.
    pub chunk: Chunk,
    /// The target of the last period.
    pub reference: Reference,
    /// The state of the last period.
    pub state: TargetState,
}

impl TargetStream {
    /// Starts a stream without targets at a reference.
    pub fn new(task: usize, quantity: Quantity, reference: Reference) -> Self {
        Self {
            task,
            quantity,
            newest: None,
            previous: None,
            ahead: Vec::new(),
            chunk: Chunk::default(),
            reference,
            state: TargetState::Holding,
        }
    }

    /// Adds a target unless it is not newer than the newest one. Targets ahead that the clock cannot tell apart from the one before are left
    /// out.
    pub(crate) fn accept(
        &mut self,
        mut target: Target,
        mut ahead: Vec<LaterTarget>,
        settings: &Streaming,
    ) -> Option<Ignored> {
        if !self.chunk.actions.is_empty() {
            // A target takes over from a chunk that began before it.
            if let Some(newest_s) = self.chunk.first_s.filter(|first_s| target.time_s - first_s < MIN_INTERVAL) {
                return Some(Ignored::Older { time_s: target.time_s, newest_s });
            }
            self.chunk.clear();
            self.newest = None;
        }
        if let Some(newest) = &self.newest
            && target.time_s - newest.time_s < MIN_INTERVAL
        {
            let (time_s, newest_s) = (target.time_s, newest.time_s);
            let is_same = time_s == newest_s
                && target.value == newest.value
                && (target.velocity.is_none() || target.velocity == newest.velocity);
            return Some(if is_same { Ignored::Repeated } else { Ignored::Older { time_s, newest_s } });
        }
        // A line over a drop-out would not be the motion of the target.
        let is_recent = |old: &Target| target.time_s - old.time_s <= settings.brake_after_s;
        self.previous = self.newest.take().filter(is_recent);
        if target.velocity.is_none() && self.quantity.is_position() {
            target.velocity = self.previous.as_ref().map(|previous| estimated_velocity(previous, &target, settings));
        }
        let mut before_s = target.time_s;
        ahead.retain(|later| {
            let is_later = later.time_s - before_s >= MIN_INTERVAL;
            before_s = if is_later { later.time_s } else { before_s };
            is_later
        });
        self.newest = Some(target);
        self.ahead = ahead;
        None
    }

    /// Merges a chunk at the time of a state, s: it replaces the actions from its first one on. The offset to the motion until now fades.
    pub(crate) fn merge<I: Iterator<Item = LaterTarget> + Clone>(
        &mut self,
        chunk: Arriving<'_, I>,
        now_s: f64,
        settings: &Streaming,
        bound: impl Fn(usize) -> Bound,
    ) -> Result<Merged, Ignored> {
        let first_s = chunk.first_s;
        let last_s = chunk.actions.clone().fold(first_s, |_, action| action.time_s) - settings.delay_s;
        let before = self.followed(now_s);
        let merged = self.chunk.merge(chunk, self.quantity, now_s, &before);
        let merged = merged.map_err(|unused| match unused {
            Unused::Repeated => Ignored::Repeated,
            Unused::Older(newest_s) => Ignored::Older { time_s: first_s, newest_s },
            Unused::Late => Ignored::Late { last_s },
            Unused::Full => Ignored::Full,
        })?;
        let began = self.newest.is_some() || self.quantity.is_position();
        self.chunk.fade = self.chunk.motion(self.quantity, now_s).filter(|_| began).and_then(|motion| {
            let acceleration = match &self.chunk.fade {
                Some(fade) if !fade.is_over(now_s) => fade.derivative(2, now_s),
                _ => TaskVector::zeros(motion.velocity.len()),
            };
            let fade = Fade::between(&before, &motion, acceleration, now_s, settings.fade_s)?;
            Some(if self.quantity.is_position() { fade.slowed(&motion, bound) } else { fade })
        });
        self.newest = self.chunk.actions.last().map(|last| Target {
            time_s: last.time_s - settings.delay_s,
            value: last.value.clone(),
            velocity: self.chunk.end_velocity(self.quantity),
        });
        self.previous = None;
        self.ahead.clear();
        Ok(merged)
    }

    /// Returns the motion that the stream follows at a time, s: that of a chunk, or else the reference.
    fn followed(&self, time_s: f64) -> Reference {
        let motion = self.chunk.motion(self.quantity, time_s).filter(|_| self.chunk.covers(time_s));
        motion.map_or_else(|| self.reference.clone(), |motion| self.chunk.faded(motion, time_s))
    }

    /// Forgets the targets if the clock of the states went back by `back` (s), and actions that are past. The actions that are left
    /// after a time that was too late by mistake count as those of another clock: the first one is never later than the state with
    /// which they came. Returns whether a chunk was forgotten.
    pub(crate) fn forget(&mut self, time_s: f64, back: f64, settings: &Streaming) -> bool {
        let newest_s = self.newest.as_ref().map(|newest| newest.time_s);
        let known_s = if self.chunk.actions.is_empty() { newest_s } else { self.chunk.known_s() };
        // Newer targets would count as older ones for longer than a target is extrapolated.
        let is_stale = back > settings.hold_after_s.max(MIN_INTERVAL)
            || known_s.is_some_and(|known_s| known_s > time_s + MAX_AHEAD);
        let had_chunk = self.has_chunk();
        if is_stale {
            (self.newest, self.previous) = (None, None);
            self.ahead.clear();
            self.chunk.forget();
        }
        self.chunk.drop_past(time_s);
        is_stale && had_chunk
    }

    /// Returns whether the stream has actions of chunks.
    pub(crate) fn has_chunk(&self) -> bool {
        !self.chunk.actions.is_empty()
    }

    /// Returns the time of the state minus the time of the newest target, s; `None` without a target.
    pub fn age(&self, time_s: f64) -> Option<f64> {
        self.newest.as_ref().map(|newest| time_s - newest.time_s)
    }

    /// Returns whether a target was given ahead for a time after this one, s.
    pub(crate) fn is_known_after(&self, time_s: f64) -> bool {
        self.chunk.covers(time_s) || self.ahead.last().is_some_and(|last| last.time_s > time_s)
    }

    /// Returns the target that was given ahead for a time, s: on a smooth curve through the targets, the last one if it is earlier;
    /// `None` if there is none for this time.
    pub(crate) fn ahead_at(&self, time_s: f64) -> Option<TargetValue> {
        if let Some(motion) = self.chunk.motion(self.quantity, time_s) {
            return Some(self.chunk.faded(motion, time_s).value);
        }
        let newest = self.newest.as_ref()?;
        let last = self.ahead.last()?;
        let after = self.ahead.partition_point(|later| later.time_s <= time_s);
        if after == self.ahead.len() {
            return Some(last.value.clone());
        }
        // Knot 0 is the newest target.
        let knot = |k: usize| {
            k.checked_sub(1).map_or((newest.time_s, &newest.value), |k| (self.ahead[k].time_s, &self.ahead[k].value))
        };
        (time_s >= newest.time_s).then(|| curve::cubic(&knot, after, self.ahead.len(), time_s).value)
    }

    /// Moves the reference on to the next period of `period` s.
    pub(crate) fn advance(&mut self, period: f64) {
        self.reference.advance(period);
    }

    /// Computes the reference and the state of the period at `time_s`.
    ///
    /// A reference that brakes and is `held` starts each period from that value: the position of an arm whose law must
    /// not go on to a reference that is far away.
    pub(crate) fn update(
        &mut self,
        time_s: f64,
        settings: &Streaming,
        bound: impl Fn(usize) -> Bound + Copy,
        held: Option<&Reference>,
        period: f64,
    ) {
        let was_braking = self.state == TargetState::Braking;
        let (state, desired) = self.desired(time_s, settings, bound);
        self.state = state;
        let smoothing = settings.smoothing_s;
        match (state, self.quantity) {
            (TargetState::Braking, Quantity::Force) => {}
            (TargetState::Braking, Quantity::Velocity) => {
                let rest = TaskVector::zeros(self.reference.value.len());
                self.reference.follow_rows(&rest, bound, 0.0, period);
            }
            (TargetState::Braking, Quantity::Pose | Quantity::JointPosition) => {
                if let Some(held) = held.filter(|_| !was_braking) {
                    self.reference.clone_from(held);
                }
                if let (false, Some(held)) = (self.reference.brake(bound, period), held) {
                    self.reference.value.clone_from(&held.value);
                }
            }
            (_, Quantity::Force) => self.reference.value = desired.value,
            (_, Quantity::Velocity) => {
                if let TargetValue::Rows(wanted) = &desired.value {
                    self.reference.follow_rows(wanted, bound, smoothing, period);
                }
            }
            (_, Quantity::Pose | Quantity::JointPosition) => {
                self.reference.follow(&desired, bound, smoothing, period);
            }
        }
    }

    /// Returns the state and the desired value at `time_s`.
    fn desired(&self, time_s: f64, settings: &Streaming, bound: impl Fn(usize) -> Bound) -> (TargetState, Reference) {
        let Some(newest) = &self.newest else { return (TargetState::Braking, self.reference.clone()) };
        // The times of actions have the delay in them that was stated when they came.
        let last = self.chunk.actions.last();
        let age = time_s - last.map_or(newest.time_s + settings.delay_s, |last| last.time_s);
        let velocity = velocity_within(newest, bound);
        let still = || TaskVector::zeros(velocity.len());
        let moved = |age: f64| newest.value.plus(&(&velocity * age));
        let chunk = self.chunk.motion(self.quantity, time_s);
        let (state, value, velocity) = if let Some(motion) = chunk.filter(|_| age <= 0.0) {
            (TargetState::Following, motion.value, motion.velocity)
        } else if age <= 0.0 {
            (TargetState::Following, self.interpolated(newest, &velocity, age, settings), velocity)
        } else if age <= settings.hold_after_s {
            (TargetState::Extrapolating, moved(age), velocity)
        } else if age <= settings.brake_after_s {
            (TargetState::Holding, moved(settings.hold_after_s), still())
        } else {
            (TargetState::Braking, self.reference.value.clone(), still())
        };
        let desired = Reference { value, velocity };
        let desired = if state == TargetState::Braking { desired } else { self.chunk.faded(desired, time_s) };
        (state, desired)
    }

    /// Returns the value on the line through the last two targets. Before the older one, the line of positions goes on
    /// for `hold_after_s` at most, and velocities and forces stay.
    fn interpolated(&self, newest: &Target, velocity: &TaskVector, age: f64, settings: &Streaming) -> TargetValue {
        let earliest = if self.quantity.is_position() { -settings.hold_after_s } else { 0.0 };
        let Some(previous) = &self.previous else {
            return newest.value.plus(&(velocity * age.max(earliest)));
        };
        let after = (newest.time_s - previous.time_s + age).max(earliest);
        previous.value.plus(&(&slope(previous, newest) * after))
    }
}

impl Clone for TargetStream {
    fn clone(&self) -> Self {
        Self {
            task: self.task,
            quantity: self.quantity,
            newest: self.newest.clone(),
            previous: self.previous.clone(),
            ahead: self.ahead.clone(),
            chunk: self.chunk.clone(),
            reference: self.reference.clone(),
            state: self.state,
        }
    }

    // Without allocating for the targets ahead.
    fn clone_from(&mut self, source: &Self) {
        (self.task, self.quantity, self.state) = (source.task, source.quantity, source.state);
        self.newest.clone_from(&source.newest);
        self.previous.clone_from(&source.previous);
        self.ahead.clone_from(&source.ahead);
        self.chunk.clone_from(&source.chunk);
        self.reference.clone_from(&source.reference);
    }
}

/// Returns the velocity from one target to the next.
fn slope(from: &Target, to: &Target) -> TaskVector {
    &to.value.minus(&from.value) * (1.0 / (to.time_s - from.time_s))
}

/// Returns the velocity of a target, smoothed over the targets before it. The slope between two targets alone would
/// amplify noise the more, the more targets come per second.
fn estimated_velocity(previous: &Target, target: &Target, settings: &Streaming) -> TaskVector {
    let slope = slope(previous, target);
    let Some(before) = previous.velocity.as_ref().filter(|_| settings.smoothing_s > 0.0) else { return slope };
    let blend = -((previous.time_s - target.time_s) / settings.smoothing_s).exp_m1();
    before + &(&(&slope - before) * blend)
}

/// Returns the velocity of a target, within the bounds; zero for velocities and forces.
fn velocity_within(target: &Target, bound: impl Fn(usize) -> Bound) -> TaskVector {
    let mut velocity = target.velocity.clone().unwrap_or_else(|| TaskVector::zeros(target.value.len()));
    for group in target.value.groups() {
        let max = bound(group.start).velocity;
        clamp_norm(&mut velocity[group], max);
    }
    velocity
}

#[cfg(test)]
mod tests;
