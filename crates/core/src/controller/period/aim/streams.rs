//! The streamed targets of all tasks in one period.

use crate::arm_state::ArmState;
use crate::controller::config::{ControllerConfig, TaskConfig};
use crate::controller::state::Memory;
use crate::law::TaskVector;
use crate::streaming::{
    Action, ActiveStream, Align, Arriving, Ignored, LaterTarget, Quantity, Reference, StreamedChunk, StreamedTarget,
    Target, TargetAhead, TargetState, TargetStream, TargetValue,
};

/// Overwrites `streams` with the streams of this period. Returns the tasks whose first chunk is ignored: they go on with their own targets.
pub(super) fn update(
    streams: &mut Vec<ActiveStream>,
    previous: &Memory,
    (targets, chunks): (&[StreamedTarget], &[StreamedChunk]),
    arm: &ArmState,
    config: &ControllerConfig,
) -> Vec<(usize, Ignored)> {
    streams.truncate(previous.target_streams.len());
    for (k, stream) in previous.target_streams.iter().enumerate() {
        match streams.get_mut(k) {
            Some(active) => active.stream.clone_from(stream),
            None => streams.push(ActiveStream::new(stream.clone())),
        }
    }
    let answered = previous.answered.as_ref();
    let back = answered.map_or(0.0, |answered| answered.time_s - arm.time_s);
    // While states are missing, the arm goes on with its command as long as that is valid.
    let held = answered.map_or(0.0, |answered| (answered.valid_for_ms as f64 / 1e3 - config.period_s).max(0.0));
    for active in &mut *streams {
        (active.ignored, active.merged) = (None, None);
        active.stream.advance(config.period_s + arm.missed_time.min(held));
        active.has_forgotten_chunk =
            active.stream.forget(arm.time_s, back, &config.tasks[active.stream.task].streaming);
    }
    for target in targets {
        accept(streams, target, previous, arm, config);
    }
    let merged = |chunk: &StreamedChunk| Some((chunk.task, merge(streams, chunk, previous, arm, config)?));
    let unused = chunks.iter().filter_map(merged).collect();
    for active in streams {
        advance(active, previous, arm, config);
    }
    unused
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
    let task = &config.tasks[given.task];
    let index = found_or_started(streams, (given.task, given.value.quantity()), previous, arm, config);
    let (value, velocity) = task.rows.target(given, arm.measured());
    let later = |ahead: &TargetAhead| LaterTarget {
        time_s: given.time_s + ahead.after_s,
        value: task.rows.target_value(&ahead.value, arm.measured()),
    };
    let ahead = given.ahead.iter().map(later).collect();
    let target = Target { time_s: given.time_s, value, velocity };
    let ignored = streams[index].stream.accept(target, ahead, &task.streaming);
    streams[index].ignored = ignored.or(streams[index].ignored);
}

/// Merges a checked chunk into its stream, which it starts if there is none. Returns why a chunk is ignored that would have started one.
fn merge(
    streams: &mut Vec<ActiveStream>,
    given: &StreamedChunk,
    previous: &Memory,
    arm: &ArmState,
    config: &ControllerConfig,
) -> Option<Ignored> {
    let first = given.actions.first()?;
    let (task, quantity) = (&config.tasks[given.task], first.value.quantity());
    let before = streams.len();
    let index = found_or_started(streams, (given.task, quantity), previous, arm, config);
    let is_new = streams.len() > before;
    let due = |action: &Action| LaterTarget {
        time_s: action.time_s + task.streaming.delay_s,
        value: task.rows.target_value(&action.value, arm.measured()),
    };
    let is_placed = given.align == Align::Progress && quantity.is_position();
    let place = is_placed.then(|| {
        let achieved = previous.task_velocities[given.task].as_slice();
        task.rows.actual(achieved, arm.at_rest()).value
    });
    let arriving = Arriving {
        actions: given.actions.iter().map(due),
        first_s: first.time_s,
        align: given.align,
        place: place.as_ref(),
    };
    let active = &mut streams[index];
    let bound = |entry: usize| task.bound(quantity, entry, &arm.robot);
    match active.stream.merge(arriving, arm.time_s, &task.streaming, bound) {
        Ok(merged) => active.merged = Some(merged),
        Err(ignored) if is_new => {
            streams.remove(index);
            return Some(ignored);
        }
        Err(ignored) => active.ignored = Some(ignored),
    }
    None
}

/// Returns the index of the stream of a task and quantity. One that is not there yet starts where the law asks for the motion that the arm
/// has: it compares the posture of rest with where the reference is then. A law with a spring starts at its own target, so that it keeps a
/// contact.
fn found_or_started(
    streams: &mut Vec<ActiveStream>,
    key: (usize, Quantity),
    previous: &Memory,
    arm: &ArmState,
    config: &ControllerConfig,
) -> usize {
    streams.binary_search_by_key(&key, ActiveStream::key).unwrap_or_else(|index| {
        let (k, quantity) = key;
        let TaskConfig { rows, law, .. } = &config.tasks[k];
        let reference = if quantity == Quantity::Force {
            let force = law.target_force(arm.profile_time(arm.time_s));
            Reference::at_rest(TargetValue::Rows(TaskVector::from_fn(rows.len(), |row| force[row].unwrap_or_default())))
        } else if quantity.is_position() && !law.integrates() {
            // Not at the target of the law, which may be far away.
            let at_rest = rows.actual(previous.task_velocities[k].as_slice(), arm.at_rest());
            Reference { value: at_rest.value.plus(&(&at_rest.velocity * -arm.time_to_rest)), ..at_rest }
        } else {
            rows.own_reference(quantity, arm, previous.task_velocities[k].as_slice())
        };
        streams.insert(index, ActiveStream::new(TargetStream::new(k, quantity, reference)));
        index
    })
}

/// Computes the reference of this period.
fn advance(active: &mut ActiveStream, previous: &Memory, arm: &ArmState, config: &ControllerConfig) {
    let task = &config.tasks[active.stream.task];
    let before = active.stream.reference.velocity.clone();
    let quantity = active.stream.quantity;
    let bound = |entry: usize| task.bound(quantity, entry, &arm.robot);
    // A law with a spring keeps its reference, so that it keeps a contact.
    let is_held = quantity.is_position() && !task.law.integrates();
    let achieved = previous.task_velocities[active.stream.task].as_slice();
    let held = is_held.then(|| task.rows.actual(achieved, arm.measured()));
    active.stream.update(arm.time_s, &task.streaming, bound, held.as_ref(), config.period_s);
    let after = &active.stream.reference.velocity;
    active.acceleration = &(after - &before) * (1.0 / config.period_s);
    active.velocity = if task.law.integrates() { before } else { after.clone() };
}
