//! The curve through targets of known times.

use super::reference::Reference;
use super::rotation_rate::{rate_of, velocity_of};
use super::value::TargetValue;
use crate::law::TaskVector;

/// Minimum time between two targets, s. The velocity between targets that are nearer means nothing.
pub const MIN_INTERVAL: f64 = 1e-6;

/// A target of a later time.
#[derive(Debug, Clone, PartialEq)]
pub struct LaterTarget {
    /// Time of the target on the clock of the states, s.
    pub time_s: f64,
    /// The value.
    pub value: TargetValue,
}

/// Returns value and velocity between the knots k and k + 1 of k = 0 … last: the cubic with the velocities of the parabolas through three
/// knots, and the slope of the piece at the first and the last knot. Value and velocity are continuous, also for orientations.
pub(super) fn cubic<'a>(
    knot: &dyn Fn(usize) -> (f64, &'a TargetValue),
    k: usize,
    last: usize,
    time_s: f64,
) -> Reference {
    let ((start, from), (end, to)) = (knot(k), knot(k + 1));
    let duration = end - start;
    let way = to.minus(from);
    let slope_at = |k: usize| {
        let ((t0, a), (t1, b), (t2, c)) = (knot(k - 1), knot(k), knot(k + 1));
        let [before, after] = [&b.minus(a) * (1.0 / (t1 - t0)), &c.minus(b) * (1.0 / (t2 - t1))];
        &(&before * ((t2 - t1) / (t2 - t0))) + &(&after * ((t1 - t0) / (t2 - t0)))
    };
    let rate = &way * (1.0 / duration);
    let first = if k == 0 { rate.clone() } else { slope_at(k) };
    let second = if k + 1 == last { rate } else { rate_of(from, &way, &slope_at(k + 1)) };
    let x = (time_s - start) / duration;
    // Hermite: value 0 and `way`, slopes `first` and `second`.
    let (h, g0, g1) = (x * x * (3.0 - 2.0 * x), x * (1.0 - x) * (1.0 - x), x * x * (x - 1.0));
    let moved = &(&way * h) + &(&(&first * (g0 * duration)) + &(&second * (g1 * duration)));
    let (h, g0, g1) = (6.0 * x * (1.0 - x) / duration, (1.0 - x) * (1.0 - 3.0 * x), x * (3.0 * x - 2.0));
    let rate = &(&way * h) + &(&(&first * g0) + &(&second * g1));
    Reference { value: from.plus(&moved), velocity: velocity_of(from, &moved, &rate) }
}

/// Returns value and velocity on the line between two targets, for quantities whose velocity may jump.
pub(super) fn line(from: &LaterTarget, to: &LaterTarget, time_s: f64) -> Reference {
    let rate = slope(from, to);
    Reference { value: from.value.plus(&(&rate * (time_s - from.time_s))), velocity: rate }
}

/// Returns the mean velocity from one target to the next.
pub(super) fn slope(from: &LaterTarget, to: &LaterTarget) -> TaskVector {
    &to.value.minus(&from.value) * (1.0 / (to.time_s - from.time_s))
}
