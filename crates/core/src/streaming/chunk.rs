//! The actions of chunks that a stream follows.

use super::curve::{self, LaterTarget, MIN_INTERVAL};
use super::fade::Fade;
use super::reference::Reference;
use super::streamed_chunk::{Align, MAX_ACTIONS, MAX_HORIZON};
use super::value::{Quantity, TargetValue};
use crate::law::TaskVector;

/// Maximum number of actions that a stream keeps: those of two chunks, and two that are past.
pub const MAX_KEPT_ACTIONS: usize = 2 * MAX_ACTIONS + 2;

/// The actions of chunks that a stream follows, on the times at which they are due: their own plus the delay of the stream.
#[derive(Debug, PartialEq, Default)]
pub struct Chunk {
    /// The actions in the order of time: up to two that are past, then those to come; empty: no chunk.
    pub actions: Vec<LaterTarget>,
    /// Time of the state with which the last chunk came, s; 0 before the first one.
    pub merged_s: f64,
    /// Time of the first action of the last chunk, as it was sent, s; `None`: no chunk came.
    pub first_s: Option<f64>,
    /// What is left of the motion before the last chunk.
    pub fade: Option<Fade>,
}

/// What became of a chunk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Merged {
    /// Number of its actions that were past.
    pub dropped: usize,
    /// Time by which its actions were moved, s; 0 unless it is aligned by progress.
    pub shift_s: f64,
}

/// Why a chunk is not followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unused {
    /// It is the chunk that is followed already.
    Repeated,
    /// It does not begin after the chunk that is followed; the time at which that one begins, s.
    Older(f64),
    /// All its actions are past.
    Late,
    /// Too many actions would have to be kept.
    Full,
}

/// A chunk that arrives: its actions with base-frame values, at the times at which they are due.
pub(crate) struct Arriving<'a, I> {
    /// The actions in the order of time.
    pub actions: I,
    /// Time of the first action as it was sent, s.
    pub first_s: f64,
    /// Which actions are past.
    pub align: Align,
    /// Where the arm is; `None`: the actions have no place.
    pub place: Option<&'a TargetValue>,
}

impl Chunk {
    /// Returns whether there is an action for a time or later, s.
    pub(super) fn covers(&self, time_s: f64) -> bool {
        self.actions.last().is_some_and(|last| last.time_s >= time_s)
    }

    /// Returns the latest time at which the actions certainly were as they are now, s; `None`: there are none.
    pub(super) fn known_s(&self) -> Option<f64> {
        self.actions.first().map(|first| self.merged_s.max(first.time_s))
    }

    /// Returns the number of actions to come after a time, s.
    pub(super) fn left(&self, time_s: f64) -> usize {
        self.actions.len() - self.actions.partition_point(|action| action.time_s <= time_s)
    }

    /// Returns value and velocity of the actions at a time, s, without what fades; `None`: no action.
    pub(super) fn motion(&self, quantity: Quantity, time_s: f64) -> Option<Reference> {
        let (first, last) = (self.actions.first()?, self.actions.last()?);
        if time_s <= first.time_s {
            return Some(self.start(first, quantity));
        }
        if time_s >= last.time_s {
            return Some(Reference { value: last.value.clone(), velocity: self.end_velocity(quantity)? });
        }
        let after = self.actions.partition_point(|action| action.time_s <= time_s);
        if !quantity.is_position() {
            return Some(curve::line(&self.actions[after - 1], &self.actions[after], time_s));
        }
        let knot = |k: usize| (self.actions[k].time_s, &self.actions[k].value);
        Some(curve::cubic(&knot, after - 1, self.actions.len() - 1, time_s))
    }

    /// Returns the motion with what is left of the one before, s.
    pub(super) fn faded(&self, motion: Reference, time_s: f64) -> Reference {
        match &self.fade {
            Some(fade) => fade.applied(&motion, time_s),
            None => motion,
        }
    }

    /// Returns the velocity at the last action.
    pub(super) fn end_velocity(&self, quantity: Quantity) -> Option<TaskVector> {
        let last = self.actions.last()?;
        let before = self.actions.len().checked_sub(2).filter(|_| quantity.is_position());
        Some(before.map_or_else(|| TaskVector::zeros(last.value.len()), |k| curve::slope(&self.actions[k], last)))
    }

    fn start(&self, first: &LaterTarget, quantity: Quantity) -> Reference {
        let second = self.actions.get(1).filter(|_| quantity.is_position());
        let velocity = second.map_or_else(|| TaskVector::zeros(first.value.len()), |next| curve::slope(first, next));
        Reference { value: first.value.clone(), velocity }
    }

    /// Forgets the actions and what fades, but not which chunk came last.
    pub(super) fn clear(&mut self) {
        self.actions.clear();
        self.fade = None;
    }

    /// Forgets all chunks.
    pub(super) fn forget(&mut self) {
        self.clear();
        (self.merged_s, self.first_s) = (0.0, None);
    }

    /// Forgets what no time from `time_s` on needs: all but two past actions, so that the curve stays the same.
    pub(super) fn drop_past(&mut self, time_s: f64) {
        let past = self.actions.partition_point(|action| action.time_s <= time_s);
        if past > 2 {
            self.actions.drain(..past - 2);
        }
        self.fade = self.fade.take().filter(|fade| !fade.is_over(time_s));
    }

