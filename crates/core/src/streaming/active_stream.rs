//! Streams of targets in one period.

use super::chunk::Merged;
use super::reference::Reference;
use super::stream::{Ignored, TargetState, TargetStream};
use super::value::{Quantity, TargetValue};
use crate::law::TaskVector;

/// The streamed target of a task in one period, as the answer reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetReport {
    /// Where the target comes from.
    pub state: TargetState,
    /// Time of the measurement minus time of the newest target, s; `None`: no target on this clock.
    pub age_s: Option<f64>,
    /// A target of this measurement that was ignored.
    pub ignored: Option<Ignored>,
    /// The chunk that the task follows.
    pub chunk: Option<ChunkReport>,
}

/// The chunk that a task follows in one period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChunkReport {
    /// Number of actions to come.
    pub actions_left: usize,
    /// Time until the last action, s; negative after it.
    pub ends_in_s: f64,
    /// What became of a chunk that came with this measurement; `None`: none came, or it was ignored.
    pub merged: Option<Merged>,
}

/// A stream with the values that only this period uses.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ActiveStream {
    pub stream: TargetStream,
    /// Velocity of the target for the law. A law that integrates uses the velocity of the last period and the
    /// acceleration, as of the arm; the others use the velocity of this period.
    pub velocity: TaskVector,
    /// Acceleration of the target, velocity per second.
    pub acceleration: TaskVector,
    /// A target of this period that was ignored.
    pub ignored: Option<Ignored>,
    /// What became of a chunk of this period.
    pub merged: Option<Merged>,
    /// Whether a chunk was forgotten in this period, because the clock went back.
    pub has_forgotten_chunk: bool,
}

/// The streams of one task in this period.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TaskStreams<'a> {
    /// Pose or joint positions.
    pub position: Option<&'a ActiveStream>,
    /// Velocity or force.
    pub rows: Option<&'a ActiveStream>,
}

/// Time constant with which the acceleration of a target decays, s.
const DECAY: f64 = 0.2;

/// Time for which a target is moved on at its velocity, s: longer than most drives take to come to rest.
const ACTING: f64 = 0.1;

/// Time constant with which the velocity fades then, s. A velocity that stayed would lead the virtual arm out of its reach.
const FADE: f64 = 0.2;

impl ActiveStream {
    pub fn new(stream: TargetStream) -> Self {
        let acceleration = TaskVector::zeros(stream.reference.velocity.len());
        let velocity = acceleration.clone();
        Self { stream, velocity, acceleration, ignored: None, merged: None, has_forgotten_chunk: false }
    }

    /// Returns what orders the streams: task and quantity.
    pub fn key(&self) -> (usize, Quantity) {
        (self.stream.task, self.stream.quantity)
    }

    /// Returns a stream with the target of a later time, s: the one that was given ahead, or else the target of `now` moved on.
    pub fn at(&self, now: f64, time_s: f64) -> Self {
        let TargetStream { task, quantity, reference, .. } = &self.stream;
        let value = self.stream.ahead_at(time_s).unwrap_or_else(|| reference.value.plus(&self.motion(time_s - now)));
        Self::new(TargetStream::new(*task, *quantity, Reference { value, velocity: reference.velocity.clone() }))
    }

    /// Returns how far the target moves on in some time, s: with an acceleration that decays, and from [`ACTING`] on with a velocity that
    /// fades.
    fn motion(&self, time: f64) -> TaskVector {
        let acting = time.min(ACTING);
        let (velocity, way) =
            (-DECAY * (-acting / DECAY).exp_m1(), DECAY * (DECAY * (-acting / DECAY).exp_m1() + acting));
        let fading = -FADE * ((acting - time) / FADE).exp_m1();
        &(&self.velocity * (acting + fading)) + &(&self.acceleration * (way + velocity * fading))
    }

    fn report(&self, time_s: f64) -> TargetReport {
        let TargetStream { state, chunk, .. } = &self.stream;
        let chunk = chunk.actions.last().map(|last| ChunkReport {
            actions_left: chunk.left(time_s),
            ends_in_s: last.time_s - time_s,
            merged: self.merged,
        });
        TargetReport { state: *state, age_s: self.stream.age(time_s), ignored: self.ignored, chunk }
    }
}

impl<'a> TaskStreams<'a> {
    /// Finds the streams of a task (index from 0).
    pub fn of(streams: &'a [ActiveStream], task: usize) -> Self {
        let mut found = Self::default();
        for active in streams.iter().filter(|active| active.stream.task == task) {
            let place = if active.stream.quantity.is_position() { &mut found.position } else { &mut found.rows };
            *place = Some(active);
        }
        found
    }

    /// Returns the streamed velocity or force, m; `None` without one.
    pub fn values(&self) -> Option<&'a TaskVector> {
        match &self.rows?.stream.reference.value {
            TargetValue::Rows(rows) => Some(rows),
            TargetValue::Pose(_) => None,
        }
    }

    /// Returns whether the force brakes because its targets fail to come.
    pub fn force_brakes(&self) -> bool {
        self.rows.is_some_and(|active| {
            active.stream.quantity == Quantity::Force && active.stream.state == TargetState::Braking
        })
    }

    /// Returns the report of the stream with the oldest target; `None` without a stream.
    pub fn report(&self, time_s: f64) -> Option<TargetReport> {
        let reports = [self.position, self.rows].into_iter().flatten().map(|active| active.report(time_s));
        reports.reduce(|a, b| {
            let worst = if b.state > a.state { b } else { a };
            TargetReport { ignored: a.ignored.or(b.ignored), chunk: worst.chunk.or(a.chunk).or(b.chunk), ..worst }
        })
    }
}
