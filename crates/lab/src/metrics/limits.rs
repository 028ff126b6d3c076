//! Use of the robot's limits in a run. Excesses are computed from the recorded motion, not from the report of the solver.

use revprio_api::wire::{Limits, RobotJoint};
use revprio_robot::VelocityEnvelope;
use serde::Serialize;

use crate::simulator::recording::{Recording, Sample};

/// An excess below this, relative to 1 + |value|, counts as rounding.
pub const TOLERANCE: f64 = 1e-9;

/// Time at limits and largest excesses. The limits are the ones in the settings of the controller. The solver `closed_form`
/// ignores them.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct LimitUse {
    /// Time (s) in which a limit was active or exceeded for at least one joint, according to the answers.
    pub at_limits_s: f64,
    /// Largest excess of a position (rad or m); 0 if no limit was exceeded, here and below.
    pub position_excess: f64,
    /// Largest excess of a commanded speed (rad/s or m/s) over its limit at the position of the sample.
    pub velocity_excess: f64,
    /// Largest excess of a commanded acceleration (rad/s² or m/s²).
    pub acceleration_excess: f64,
    /// Largest excess of a commanded jerk (rad/s³ or m/s³) of a joint that states a jerk limit.
    pub jerk_excess: f64,
    /// Largest `|q̇_i|` as a fraction of the velocity limit of the joint; 0 if no joint has one.
    pub speed_use: f64,
}

impl LimitUse {
    /// Measures a run with these joints and these limits of the controller.
    #[must_use]
    pub fn of(recording: &Recording, joints: &[RobotJoint], limits: &Limits) -> Self {
        let bounds: Vec<Bounds> = joints.iter().enumerate().map(|(i, joint)| Bounds::of(joint, limits, i)).collect();
        let mut sum = Self::default();
        let mut before = [None; 2];
        for sample in &recording.samples {
            for (i, bounds) in bounds.iter().enumerate() {
                sum.add(bounds, Joint::of(sample, before, i, recording.period_s));
            }
            sum.at_limits_s += if sample.is_at_limit() { recording.period_s } else { 0.0 };
            before = [Some(sample), before[0]];
        }
        sum
    }

    /// Returns whether no limit was exceeded.
    #[must_use]
    pub fn kept(&self) -> bool {
        let excesses = [self.position_excess, self.velocity_excess, self.acceleration_excess, self.jerk_excess];
        excesses.iter().all(|excess| *excess == 0.0)
    }

    /// Adds one joint in one period.
    fn add(&mut self, bounds: &Bounds, joint: Joint) {
        let update = |excess: &mut f64, value: f64, (low, high): (f64, f64)| {
            let beyond = (value - high).max(low - value);
            if beyond > TOLERANCE * (1.0 + value.abs()) {
                *excess = excess.max(beyond);
            }
        };
        update(&mut self.position_excess, joint.position, bounds.position);
        update(&mut self.velocity_excess, joint.velocity, bounds.velocity_at(joint.position));
        update(&mut self.acceleration_excess, joint.acceleration, bounds.acceleration);
        update(&mut self.jerk_excess, joint.jerk, bounds.jerk);
        let limit = if joint.velocity < 0.0 { -bounds.velocity.0 } else { bounds.velocity.1 };
        if limit.is_finite() && limit > 0.0 {
            self.speed_use = self.speed_use.max(joint.velocity.abs() / limit);
        }
    }
}

/// Bounds of one joint; infinite where there is no limit.
struct Bounds {
    position: (f64, f64),
    velocity: (f64, f64),
    acceleration: (f64, f64),
    jerk: (f64, f64),
    /// Shrinks `velocity` towards the ends of `position`.
    envelope: VelocityEnvelope,
}

const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

impl Bounds {
    const NONE: Self =
        Self { position: FREE, velocity: FREE, acceleration: FREE, jerk: FREE, envelope: VelocityEnvelope::NONE };

    fn of(joint: &RobotJoint, limits: &Limits, index: usize) -> Self {
        let symmetric = |limit: Option<f64>| limit.map_or(FREE, |limit| (-limit, limit));
        let kind = match limits {
            Limits::Robot(kind) => *kind,
            Limits::Box { lower, upper } => {
                let velocity = lower.get(index).copied().zip(upper.get(index).copied()).unwrap_or(FREE);
                return Self { velocity, ..Self::NONE };
            }
        };
        let position = joint.position_limit.filter(|_| kind.includes_position());
        let velocity = joint.velocity_limit.filter(|_| kind.includes_velocity());
        let acceleration = joint.acceleration_limit.filter(|_| kind.includes_acceleration());
        Self {
            position: position.map_or(FREE, |[low, high]| (low, high)),
            velocity: symmetric(velocity),
            acceleration: symmetric(acceleration),
            jerk: symmetric(joint.jerk_limit.filter(|_| kind.includes_acceleration())),
            envelope: joint.velocity_envelope.filter(|_| kind.includes_position()).map_or(
                VelocityEnvelope::NONE,
                |wire| VelocityEnvelope { deceleration: wire.deceleration_limit, offset: wire.velocity_offset },
            ),
        }
    }

    /// Returns the bounds of the velocity at a position.
    fn velocity_at(&self, position: f64) -> (f64, f64) {
        let towards = |distance| self.envelope.max_speed(distance);
        let (slowest, fastest) = (-towards(position - self.position.0), towards(self.position.1 - position));
        (self.velocity.0.max(slowest), self.velocity.1.min(fastest))
    }
}

/// Motion of one joint in one period.
#[derive(Clone, Copy)]
struct Joint {
    position: f64,
    velocity: f64,
    acceleration: f64,
    jerk: f64,
}

