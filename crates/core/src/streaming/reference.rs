//! The reference: the target of this period, which follows the desired value within bounds.

use super::TargetValue;
use crate::law::TaskVector;

/// The bounds of one group of entries of a reference, as norms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Maximum velocity, m/s or rad/s; infinite: no bound.
    pub velocity: f64,
    /// Maximum acceleration, m/s² or rad/s².
    pub acceleration: f64,
}

/// A value with its velocity.
///
/// For a velocity or a force, the value itself is bounded, and the velocity stays zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The value.
    pub value: TargetValue,
    /// Its velocity, as a displacement per second: 6 entries for a pose (base axes), otherwise one per row.
    pub velocity: TaskVector,
}

impl Reference {
    /// Builds a reference at rest.
    pub fn at_rest(value: TargetValue) -> Self {
        let velocity = TaskVector::zeros(value.len());
        Self { value, velocity }
    }

    /// Moves on to the next period of `period` s.
    pub(super) fn advance(&mut self, period: f64) {
        if self.velocity.iter().any(|entry| *entry != 0.0) {
            self.value = self.value.plus(&(&self.velocity * period));
        }
    }

    /// Changes the velocity so that the value follows a desired one.
    ///
    /// Without bounds this is a critically damped second-order filter with the time constant `smoothing` (s), whose
    /// error is zero for a uniformly moving target. Far from the target, it approaches at the speed from which half of
    /// the maximum acceleration can still stop it.
    pub(super) fn follow(&mut self, desired: &Self, bound: impl Fn(usize) -> Bound, smoothing: f64, period: f64) {
        let error = desired.value.minus(&self.value);
        for group in self.value.groups() {
            let Bound { velocity: max_velocity, acceleration } = bound(group.start);
            let distance = norm(&error[group.clone()]);
            let approach = if distance > 0.0 { approach_speed(distance, acceleration, smoothing, period) } else { 0.0 };
            let factor = if distance > 0.0 { approach / distance } else { 0.0 };
            let mut wanted = TaskVector::from_fn(group.len(), |i| {
                desired.velocity[group.start + i] + factor * error[group.start + i]
            });
            clamp_norm(&mut wanted, max_velocity);
            let blend = if smoothing > 0.0 { -(-2.0 * period / smoothing).exp_m1() } else { 1.0 };
            self.change(group, &wanted, blend, acceleration * period);
        }
    }

    /// Brakes the velocity towards zero. Returns whether it was zero already.
    pub(super) fn brake(&mut self, bound: impl Fn(usize) -> Bound, period: f64) -> bool {
        let is_at_rest = self.velocity.iter().all(|entry| *entry == 0.0);
        for group in self.value.groups() {
            let rest = TaskVector::zeros(group.len());
            let acceleration = bound(group.start).acceleration;
            self.change(group, &rest, 1.0, acceleration * period);
        }
        is_at_rest
    }

    /// Moves a value of velocities towards a wanted one, one row at a time.
    pub(super) fn follow_rows(
        &mut self,
        wanted: &TaskVector,
        bound: impl Fn(usize) -> Bound,
        smoothing: f64,
        period: f64,
    ) {
        let blend = if smoothing > 0.0 { -(-period / smoothing).exp_m1() } else { 1.0 };
        let TargetValue::Rows(rows) = &mut self.value else { return };
        for (row, value) in rows.iter_mut().enumerate() {
            let Bound { velocity, acceleration } = bound(row);
            let wanted = wanted[row].clamp(-velocity, velocity);
            let change = acceleration * period;
            *value = towards(*value, wanted, blend, change);
        }
    }

    /// Changes the velocity of a group towards `wanted` by a factor `blend`, and by at most `max_change`.
    fn change(&mut self, group: std::ops::Range<usize>, wanted: &TaskVector, blend: f64, max_change: f64) {
        let velocity = &mut self.velocity[group];
        let mut change = TaskVector::from_fn(wanted.len(), |i| blend * (wanted[i] - velocity[i]));
        if blend == 1.0 && norm(&change) <= max_change {
            // Exactly the wanted velocity, so that a braked reference is at rest.
            velocity.copy_from_slice(wanted);
            return;
        }
        clamp_norm(&mut change, max_change);
        velocity.iter_mut().zip(change.iter()).for_each(|(velocity, change)| *velocity += change);
    }
}

/// Returns `value` moved towards `wanted` by a factor `blend`, and by at most `max_change`.
pub(super) fn towards(value: f64, wanted: f64, blend: f64, max_change: f64) -> f64 {
    let change = blend * (wanted - value);
    if blend == 1.0 && change.abs() <= max_change { wanted } else { value + change.clamp(-max_change, max_change) }
}

/// Returns the speed with which a reference approaches a desired value at this distance.
fn approach_speed(distance: f64, acceleration: f64, smoothing: f64, period: f64) -> f64 {
    let gain = if smoothing > 0.0 { (0.5 / smoothing).min(1.0 / period) } else { 1.0 / period };
    // With this speed at each distance, each period brakes by exactly half of the acceleration.
    let change = 0.25 * acceleration * period;
    let stoppable = (change * change + acceleration * distance).sqrt() - change;
    (gain * distance).min(stoppable)
}

fn norm(entries: &[f64]) -> f64 {
    entries.iter().fold(0.0_f64, |norm, entry| norm.hypot(*entry))
}

/// Shortens a vector to a maximum norm, and keeps its direction.
pub(super) fn clamp_norm(entries: &mut [f64], max: f64) {
    let length = norm(entries);
    if length > max {
        for entry in entries {
            *entry *= max / length;
        }
    }
}
