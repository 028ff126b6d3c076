//! What a run made of the robot's limits. Whether they were broken is read off the trace, not off what the solver says.

use serde::Serialize;

use crate::simulator::recording::{AtLimit, Recording, Sample};
use crate::wire::{LimitKind, Limits, RobotJoint};

/// An excess below this, times 1 or the size of the value, is rounding.
pub const TOLERANCE: f64 = 1e-9;

/// Time at limits, and by how much they were broken. Limits are those that the controller is told to keep; the solver
/// `closed_form` ignores them all the same.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct LimitUse {
    /// Time (s) in which a limit held at least one joint back, or was broken, as the answers say.
    pub at_limits_s: f64,
    /// Largest excess of a position (rad or m); 0 when the limits held, as for the others.
    pub position_excess: f64,
    /// Largest excess of a commanded speed (rad/s or m/s).
    pub velocity_excess: f64,
    /// Largest excess of a commanded acceleration (rad/s² or m/s²).
    pub acceleration_excess: f64,
    /// Largest `|q̇_i|` as a fraction of that joint's limit; 0 where no joint has one.
    pub speed_use: f64,
}

impl LimitUse {
    /// Measures a run of an arm with these joints, whose controller is told to keep these limits.
    #[must_use]
    pub fn of(recording: &Recording, joints: &[RobotJoint], limits: &Limits) -> Self {
        let bounds: Vec<Bounds> = joints.iter().enumerate().map(|(i, joint)| Bounds::of(joint, limits, i)).collect();
        let mut sum = Self::default();
        let mut before: Option<&Sample> = None;
        for sample in &recording.samples {
            for (i, bounds) in bounds.iter().enumerate() {
                sum.take(bounds, Joint::of(sample, before, i, recording.period_s));
            }
            let at_limit = sample.limits.iter().any(|limit| *limit != AtLimit::Free);
            sum.at_limits_s += if at_limit { recording.period_s } else { 0.0 };
            before = Some(sample);
        }
        sum
    }

    /// Whether every limit held.
    #[must_use]
    pub fn kept(&self) -> bool {
        [self.position_excess, self.velocity_excess, self.acceleration_excess].iter().all(|excess| *excess == 0.0)
    }

    /// Counts one joint in one period.
    fn take(&mut self, bounds: &Bounds, joint: Joint) {
        let meet = |excess: &mut f64, value: f64, (low, high): (f64, f64)| {
            let beyond = (value - high).max(low - value);
            if beyond > TOLERANCE * (1.0 + value.abs()) {
                *excess = excess.max(beyond);
            }
        };
        meet(&mut self.position_excess, joint.position, bounds.position);
        meet(&mut self.velocity_excess, joint.velocity, bounds.velocity);
        meet(&mut self.acceleration_excess, joint.acceleration, bounds.acceleration);
        let limit = if joint.velocity < 0.0 { -bounds.velocity.0 } else { bounds.velocity.1 };
        if limit.is_finite() && limit > 0.0 {
            self.speed_use = self.speed_use.max(joint.velocity.abs() / limit);
        }
    }
}

/// Bounds of one joint; infinite where none counts.
struct Bounds {
    position: (f64, f64),
    velocity: (f64, f64),
    acceleration: (f64, f64),
}

const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

impl Bounds {
    fn of(joint: &RobotJoint, limits: &Limits, index: usize) -> Self {
        let symmetric = |limit: Option<f64>| limit.map_or(FREE, |limit| (-limit, limit));
        let kind = match limits {
            Limits::Robot(kind) => *kind,
            Limits::Box { lower, upper } => {
                let velocity = lower.get(index).copied().zip(upper.get(index).copied()).unwrap_or(FREE);
                return Self { position: FREE, velocity, acceleration: FREE };
            }
        };
        let counts = |from: LimitKind| kind_rank(kind) >= kind_rank(from);
        let position = joint.position_limit.filter(|_| counts(LimitKind::PositionVelocity));
        let velocity = joint.velocity_limit.filter(|_| counts(LimitKind::Velocity));
        let acceleration = joint.acceleration_limit.filter(|_| counts(LimitKind::PositionVelocityAcceleration));
        Self {
            position: position.map_or(FREE, |[low, high]| (low, high)),
            velocity: symmetric(velocity),
            acceleration: symmetric(acceleration),
        }
    }
}

/// Each kind counts what the one before does, and more.
const fn kind_rank(kind: LimitKind) -> u8 {
    match kind {
        LimitKind::None => 0,
        LimitKind::Velocity => 1,
        LimitKind::PositionVelocity => 2,
        LimitKind::PositionVelocityAcceleration => 3,
    }
}

/// What one joint did in one period.
#[derive(Clone, Copy)]
struct Joint {
    position: f64,
    velocity: f64,
    acceleration: f64,
}

impl Joint {
    /// The first command of a run starts from rest.
    fn of(sample: &Sample, before: Option<&Sample>, i: usize, period_s: f64) -> Self {
        let entry = |list: &[f64]| list.get(i).copied().unwrap_or(0.0);
        let velocity = entry(&sample.joint_velocity);
        let last = before.map_or(0.0, |before| entry(&before.joint_velocity));
        Self { position: entry(&sample.joint_position), velocity, acceleration: (velocity - last) / period_s }
    }
}