impl Joint {
    /// Computes acceleration and jerk from the two commands before, the last one first; a run starts at rest.
    fn of(sample: &Sample, before: [Option<&Sample>; 2], i: usize, period_s: f64) -> Self {
        let entry = |list: &[f64]| list.get(i).copied().unwrap_or(0.0);
        let velocity = entry(&sample.joint_velocity);
        let [last, earlier] = before.map(|before| before.map_or(0.0, |before| entry(&before.joint_velocity)));
        Self {
            position: entry(&sample.joint_position),
            velocity,
            acceleration: (velocity - last) / period_s,
            jerk: (velocity - 2.0 * last + earlier) / (period_s * period_s),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::recording::AtLimit;
    use revprio_api::wire::{JointKind, LimitKind, VelocityEnvelope};

    fn joint() -> RobotJoint {
        RobotJoint {
            name: "a".to_owned(),
            kind: JointKind::Revolute,
            unit: "rad".to_owned(),
            position_limit: Some([-1.0, 2.0]),
            velocity_limit: Some(0.5),
            acceleration_limit: Some(10.0),
            jerk_limit: Some(150.0),
            velocity_envelope: None,
            published_range: None,
            denavit_hartenberg: None,
        }
    }

    /// One sample per period of 0.1 s: position and commanded velocity of one joint.
    fn measured(samples: &[(f64, f64)], limits: &Limits) -> LimitUse {
        let sample = |&(position, velocity): &(f64, f64)| Sample {
            joint_position: vec![position],
            joint_velocity: vec![velocity],
            ..Sample::at_rest()
        };
        let samples = samples.iter().map(sample).collect();
        LimitUse::of(&Recording { period_s: 0.1, samples, ..Recording::empty() }, &[joint()], limits)
    }

    fn near(value: f64, expected: f64) -> bool {
        (value - expected).abs() < 1e-12
    }

    #[test]
    fn motion_at_a_limit_does_not_exceed_it() {
        let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
        let run = measured(&[(2.0, 0.5), (-1.0, -0.5)], &limits);
        assert!(run.kept(), "{run:?}");
        assert!(near(run.speed_use, 1.0));
    }

    #[test]
    fn only_limits_of_the_selected_kind_are_checked() {
        let trace = [(-1.25, -0.75), (2.5, 1.0)];
        let all = measured(&trace, &Limits::Robot(LimitKind::PositionVelocityAcceleration));
        assert!(near(all.position_excess, 0.5) && near(all.velocity_excess, 0.5) && near(all.acceleration_excess, 7.5));
        // −0.75, then 1.0 rad/s, in 0.1 s each: −75, then 250 rad/s³.
        assert!((all.jerk_excess - 100.0).abs() < 1e-9, "{all:?}");
        let without = Joint { jerk: 1e3, ..Joint::of(&Sample::at_rest(), [None; 2], 0, 0.1) };
        let mut none = LimitUse::default();
        let free = RobotJoint { jerk_limit: None, ..joint() };
        none.add(&Bounds::of(&free, &Limits::Robot(LimitKind::PositionVelocityAcceleration), 0), without);
        assert!(none.kept(), "{none:?}");
        let velocity = measured(&trace, &Limits::Robot(LimitKind::Velocity));
        assert!(velocity.position_excess == 0.0 && near(velocity.velocity_excess, 0.5) && !velocity.kept());
        assert!(measured(&trace, &Limits::Robot(LimitKind::None)).kept());
    }

    #[test]
    fn the_speed_counts_towards_the_end_that_is_near() {
        let envelope = VelocityEnvelope { deceleration_limit: 2.0, velocity_offset: 0.1 };
        let joint = RobotJoint { velocity_envelope: Some(envelope), ..joint() };
        let bounds = |kind| Bounds::of(&joint, &Limits::Robot(kind), 0);
        // √(2 · 2 · 0.04) − 0.1 = 0.3, and within 0.1²/(2 · 2) nothing.
        let (low, high) = bounds(LimitKind::PositionVelocity).velocity_at(1.96);
        assert!(near(low, -0.5) && near(high, 0.3), "{low} {high}");
        assert_eq!(bounds(LimitKind::PositionVelocity).velocity_at(-0.998), (0.0, 0.5));
        assert_eq!(bounds(LimitKind::Velocity).velocity_at(1.999), (-0.5, 0.5));
        let mut run = LimitUse::default();
        let motion = Joint { position: 1.96, velocity: 0.4, ..Joint::of(&Sample::at_rest(), [None; 2], 0, 0.1) };
        run.add(&bounds(LimitKind::PositionVelocity), motion);
        assert!(near(run.velocity_excess, 0.1) && !run.kept(), "{run:?}");
    }

    #[test]
    fn limits_of_the_controller_replace_those_of_the_robot() {
        let limits = Limits::Box { lower: vec![-0.1], upper: vec![2.0] };
        assert!(near(measured(&[(9.0, -0.3), (9.0, 1.9)], &limits).velocity_excess, 0.2));
    }

    #[test]
    fn time_at_limits_comes_from_the_answers() {
        let sample = |limit| Sample { limits: vec![AtLimit::Free, limit], ..Sample::at_rest() };
        let samples = [AtLimit::Free, AtLimit::Upper, AtLimit::Below].map(sample).to_vec();
        let run = Recording { period_s: 0.1, samples, ..Recording::empty() };
        assert!(near(LimitUse::of(&run, &[], &Limits::Robot(LimitKind::Velocity)).at_limits_s, 0.2));
    }
}
