//! Chunks of one stream: the curve through the actions, merges, and what is forgotten.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::{Arriving, Chunk, Ignored, Merged, TargetState, TargetStream};
use crate::law::TaskVector;
use crate::streaming::{Align, Bound, LaterTarget, Quantity, Reference, Streaming, TargetValue};

const PERIOD: f64 = 0.008;

fn pose(position: [f64; 3], rotation: [f64; 3]) -> TargetValue {
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(rotation));
    TargetValue::Pose(Isometry3::from_parts(Translation3::from(position), rotation))
}

fn rows(values: &[f64]) -> TargetValue {
    TargetValue::Rows(TaskVector::from_slice(values))
}

fn stream(quantity: Quantity, start: TargetValue) -> TargetStream {
    TargetStream::new(0, quantity, Reference::at_rest(start))
}

fn merge(stream: &mut TargetStream, actions: &[LaterTarget], now_s: f64) -> Result<Merged, Ignored> {
    merge_at(stream, actions, now_s, None)
}

fn merge_at(
    stream: &mut TargetStream,
    actions: &[LaterTarget],
    now_s: f64,
    place: Option<&TargetValue>,
) -> Result<Merged, Ignored> {
    let align = if place.is_some() { Align::Progress } else { Align::Time };
    let arriving = Arriving { actions: actions.iter().cloned(), first_s: actions[0].time_s, align, place };
    stream.merge(arriving, now_s, &Streaming::default(), |_| Bound { velocity: 1e6, acceleration: 1e9 })
}

/// Returns actions from `start` on, `interval` s apart.
fn actions(start: f64, interval: f64, values: impl IntoIterator<Item = TargetValue>) -> Vec<LaterTarget> {
    let at = |(k, value)| LaterTarget { time_s: start + f64::from(k) * interval, value };
    (0_u32..).zip(values).map(at).collect()
}

/// Returns a random walk of poses that turn by up to 1 rad per action.
fn walk(steps: &[[f64; 6]]) -> Vec<TargetValue> {
    let mut value = pose([0.4, 0.0, 0.3], [0.2, -0.3, 0.1]);
    let step = |entries: &[f64; 6]| {
        value = value.plus(entries);
        value.clone()
    };
    steps.iter().map(step).collect()
}

fn steps() -> impl Strategy<Value = Vec<[f64; 6]>> {
    let entries = || -0.05..0.05_f64;
    let turn = || -0.6..0.6_f64;
    let step = (entries(), entries(), entries(), turn(), turn(), turn());
    prop::collection::vec(step.prop_map(|(a, b, c, d, e, f)| [a, b, c, d, e, f]), 2..40)
}

/// Returns how far two motions differ, in value and in velocity.
fn difference(a: &Reference, b: &Reference) -> [f64; 2] {
    let velocity = (&a.velocity - &b.velocity).iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    [a.value.distance(&b.value), velocity]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10_000))]

    /// 10⁴ random streams: 0 to 800 ms of latency, jitter, drop-outs. Where a chunk is merged, neither value nor velocity jumps.
    #[test]
    fn no_merge_makes_value_or_velocity_jump(
        chunks in prop::collection::vec((steps(), 0.0..0.8_f64, 0.02..0.1_f64, any::<bool>()), 1..6),
        gap in 0.05..0.8_f64,
    ) {
        let mut stream = stream(Quantity::Pose, pose([0.4, 0.0, 0.3], [0.0; 3]));
        let mut now = 0.0;
        for (steps, latency, interval, by_progress) in chunks {
            // A policy looked at the arm at `now` - `latency`, and its chunk arrives now.
            let chunk = actions(now - latency, interval, walk(&steps));
            let before = stream.followed(now);
            let place = by_progress.then(|| before.value.clone());
            if merge_at(&mut stream, &chunk, now, place.as_ref()).is_ok() {
                let [value, velocity] = difference(&stream.followed(now), &before);
                prop_assert!(value < 1e-9 && velocity < 1e-7, "{value:e}, {velocity:e} at {now}");
                // The velocity is that of the value, also between the actions and while the offset fades.
                for k in 1..20 {
                    let (time, h) = (now + f64::from(k) * 0.0137, 1e-6);
                    if stream.chunk.covers(time + h) {
                        let [early, at, late] = [time - h, time, time + h].map(|time| stream.followed(time));
                        let slope = &late.value.minus(&early.value) * (0.5 / h);
                        let error = (&slope - &at.velocity).iter().map(|entry| entry.abs()).fold(0.0, f64::max);
                        prop_assert!(error < 2e-3, "{error:e} at {time}");
                    }
                }
            }
            now += gap;
            stream.forget(now, 0.0, &Streaming::default());
        }
    }

    #[test]
    fn forgetting_past_actions_does_not_change_the_motion(steps in steps(), share in 0.0..1.0_f64) {
        let mut stream = stream(Quantity::Pose, pose([0.4, 0.0, 0.3], [0.0; 3]));
        merge(&mut stream, &actions(0.0, 0.04, walk(&steps)), 0.0).unwrap();
        let whole = stream.clone();
        let time = share * 0.04 * (steps.len() - 1) as f64;
        stream.forget(time, 0.0, &Streaming::default());
        for later in [0.0, 0.013, 0.04, 0.3] {
            prop_assert_eq!(stream.followed(time + later), whole.followed(time + later));
        }
    }
}

