//! The streamed targets of all tasks in one period.

use super::task::ArmState;
use super::{ControllerConfig, Measurement, Memory, StreamedTarget};
use crate::law::TargetForce;
use crate::linalg::TaskVector;
use crate::streaming::{Bound, Ignored, Quantity, Target, TargetState, TargetStream, TargetValue};

/// The streamed target of a task in one period, as the answer reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetReport {
    /// Where the target comes from.
    pub state: TargetState,
    /// Time of the measurement minus time of the newest target, s; `None`: no target on this clock.
    pub age_s: Option<f64>,
    /// A target of this measurement that was ignored.
    pub ignored: Option<Ignored>,
}

/// A stream with the values that only this period uses.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ActiveStream {
    pub stream: TargetStream,
    /// Velocity of the target for the law. A law that integrates uses the velocity of the last period and the
    /// acceleration, as of the arm; the others use the velocity of this period.
    pub velocity: TaskVector,
    /// Acceleration of the target, velocity per second.
    pub acceleration: TaskVector,
    ignored: Option<Ignored>,
}

/// The streams of one task in this period.
#[derive(Clone, Copy, Default)]
pub(super) struct TaskStreams<'a> {
    /// Pose or joint positions.
    pub position: Option<&'a ActiveStream>,
    /// Velocity or force.
    pub rows: Option<&'a ActiveStream>,
}

/// Overwrites `streams` with the streams of this period.
pub(super) fn update(
    streams: &mut Vec<ActiveStream>,
    previous: &Memory,
    measurement: &Measurement,
    arm: &ArmState,
    config: &ControllerConfig,
) {
    streams.truncate(previous.target_streams.len());
    for (k, stream) in previous.target_streams.iter().enumerate() {
        match streams.get_mut(k) {
            Some(active) => active.stream.clone_from(stream),
            None => streams.push(ActiveStream::new(stream.clone())),
        }
    }
    for active in &mut *streams {
        active.ignored = None;
        active.stream.advance(config.period_s);
        active.stream.forget_future(measurement.time_s);
    }
    for target in &measurement.targets {
        accept(streams, target, previous, arm, config);
    }
    for active in streams {
        active.update(previous, arm, config);
    }
}

/// Returns whether no target came to a stream for so long that it brakes or rests.
pub(super) fn have_dropped_out(streams: &[ActiveStream]) -> bool {
    streams.iter().any(|active| active.stream.state == TargetState::Braking)
}

/// Adds a checked target to its stream, which it starts if there is none.
fn accept(
    streams: &mut Vec<ActiveStream>,
    given: &StreamedTarget,
    previous: &Memory,
    arm: &ArmState,
    config: &ControllerConfig,
) {
    let (k, quantity) = (given.task, given.value.quantity());
    let task = &config.tasks[k];
    let index = match streams.binary_search_by_key(&(k, quantity), ActiveStream::key) {
        Ok(index) => index,
        Err(index) => {
            let reference = task.own_reference(quantity, arm, previous.task_velocities[k].as_slice());
            streams.insert(index, ActiveStream::new(TargetStream::new(k, quantity, reference)));
            index
        }
    };
    let (value, velocity) = task.rows.target(given, arm);
    let target = Target { time_s: given.time_s, value, velocity };
    let ignored = streams[index].stream.accept(target, &task.streaming);
    streams[index].ignored = ignored.or(streams[index].ignored);
}

impl ActiveStream {
    fn new(stream: TargetStream) -> Self {
        let acceleration = TaskVector::zeros(stream.reference.velocity.len());
        Self { stream, velocity: acceleration.clone(), acceleration, ignored: None }
    }

    fn key(&self) -> (usize, Quantity) {
        (self.stream.task, self.stream.quantity)
    }

    /// Computes the reference of this period.
    fn update(&mut self, previous: &Memory, arm: &ArmState, config: &ControllerConfig) {
        let task = &config.tasks[self.stream.task];
        let before = self.stream.reference.velocity.clone();
        let quantity = self.stream.quantity;
        let bound = |entry: usize| task.bound(quantity, entry, arm.robot);
        // A law with a spring keeps its reference, so that it keeps a contact.
        let is_held = quantity.is_position() && !task.law.integrates();
        let achieved = previous.task_velocities[self.stream.task].as_slice();
        let held = is_held.then(|| task.rows.actual(achieved, arm));
        self.stream.update(arm.time_s, &task.streaming, bound, held.as_ref(), config.period_s);
        let after = &self.stream.reference.velocity;
        self.acceleration = &(after - &before) * (1.0 / config.period_s);
        self.velocity = if task.law.integrates() { before } else { after.clone() };
    }

    fn report(&self, time_s: f64) -> TargetReport {
        TargetReport { state: self.stream.state, age_s: self.stream.age(time_s), ignored: self.ignored }
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

    /// Replaces the velocity ẋ of force-controlled rows by one that brakes, if the stream of the force brakes.
    pub fn brake_forces(
        &self,
        velocity: &mut TaskVector,
        force: &TargetForce,
        integrator: &[f64],
        bound: impl Fn(usize) -> Bound,
        period: f64,
    ) {
        let brakes = |active: &ActiveStream| {
            active.stream.quantity == Quantity::Force && active.stream.state == TargetState::Braking
        };
        if !self.rows.is_some_and(brakes) {
            return;
        }
        for (row, velocity) in velocity.iter_mut().enumerate().filter(|(row, _)| force[*row].is_some()) {
            let change = bound(row).acceleration * period;
            *velocity = integrator[row] - integrator[row].clamp(-change, change);
        }
    }

    /// Returns the report of the stream with the oldest target; `None` without a stream.
    pub fn report(&self, time_s: f64) -> Option<TargetReport> {
        let reports = [self.position, self.rows].into_iter().flatten().map(|active| active.report(time_s));
        reports.reduce(|a, b| {
            let worst = if b.state > a.state { b } else { a };
            TargetReport { ignored: a.ignored.or(b.ignored), ..worst }
        })
    }
}
