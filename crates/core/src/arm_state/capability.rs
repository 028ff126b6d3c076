//! What the joints can give.

use super::motion::JointBraking;

/// Part of the reaction time before a plane per time a_j/J_j, in which a joint reaches its deceleration: from full acceleration to
/// full deceleration.
const RISES_BEFORE_PLANE: f64 = 2.0;

/// The speed, the deceleration and the jerk of each joint that the limits of a controller permit.
#[derive(Debug)]
pub(crate) struct JointCapability {
    /// V_j, n, rad/s or m/s; infinite without a limit.
    pub speed: Vec<f64>,
    /// a_j, n, rad/s² or m/s²; infinite without a limit.
    pub deceleration: Vec<f64>,
    /// J_j, n, rad/s³ or m/s³; infinite without a limit.
    pub jerk: Vec<f64>,
    /// τ, the time for which an arm moves on before it brakes, s.
    pub reaction: f64,
    /// The same before a plane, s.
    plane_reaction: f64,
}

impl JointCapability {
    /// Builds the capability from V_j, a_j and J_j, n each, and τ, s.
    pub fn new(speed: Vec<f64>, deceleration: Vec<f64>, jerk: Vec<f64>, reaction: f64) -> Self {
        let plane_reaction = reaction + RISES_BEFORE_PLANE * longest_rise(&deceleration, &jerk);
        Self { speed, deceleration, jerk, reaction, plane_reaction }
    }

    /// Returns whether all joints have a known speed and a known deceleration.
    pub fn is_known(&self) -> bool {
        self.speed.iter().chain(&self.deceleration).all(|limit| limit.is_finite())
    }

    /// Returns how the joints brake before planes.
    pub fn before_planes(&self) -> JointBraking<'_> {
        JointBraking { deceleration: &self.deceleration, reaction_s: self.plane_reaction }
    }
}

/// Returns the largest a_j/J_j of joints with a jerk limit, s.
fn longest_rise(deceleration: &[f64], jerk: &[f64]) -> f64 {
    let rises = deceleration.iter().zip(jerk).map(|(a, jerk)| a / jerk);
    rises.filter(|rise| rise.is_finite()).fold(0.0, f64::max)
}
