//! Drives that clamp the command of each joint at its limits, independent of the tasks.

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
    /// Returns the limits of the controller as limits of the drives.
    pub fn new(limits: &Limits, robot: &RobotModel, period_s: f64) -> Self {
        let joints = robot.joints().iter().enumerate().map(|(i, joint)| {
            let own = joint.limits;
            let mut clamped = JointLimits::NONE;
            match limits {
                Limits::Robot(kind) => {
                    if kind.includes_velocity() {
                        clamped.velocity = [-own.velocity, own.velocity];
                    }
                    if kind.includes_position() {
                        clamped.position = [own.lower, own.upper];
                    }
                    if kind.includes_acceleration() {
                        clamped.acceleration = own.acceleration;
                    }
                }
                Limits::Box { lower, upper } => {
                    let of = |bounds: &[f64], none| bounds.get(i).copied().unwrap_or(none);
                    clamped.velocity = [of(lower, f64::NEG_INFINITY), of(upper, f64::INFINITY)];
                }
            }
            clamped
        });
        Self { joints: joints.collect(), period_s }
    }

    /// Clamps a command at the positions `position`, after the command `before`; n each.
    pub fn clamp(&self, command: &mut [f64], position: &[f64], before: &[f64]) {
        for (i, (speed, limits)) in command.iter_mut().zip(&self.joints).enumerate() {
            *speed = limits.clamp(*speed, position[i], before[i], self.period_s);
        }
    }
}

impl JointLimits {
    const NONE: Self = Self {
        position: [f64::NEG_INFINITY, f64::INFINITY],
        velocity: [f64::NEG_INFINITY, f64::INFINITY],
        acceleration: f64::INFINITY,
    };

    /// Clamps acceleration first and position last, because the last limit takes precedence.
    fn clamp(&self, speed: f64, position: f64, before: f64, period: f64) -> f64 {
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
    fn drives_keep_position_velocity_and_acceleration_limits() {
        let limits = JointLimits { position: [-1.0, 1.0], velocity: [-2.0, 3.0], acceleration: 10.0 };
        let clamp = |speed, position, before| limits.clamp(speed, position, before, 0.01);
        assert_eq!(clamp(2.95, 0.0, 2.9), 2.95);
        assert_eq!(clamp(5.0, 0.0, 2.95), 3.0);
        assert_eq!(clamp(-5.0, 0.0, -1.95), -2.0);
        assert!((clamp(3.0, 0.0, 1.0) - 1.1).abs() < 1e-12);
        // 5 mrad before the end, 0.5 rad/s are allowed, independent of the acceleration. Beyond the end, the joint returns.
        assert!((clamp(3.0, 0.995, 2.0) - 0.5).abs() < 1e-9);
        assert!((clamp(3.0, 1.01, 0.0) + 1.0).abs() < 1e-9);
    }

    #[test]
    fn commands_without_limits_are_not_changed() {
        assert_eq!(JointLimits::NONE.clamp(1e6, 5.0, -1e6, 0.001), 1e6);
    }
}