    /// Replaces the actions from the first one of a chunk on, at `now_s`. `from`: the motion until now, and whether it stands for the
    /// time before the chunk begins.
    pub(super) fn merge<I: Iterator<Item = LaterTarget> + Clone>(
        &mut self,
        given: Arriving<'_, I>,
        quantity: Quantity,
        now_s: f64,
        from: &Reference,
    ) -> Result<Merged, Unused> {
        if let Some(first_s) = self.first_s.filter(|first_s| given.first_s - first_s < MIN_INTERVAL) {
            let is_known = given.first_s == first_s && self.is_followed(given.actions.clone(), now_s);
            return Err(if is_known { Unused::Repeated } else { Unused::Older(first_s) });
        }
        let place = given.place.filter(|_| given.align == Align::Progress);
        let shift_s = place.map_or(0.0, |place| shift(given.actions.clone(), place, now_s));
        let (count, dropped, first_s, last_s) = summary(given.actions.clone(), now_s - shift_s);
        if last_s + shift_s <= now_s || last_s < now_s - MAX_HORIZON {
            return Err(Unused::Late);
        }
        let kept = self.kept(first_s + shift_s, now_s);
        let fills_gap = kept == 0 && begins_after(first_s + shift_s, now_s);
        if kept + usize::from(fills_gap) + count > MAX_KEPT_ACTIONS {
            return Err(Unused::Full);
        }
        self.actions.truncate(kept);
        if fills_gap {
            self.actions.push(LaterTarget { time_s: now_s, value: from.value.clone() });
        }
        let moved = |action: LaterTarget| LaterTarget { time_s: action.time_s + shift_s, ..action };
        self.actions.extend(given.actions.map(moved));
        (self.first_s, self.merged_s) = (Some(given.first_s), now_s);
        debug_assert!(self.motion(quantity, now_s).is_some(), "a merged chunk has an action");
        Ok(Merged { dropped, shift_s })
    }

    /// Returns the number of actions that stay before a chunk that begins at `first_s`, s: none if it has begun, or if they have ended.
    fn kept(&self, first_s: f64, now_s: f64) -> usize {
        let kept = self.actions.partition_point(|action| first_s - action.time_s >= MIN_INTERVAL);
        let has_gap = self.actions[..kept].last().is_none_or(|last| last.time_s < now_s);
        if has_gap || !begins_after(first_s, now_s) { 0 } else { kept }
    }

    /// Returns whether a chunk ends with the actions that are to come, however it was moved in time.
    fn is_followed(&self, actions: impl Iterator<Item = LaterTarget> + Clone, now_s: f64) -> bool {
        let (count, left) = (actions.clone().count(), self.left(now_s));
        let known = &self.actions[self.actions.len() - left.min(self.actions.len())..];
        let Some(ends) = known.last().map(|last| last.time_s).zip(actions.clone().last().map(|last| last.time_s))
        else {
            return false;
        };
        let is_same = |(a, b): (LaterTarget, &LaterTarget)| {
            a.value == b.value && ((ends.1 - a.time_s) - (ends.0 - b.time_s)).abs() < MIN_INTERVAL
        };
        left <= count && actions.skip(count - left).zip(known).all(is_same)
    }
}

impl Clone for Chunk {
    fn clone(&self) -> Self {
        Self { actions: self.actions.clone(), fade: self.fade.clone(), ..*self }
    }

    // Without allocating.
    fn clone_from(&mut self, source: &Self) {
        self.actions.clone_from(&source.actions);
        self.fade.clone_from(&source.fade);
        (self.merged_s, self.first_s) = (source.merged_s, source.first_s);
    }
}

/// Returns whether a time comes after the present, and not by rounding alone, s.
fn begins_after(time_s: f64, now_s: f64) -> bool {
    time_s - now_s >= MIN_INTERVAL
}

/// Returns the number of actions, that of the past ones (up to `now_s`), and the times of the first and of the last one, s.
fn summary(actions: impl Iterator<Item = LaterTarget>, now_s: f64) -> (usize, usize, f64, f64) {
    actions.fold((0, 0, f64::INFINITY, f64::NEG_INFINITY), |(count, past, first, last), action| {
        let is_past = usize::from(action.time_s <= now_s);
        (count + 1, past + is_past, f64::min(first, action.time_s), f64::max(last, action.time_s))
    })
}

/// Returns the time by which a chunk is moved so that the place that is due now is where the arm is, s: of the places until now, the
/// nearest one.
fn shift(actions: impl Iterator<Item = LaterTarget>, place: &TargetValue, now_s: f64) -> f64 {
    let mut nearest: Option<(f64, f64)> = None;
    let mut before: Option<LaterTarget> = None;
    for action in actions {
        let (distance, time_s) = match &before {
            None => (place.distance(&action.value), action.time_s),
            Some(before) if before.time_s < now_s => nearest_on(before, &action, place, now_s),
            Some(_) => break,
        };
        if time_s <= now_s && nearest.is_none_or(|(least, _)| distance < least) {
            nearest = Some((distance, time_s));
        }
        before = Some(action);
    }
    nearest.map_or(0.0, |(_, time_s)| now_s - time_s)
}

/// Returns the least distance from the line between two actions until `now_s`, m and rad together, and the time of that place, s.
fn nearest_on(from: &LaterTarget, to: &LaterTarget, place: &TargetValue, now_s: f64) -> (f64, f64) {
    let (way, relative) = (to.value.minus(&from.value), place.minus(&from.value));
    let dot = |a: &TaskVector, b: &TaskVector| a.iter().zip(b.iter()).map(|(a, b)| a * b).sum::<f64>();
    let until = ((now_s - from.time_s) / (to.time_s - from.time_s)).min(1.0);
    let square = dot(&way, &way);
    let share = if square > 0.0 { (dot(&way, &relative) / square).clamp(0.0, until) } else { 0.0 };
    let rest = &relative - &(&way * share);
    (dot(&rest, &rest).sqrt(), from.time_s + share * (to.time_s - from.time_s))
}
