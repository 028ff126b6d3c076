//! What is left of an earlier motion, which fades.

use super::reference::{Bound, Reference};
use super::rotation_rate::{rate_of, turned_by, velocity_of};
use crate::law::TaskVector;

/// Largest second derivative of 1 − 10 x³ + 15 x⁴ − 6 x⁵, 10/√3, and largest first one, 15/8: of an offset of 1 that fades in 1 s.
const LARGEST_ACCELERATION: f64 = 5.773_502_691_896_258;
const LARGEST_RATE: f64 = 1.875;

/// An offset that fades to zero: the polynomial of degree five from value, velocity and acceleration at its start to zero for all three.
#[derive(Debug, Clone, PartialEq)]
pub struct Fade {
    /// Time at which it starts, s.
    pub start_s: f64,
    /// Time that it takes, s.
    pub duration_s: f64,
    /// Offset at the start, as a displacement: 6 entries for a pose (base axes), otherwise one per row.
    pub offset: TaskVector,
    /// Rate of the offset at the start, per second.
    pub rate: TaskVector,
    /// Second derivative of the offset at the start, per second².
    pub acceleration: TaskVector,
}

impl Fade {
    /// Returns the fade from a motion to another one at `time_s`; `None`: both are the same, or there is no time to fade.
    pub(super) fn between(
        old: &Reference,
        new: &Reference,
        acceleration: TaskVector,
        time_s: f64,
        duration_s: f64,
    ) -> Option<Self> {
        let offset = old.value.minus(&new.value);
        let difference = &old.velocity - &turned_by(&new.value, &offset, &new.velocity);
        let rate = rate_of(&new.value, &offset, &difference);
        let is_zero = [&offset, &rate, &acceleration].iter().all(|entries| entries.iter().all(|entry| *entry == 0.0));
        (duration_s > 0.0 && !is_zero).then_some(Self { start_s: time_s, duration_s, offset, rate, acceleration })
    }

    /// Returns the fade, longer if it would otherwise need more than half of the acceleration, or more than the velocity, that the
    /// reference may have. `motion`: to which it fades.
    pub(super) fn slowed(self, motion: &Reference, bound: impl Fn(usize) -> Bound) -> Self {
        let least = motion.value.groups().map(|group| {
            let Bound { velocity, acceleration } = bound(group.start);
            let distance = self.offset[group].iter().fold(0.0_f64, |norm, entry| norm.hypot(*entry));
            f64::max(
                (LARGEST_ACCELERATION * distance / (0.5 * acceleration)).sqrt(),
                LARGEST_RATE * distance / velocity,
            )
        });
        Self { duration_s: least.fold(self.duration_s, f64::max), ..self }
    }

    /// Returns whether nothing is left at a time, s.
    pub(super) fn is_over(&self, time_s: f64) -> bool {
        time_s >= self.start_s + self.duration_s
    }

    /// Returns a motion with what is left of the offset at a time, s.
    pub(super) fn applied(&self, motion: &Reference, time_s: f64) -> Reference {
        if self.is_over(time_s) {
            return motion.clone();
        }
        let [offset, rate] = [self.derivative(0, time_s), self.derivative(1, time_s)];
        let turned = turned_by(&motion.value, &offset, &motion.velocity);
        let velocity = &velocity_of(&motion.value, &offset, &rate) + &turned;
        Reference { value: motion.value.plus(&offset), velocity }
    }

    /// Returns a derivative of the offset, 0 to 2, at a time before its end, s.
    pub(super) fn derivative(&self, order: usize, time_s: f64) -> TaskVector {
        let (x, d) = ((time_s - self.start_s).max(0.0) / self.duration_s, self.duration_s);
        let (x2, x3, x4, x5) = (x * x, x * x * x, x.powi(4), x.powi(5));
        let [p, v, a] = match order {
            0 => [
                1.0 - 10.0 * x3 + 15.0 * x4 - 6.0 * x5,
                x - 6.0 * x3 + 8.0 * x4 - 3.0 * x5,
                0.5 * (x2 - 3.0 * x3 + 3.0 * x4 - x5),
            ],
            1 => [
                -30.0 * x2 + 60.0 * x3 - 30.0 * x4,
                1.0 - 18.0 * x2 + 32.0 * x3 - 15.0 * x4,
                0.5 * (2.0 * x - 9.0 * x2 + 12.0 * x3 - 5.0 * x4),
            ],
            _ => [
                -60.0 * x + 180.0 * x2 - 120.0 * x3,
                -36.0 * x + 96.0 * x2 - 60.0 * x3,
                0.5 * (2.0 - 18.0 * x + 36.0 * x2 - 20.0 * x3),
            ],
        };
        let scale = d.powi(-i32::try_from(order).unwrap_or(2));
        let entry = |i: usize| scale * (p * self.offset[i] + d * (v * self.rate[i] + d * a * self.acceleration[i]));
        TaskVector::from_fn(self.offset.len(), entry)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_starts_as_given_and_ends_at_rest() {
        let given = [0.3, -0.5, 2.0];
        let [offset, rate, acceleration] = given.map(|entry| TaskVector::from_slice(&[entry]));
        let fade = Fade { start_s: 1.0, duration_s: 0.4, offset, rate, acceleration };
        for (order, expected) in given.into_iter().enumerate() {
            assert!((fade.derivative(order, 1.0)[0] - expected).abs() < 1e-12, "{order}");
            assert!(fade.derivative(order, 1.4)[0].abs() < 1e-10, "{order}");
        }
        for time in [1.05, 1.2, 1.37] {
            for order in 0..2 {
                let h = 1e-5;
                let slope = (fade.derivative(order, time + h)[0] - fade.derivative(order, time - h)[0]) / (2.0 * h);
                assert!((slope - fade.derivative(order + 1, time)[0]).abs() < 1e-6, "{order} at {time}");
            }
        }
    }
}