#[test]
fn a_curve_passes_its_actions_and_a_uniform_motion_is_exact() {
    let mut uniform = stream(Quantity::JointPosition, rows(&[0.0]));
    merge(&mut uniform, &actions(0.0, 0.1, (0..20).map(|k| rows(&[0.05 * f64::from(k)]))), 0.0).unwrap();
    for time in [0.4, 0.77, 1.234] {
        let Reference { value, velocity } = uniform.followed(time);
        assert!(value.distance(&rows(&[0.5 * time])) < 1e-12 && (velocity[0] - 0.5).abs() < 1e-12, "{time}");
    }
    let values =
        walk(&[[0.05, 0.0, -0.02, 0.5, 0.3, 0.0], [0.0, 0.04, 0.0, -0.4, 0.6, 0.2], [0.01, 0.0, 0.0, 0.0, 0.0, 0.9]]);
    let mut turning = stream(Quantity::Pose, values[0].clone());
    merge(&mut turning, &actions(0.0, 0.5, values.clone()), 0.0).unwrap();
    assert!(turning.followed(0.5).value.distance(&values[1]) < 1e-9);
}

#[test]
fn a_chunk_replaces_actions_from_its_first_one_on() {
    let mut stream = stream(Quantity::JointPosition, rows(&[0.0]));
    merge(&mut stream, &actions(0.0, 0.1, (0..10).map(|_| rows(&[0.0]))), 0.0).unwrap();
    let later = actions(0.45, 0.1, (0..3).map(|_| rows(&[1.0])));
    assert_eq!(merge(&mut stream, &later, 0.2), Ok(Merged { dropped: 0, shift_s: 0.0 }));
    let times: Vec<f64> = stream.chunk.actions.iter().map(|action| (action.time_s * 100.0).round() / 100.0).collect();
    assert_eq!(times, [0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.55, 0.65]);
    assert_eq!(stream.chunk.left(0.2), 5);
}

#[test]
fn late_repeated_and_older_chunks_change_nothing() {
    let mut stream = stream(Quantity::JointPosition, rows(&[0.0]));
    let chunk = actions(1.0, 0.1, (0..5).map(|k| rows(&[f64::from(k)])));
    assert_eq!(merge(&mut stream, &chunk, 2.0), Err(Ignored::Late { last_s: chunk[4].time_s }));
    assert!(stream.chunk.actions.is_empty());
    assert_eq!(merge(&mut stream, &chunk, 1.15), Ok(Merged { dropped: 2, shift_s: 0.0 }));
    let known = stream.clone();
    assert_eq!(merge(&mut stream, &chunk, 1.2), Err(Ignored::Repeated));
    let older = actions(0.9, 0.1, (0..9).map(|_| rows(&[5.0])));
    assert_eq!(merge(&mut stream, &older, 1.2), Err(Ignored::Older { time_s: 0.9, newest_s: 1.0 }));
    let contradictory = actions(1.0, 0.1, (0..5).map(|_| rows(&[5.0])));
    assert_eq!(merge(&mut stream, &contradictory, 1.2), Err(Ignored::Older { time_s: 1.0, newest_s: 1.0 }));
    assert_eq!(stream, known);
}

