//! One stream of targets.

use super::reference::clamp_norm;
use super::{Bound, Quantity, Reference, Streaming, TargetValue};
use crate::linalg::TaskVector;

/// Maximum time of a target after the time of the state, s. A target further ahead has another clock.
pub const MAX_AHEAD: f64 = 1.0;

/// One target.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Time of the target on the clock of the states, s.
    pub time_s: f64,
    /// The value.
    pub value: TargetValue,
    /// Velocity of the value, a displacement per second; `None`: estimated from the last two targets.
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
    /// It is not newer than the newest target.
    Older {
        /// Its time, s.
        time_s: f64,
        /// Time of the newest target, s.
        newest_s: f64,
    },
}

/// A stream of targets of one quantity of one task: the last two targets and the reference.
#[derive(Debug, Clone, PartialEq)]
pub struct TargetStream {
    /// Index of the task, from 0.
    pub task: usize,
    /// What the targets are.
    pub quantity: Quantity,
    /// The newest target.
    pub newest: Option<Target>,
    /// The target before it.
    pub previous: Option<Target>,
    /// The target of the last period.
    pub reference: Reference,
    /// The state of the last period.
    pub state: TargetState,
}

impl TargetStream {
    /// Starts a stream without targets at a reference.
    pub fn new(task: usize, quantity: Quantity, reference: Reference) -> Self {
        Self { task, quantity, newest: None, previous: None, reference, state: TargetState::Holding }
    }

    /// Adds a target unless it is not newer than the newest one.
    pub(crate) fn accept(&mut self, target: Target, settings: &Streaming) -> Option<Ignored> {
        if let Some(newest) = &self.newest
            && target.time_s <= newest.time_s
        {
            let (time_s, newest_s) = (target.time_s, newest.time_s);
            return Some(if target == *newest { Ignored::Repeated } else { Ignored::Older { time_s, newest_s } });
        }
        let replaced = self.newest.replace(target);
        // A line over a drop-out would not be the motion of the target.
        let is_recent =
            |old: &Target| self.newest.as_ref().is_some_and(|new| new.time_s - old.time_s <= settings.brake_after_s);
        self.previous = replaced.filter(is_recent);
        None
    }

    /// Forgets the targets if the clock of the states went back.
    pub(crate) fn forget_future(&mut self, time_s: f64) {
        if self.newest.as_ref().is_some_and(|newest| newest.time_s > time_s + MAX_AHEAD) {
            (self.newest, self.previous) = (None, None);
        }
    }

    /// Returns the time of the state minus the time of the newest target, s; `None` without a target.
    pub fn age(&self, time_s: f64) -> Option<f64> {
        self.newest.as_ref().map(|newest| time_s - newest.time_s)
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
        self.reference.advance(period);
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
        let age = time_s - newest.time_s - settings.delay_s;
        let velocity = self.velocity(newest, bound);
        let still = || TaskVector::zeros(velocity.len());
        let moved = |age: f64| newest.value.plus(&(&velocity * age));
        let (state, value, velocity) = if age <= 0.0 {
            let (value, velocity) = self.interpolated(newest, &velocity, age, settings);
            (TargetState::Following, value, velocity)
        } else if age <= settings.hold_after_s {
            let velocity = if self.quantity.is_position() { velocity.clone() } else { still() };
            (TargetState::Extrapolating, newest.value.plus(&(&velocity * age)), velocity)
        } else if age <= settings.brake_after_s {
            let age = if self.quantity.is_position() { settings.hold_after_s } else { 0.0 };
            (TargetState::Holding, moved(age), still())
        } else {
            (TargetState::Braking, self.reference.value.clone(), still())
        };
        (state, Reference { value, velocity })
    }

    /// Returns value and velocity on the line through the last two targets. Before the older one, the line goes on for
    /// `hold_after_s` at most.
    fn interpolated(
        &self,
        newest: &Target,
        velocity: &TaskVector,
        age: f64,
        settings: &Streaming,
    ) -> (TargetValue, TaskVector) {
        let Some(previous) = &self.previous else {
            let still = TaskVector::zeros(velocity.len());
            let velocity = if self.quantity.is_position() { velocity } else { &still };
            return (newest.value.plus(&(velocity * age.max(-settings.hold_after_s))), velocity.clone());
        };
        let interval = newest.time_s - previous.time_s;
        let after = (interval + age).max(-settings.hold_after_s);
        let slope = &newest.value.minus(&previous.value) * (1.0 / interval);
        (previous.value.plus(&(&slope * after)), slope)
    }

    /// Returns the velocity of the newest target, within the bounds.
    fn velocity(&self, newest: &Target, bound: impl Fn(usize) -> Bound) -> TaskVector {
        let mut velocity = match (&newest.velocity, &self.previous) {
            (Some(velocity), _) => velocity.clone(),
            (None, Some(previous)) => &newest.value.minus(&previous.value) * (1.0 / (newest.time_s - previous.time_s)),
            (None, None) => TaskVector::zeros(newest.value.len()),
        };
        for group in newest.value.groups() {
            let max = bound(group.start).velocity;
            clamp_norm(&mut velocity[group], max);
        }
        velocity
    }
}
