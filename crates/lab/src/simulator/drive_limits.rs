//! Drives that cut commands, each joint by itself: what an arm does to a command that does not know its limits.

use revprio_api::wire::Limits;
use revprio_robot::RobotModel;

/// Limits of all joints for one period.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveLimits {
    joints: Vec<JointLimits>,
    period_s: f64,
}

/// Limits of one joint, infinite where there is none; rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
struct JointLimits {
    position: [f64; 2],
    velocity: [f64; 2],
    acceleration: f64,
}

impl DriveLimits {
    /// What the controller is given as its limits.
    pub fn new(limits: &Limits, robot: &RobotModel, period_s: f64) -> Self {
        let joints = robot.joints().iter().enumerate().map(|(i, joint)| {
            let own = joint.limits;
            let mut cut = JointLimits::NONE;
            match limits {
                Limits::Robot(kind) => {
                    if kind.includes_velocity() {
                        cut.velocity = [-own.velocity, own.velocity];
                    }
                    if kind.includes_position() {
                        cut.position = [own.lower, own.upper];
                    }
                    if kind.includes_acceleration() {
                        cut.acceleration = own.acceleration;
                    }
                }
                Limits::Box { lower, upper } => {
                    let of = |bounds: &[f64], none| bounds.get(i).copied().unwrap_or(none);
                    cut.velocity = [of(lower, f64::NEG_INFINITY), of(upper, f64::INFINITY)];
                }
            }
            cut
        });
        Self { joints: joints.collect(), period_s }
    }

    /// Cuts a command at positions `position`, after the command `before`; n each.
    pub fn cut(&self, command: &mut [f64], position: &[f64], before: &[f64]) {
        for (i, (speed, limits)) in command.iter_mut().zip(&self.joints).enumerate() {
            *speed = limits.cut(*speed, position[i], before[i], self.period_s);
        }
    }
}

impl JointLimits {
    const NONE: Self = Self {
        position: [f64::NEG_INFINITY, f64::INFINITY],
        velocity: [f64::NEG_INFINITY, f64::INFINITY],
        acceleration: f64::INFINITY,
    };

    /// Acceleration first, position last: what counts most has the last word.
    fn cut(&self, speed: f64, position: f64, before: f64, period: f64) -> f64 {
        let change = self.acceleration * period;
        let [slowest, fastest] = self.velocity;
        let [lower, upper] = self.position.map(|end| ((end - position) / period).max(slowest).min(fastest));
        (speed.max(before - change).min(before + change)).max(slowest).min(fastest).max(lower).min(upper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_keeps_position_velocity_and_acceleration() {
        let limits = JointLimits { position: [-1.0, 1.0], velocity: [-2.0, 3.0], acceleration: 10.0 };
        let cut = |speed, position, before| limits.cut(speed, position, before, 0.01);
        assert_eq!(cut(2.95, 0.0, 2.9), 2.95);
        assert_eq!(cut(5.0, 0.0, 2.95), 3.0);
        assert_eq!(cut(-5.0, 0.0, -1.95), -2.0);
        assert!((cut(3.0, 0.0, 1.0) - 1.1).abs() < 1e-12);
        // 5 mm before the end there are 0.5 rad/s left, whatever the acceleration says; beyond it, the way back.
        assert!((cut(3.0, 0.995, 2.0) - 0.5).abs() < 1e-9);
        assert!((cut(3.0, 1.01, 0.0) + 1.0).abs() < 1e-9);
    }

    #[test]
    fn without_limits_nothing_is_cut() {
        assert_eq!(JointLimits::NONE.cut(1e6, 5.0, -1e6, 0.001), 1e6);
    }
}