/// 800 ms of inference against 16 actions of 30 Hz: by time all are past; by progress those are past that the arm has done.
#[test]
fn progress_decides_which_actions_are_past() {
    let chunk = actions(0.0, 1.0 / 30.0, (0..16).map(|k| rows(&[0.01 * f64::from(k)])));
    let mut stream = stream(Quantity::JointPosition, rows(&[0.0]));
    assert!(matches!(merge(&mut stream, &chunk, 0.8), Err(Ignored::Late { .. })));
    let Merged { dropped, shift_s } = merge_at(&mut stream, &chunk, 0.8, Some(&rows(&[0.045]))).unwrap();
    assert_eq!(dropped, 5);
    assert!((shift_s - (0.8 - 4.5 / 30.0)).abs() < 1e-9, "{shift_s}");
    assert!(stream.followed(0.8).value.distance(&rows(&[0.0])) < 1e-12, "the offset to the reference fades");
    assert_eq!(merge_at(&mut stream, &chunk, 0.9, Some(&rows(&[0.05]))), Err(Ignored::Repeated));
    assert!(stream.followed(1.1).value.distance(&rows(&[0.01 * (4.5 + 9.0)])) < 1e-9);
}

#[test]
fn the_number_of_kept_actions_is_bounded() {
    let mut stream = stream(Quantity::JointPosition, rows(&[0.0]));
    for k in 0..2 {
        let start = 1.0 + 2.6 * f64::from(k);
        merge(&mut stream, &actions(start, 0.01, (0..256).map(|_| rows(&[0.0]))), 0.0).unwrap();
    }
    let more = actions(6.2, 0.01, (0..256).map(|_| rows(&[0.0])));
    assert_eq!(merge(&mut stream, &more, 0.0), Err(Ignored::Full));
}

#[test]
fn a_clock_that_goes_back_ends_a_chunk() {
    let mut stream = stream(Quantity::JointPosition, rows(&[0.0]));
    merge(&mut stream, &actions(5.0, 0.1, (0..30).map(|_| rows(&[1.0]))), 5.0).unwrap();
    stream.forget(4.5, 0.0, &Streaming::default());
    assert!(!stream.chunk.actions.is_empty());
    stream.forget(3.9, 0.0, &Streaming::default());
    assert_eq!((stream.newest.clone(), &stream.chunk), (None, &Chunk::default()));
}

/// The reference changes its velocity by at most the bound, whatever comes.
#[test]
fn a_reference_keeps_its_bounds_over_chunks() {
    let mut stream = stream(Quantity::JointPosition, rows(&[0.0]));
    let bound = |_| Bound { velocity: 1.0, acceleration: 5.0 };
    let mut before = 0.0;
    for k in 0..500_u32 {
        let now = f64::from(k) * PERIOD;
        stream.advance(PERIOD);
        stream.forget(now, 0.0, &Streaming::default());
        if k % 40 == 0 && k % 120 != 80 {
            let target = if k % 80 == 0 { 0.4 } else { -0.3 };
            merge(&mut stream, &actions(now - 0.2, 0.05, (0..20).map(|_| rows(&[target]))), now).unwrap();
        }
        stream.update(now, &Streaming::default(), bound, None, PERIOD);
        let velocity = stream.reference.velocity[0];
        assert!(
            (velocity - before).abs() <= 5.0 * PERIOD + 1e-12 && velocity.abs() <= 1.0 + 1e-12,
            "{velocity} at {now}"
        );
        before = velocity;
    }
}

/// The last action is due at the same time, whatever the delay was when it came.
#[test]
fn another_delay_leaves_the_end_of_a_chunk_where_it_is() {
    let mut stream = stream(Quantity::JointPosition, rows(&[0.0]));
    merge(&mut stream, &actions(0.0, 0.1, (0..10).map(|k| rows(&[0.1 * f64::from(k)]))), 0.0).unwrap();
    let delayed = Streaming { delay_s: 0.3, ..Streaming::default() };
    let state_at = |time_s: f64| {
        let mut stream = stream.clone();
        let bound = |_| Bound { velocity: 1.0, acceleration: 5.0 };
        stream.update(time_s, &delayed, bound, None, PERIOD);
        (stream.state, stream.age(time_s).unwrap())
    };
    let (state, age) = state_at(0.89);
    assert!(state == TargetState::Following && (age + 0.01).abs() < 1e-12, "{age}");
    assert_eq!(state_at(0.91).0, TargetState::Extrapolating);
}
