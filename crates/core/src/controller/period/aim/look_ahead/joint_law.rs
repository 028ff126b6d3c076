//! How one joint follows the virtual one.

use super::plan::{INTERVALS, Plan};
use crate::controller::state::TIMES_AHEAD;
use crate::law::{braking_factor, linear_share};

/// Largest gain near the virtual joint, 1/s. At this gain a joint that brakes fully has 2 mrad left, and 0.1 mrad of noise are a speed of
/// 4 mrad/s.
const GAIN: f64 = 40.0;

/// Largest product of the gain and the period. Loops below 2/3 come to rest behind every drive.
const GAIN_PERIODS: f64 = 0.5;

/// Share of the acceleration limit up to which the virtual joint is followed by feedback alone.
const FOLLOWED: f64 = 0.9;

/// Part of the reaction time per time a/J in which a joint with a jerk limit changes its acceleration.
const DELAY_PER_CHANGE: f64 = 1.5;

/// What a joint can give.
#[derive(Debug, Clone, Copy)]
pub(super) struct Capability {
    /// V, rad/s or m/s.
    pub speed: f64,
    /// A, rad/s² or m/s².
    pub acceleration: f64,
    /// J, rad/s³ or m/s³.
    pub jerk: f64,
}

/// One joint before a command.
#[derive(Debug, Clone, Copy)]
pub(super) struct Joint {
    /// p, position of rest, rad or m.
    pub position: f64,
    /// u⁻, last command, rad/s or m/s.
    pub last_command: f64,
    pub can: Capability,
}

impl Joint {
    /// Returns the velocity that follows a virtual joint; `ahead`: its positions at [`TIMES_AHEAD`]; `period`: T, s.
    pub fn velocity(&self, ahead: &[f64; TIMES_AHEAD.len()], plan: &Plan, known: bool, period: f64) -> f64 {
        let Capability { speed, acceleration, .. } = self.can;
        let needed = if known { largest_acceleration(ahead) } else { acceleration_now(ahead).min(0.85 * acceleration) };
        let wanted = if needed < FOLLOWED * acceleration {
            let feedback = self.feedback(ahead[0] - self.position, acceleration - needed, period);
            velocity_now(ahead, 0.5 * period) + feedback
        } else {
            let mut relative = [0.0; INTERVALS];
            for (k, entry) in relative.iter_mut().enumerate() {
                *entry = ahead[k + 1] - self.position - self.last_command * TIMES_AHEAD[k + 1];
            }
            self.last_command + period * plan.first_acceleration(&relative, self.last_command, [acceleration, speed])
        };
        let change = acceleration * period;
        let reachable = wanted.clamp(self.last_command - change, self.last_command + change);
        reachable.clamp(-speed, speed)
    }

    /// Returns the velocity towards a position at this distance from which the joint stops there with the deceleration `room`.
    fn feedback(&self, distance: f64, room: f64, period: f64) -> f64 {
        let gain = GAIN.min(GAIN_PERIODS / period);
        let bare = gain * distance;
        if bare == 0.0 {
            return 0.0;
        }
        let delay = if self.can.jerk.is_finite() { DELAY_PER_CHANGE * room / self.can.jerk } else { 0.0 };
        let linear = linear_share(gain, 0.5 * period + delay);
        bare * braking_factor(room / (gain * bare.abs()), linear)
    }
}

/// Returns the largest acceleration of a virtual joint, from second differences.
fn largest_acceleration(ahead: &[f64; TIMES_AHEAD.len()]) -> f64 {
    let slope = |k: usize| (ahead[k + 1] - ahead[k]) / (TIMES_AHEAD[k + 1] - TIMES_AHEAD[k]);
    let second = |k: usize| (slope(k) - slope(k - 1)) / (0.5 * (TIMES_AHEAD[k + 1] - TIMES_AHEAD[k - 1]));
    (1..TIMES_AHEAD.len() - 1).map(|k| second(k).abs()).fold(0.0, f64::max)
}

/// Returns the acceleration of a virtual joint on the parabola through its first three positions.
fn acceleration_now(ahead: &[f64; TIMES_AHEAD.len()]) -> f64 {
    let [_, first, second, ..] = TIMES_AHEAD;
    let slopes = [(ahead[1] - ahead[0]) / first, (ahead[2] - ahead[1]) / (second - first)];
    (2.0 * (slopes[1] - slopes[0]) / second).abs()
}

/// Returns the velocity of a virtual joint at a time near 0 on the parabola through its first three positions.
fn velocity_now(ahead: &[f64; TIMES_AHEAD.len()], time: f64) -> f64 {
    let [_, first, second, ..] = TIMES_AHEAD;
    let slopes = [(ahead[1] - ahead[0]) / first, (ahead[2] - ahead[1]) / (second - first)];
    let half_acceleration = (slopes[1] - slopes[0]) / second;
    slopes[0] + half_acceleration * (2.0 * time - first)
}
