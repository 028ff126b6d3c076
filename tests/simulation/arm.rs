//! An arm: one integrator per joint, with the watchdog of the guide. It holds a command until its time is over and then
//! brakes.

use std::sync::Arc;

use revprio_api::wire;
use revprio_robot::RobotModel;
use tokio::time::Instant;

use crate::random::Random;

/// Distance outside the range that the limits permit an arm whose drive is faster than stated or whose states come late, rad
/// or m: docs/limits.md.
const TOLERANCE: f64 = 5e-4;

/// An arm that follows its commands exactly.
pub struct Arm {
    robot: Arc<RobotModel>,
    /// q, rad or m.
    position: Vec<f64>,
    /// The last command, rad/s or m/s.
    command: Vec<f64>,
    /// Deceleration of the watchdog; infinite: stop at once.
    deceleration: Vec<f64>,
    /// Time at which the watchdog brakes.
    brakes_at: Instant,
    now: Instant,
}

impl Arm {
    /// Puts an arm at rest somewhere inside its range, often near a limit.
    pub fn at_rest(robot: &Arc<RobotModel>, random: &mut Random) -> Self {
        let place = |joint: &revprio_robot::Joint| {
            let (lower, upper) = (joint.limits.lower.max(-3.0), joint.limits.upper.min(3.0));
            match random.below(4) {
                0 => (lower + random.between(0.0, 0.02)).min(upper),
                1 => (upper - random.between(0.0, 0.02)).max(lower),
                _ => random.between(lower, upper),
            }
        };
        let position: Vec<f64> = robot.joints().iter().map(place).collect();
        let (n, now) = (position.len(), Instant::now());
        Self {
            robot: Arc::clone(robot),
            position,
            command: vec![0.0; n],
            deceleration: vec![f64::INFINITY; n],
            brakes_at: now,
            now,
        }
    }

    /// Moves the arm until now.
    pub fn advance(&mut self) {
        let now = Instant::now();
        let (from, to) = (self.braking_time(self.now), self.braking_time(now));
        let held = now.min(self.brakes_at).saturating_duration_since(self.now).as_secs_f64();
        for i in 0..self.position.len() {
            let distance = |time: f64| braking_distance(self.command[i], self.deceleration[i], time);
            self.position[i] += self.command[i] * held + distance(to) - distance(from);
        }
        self.now = now;
    }

    /// Time since the watchdog began to brake, s.
    fn braking_time(&self, at: Instant) -> f64 {
        at.saturating_duration_since(self.brakes_at).as_secs_f64()
    }

    /// Gives the arm the command of an answer to a state that was measured at `measured`.
    pub fn apply(&mut self, answer: &wire::StepAnswer, measured: Instant) {
        self.advance();
        // A state may contain numbers up to 1e9. After a wild wrench the solver `closed_form`, which ignores limits, can
        // command more: it moves the joints far away, and a posture task demands them back.
        self.command = answer.joint_velocity.iter().map(|velocity| velocity.clamp(-1e9, 1e9)).collect();
        self.deceleration = match answer.stop_time_s {
            Some(time) => self.command.iter().map(|velocity| velocity.abs() / time).collect(),
            None => answer.braking_deceleration.iter().map(|a| a.unwrap_or(f64::INFINITY)).collect(),
        };
        self.brakes_at = measured + std::time::Duration::from_millis(answer.valid_for_ms);
        // A command that is too old is the velocity of its ramp at once.
        self.now = Instant::now();
    }

    pub fn position(&self) -> Vec<f64> {
        self.position.clone()
    }

    /// Returns the joint velocity, rad/s or m/s.
    pub fn velocity(&self) -> Vec<f64> {
        let time = self.braking_time(self.now);
        let speed = |v: f64, a: f64| if time > 0.0 { (v.abs() - a * time).max(0.0) * v.signum() } else { v };
        self.command.iter().zip(&self.deceleration).map(|(&v, &a)| speed(v, a)).collect()
    }

    pub fn is_at_rest(&self) -> bool {
        self.velocity().iter().all(|&v| v == 0.0)
    }

    /// Returns the first joint outside its range, if there is one.
    pub fn outside(&self) -> Option<String> {
        let joints = self.robot.joints().iter().zip(&self.position);
        let is_outside = |joint: &revprio_robot::Joint, q: f64| {
            q < joint.limits.lower - TOLERANCE || q > joint.limits.upper + TOLERANCE
        };
        let found = joints.into_iter().find(|(joint, q)| is_outside(joint, **q));
        found.map(|(joint, q)| format!("{} at {q}, range {} … {}", joint.name, joint.limits.lower, joint.limits.upper))
    }
}

/// Distance after `time` of braking from `v`, rad or m.
fn braking_distance(v: f64, a: f64, time: f64) -> f64 {
    if a.is_infinite() || time <= 0.0 {
        return 0.0;
    }
    let time = time.min(v.abs() / a);
    v * time - v.signum() * a * time * time / 2.0
}
