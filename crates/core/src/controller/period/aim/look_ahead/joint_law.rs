//! How one joint follows the virtual one.

use super::plan::{INTERVALS, Plan};
use crate::controller::state::TIMES_AHEAD;
use crate::law::{braking_factor, linear_share};

/// Largest gain near the virtual joint, 1/s. A joint that brakes fully has 1 mrad left there, and 0.1 mrad of noise are a speed of 6
/// mrad/s.
const GAIN: f64 = 60.0;

/// The same towards a motion that is predicted from targets with noise.
const PREDICTED_GAIN: f64 = 20.0;

/// Largest product of the gain and the period. Loops below 2/3 come to rest behind every drive.
const GAIN_PERIODS: f64 = 0.5;

/// Share of the acceleration limit up to which the virtual joint is followed by feedback alone.
const FOLLOWED: f64 = 0.9;

/// Largest share of the acceleration limit that is kept for a motion which is only predicted.
const PREDICTED: f64 = 0.85;

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
    /// T, s.
    pub period: f64,
}

impl Joint {
    /// Returns the velocity to a virtual joint that rests; `share`: of the speed limit, and by its square of the acceleration limit.
    pub fn arriving(&self, target: f64, share: f64) -> f64 {
        let speed = self.can.speed * share;
        let feedback = self.feedback(target - self.position, self.can.acceleration * share * share, GAIN);
        self.reachable(feedback.clamp(-speed, speed))
    }

    /// Returns the velocity that follows a virtual joint whose positions at [`TIMES_AHEAD`] are known.
    pub fn following(&self, ahead: &[f64; TIMES_AHEAD.len()], plan: &Plan) -> f64 {
        let Capability { speed, acceleration, .. } = self.can;
        let needed = largest_acceleration(ahead);
        if needed < FOLLOWED * acceleration && largest_speed(ahead) < speed {
            return self.tracking(ahead[0], velocity_now(ahead, 0.5 * self.period), acceleration - needed);
        }
        let relative: [f64; INTERVALS] =
            std::array::from_fn(|k| ahead[k + 1] - self.position - self.last_command * TIMES_AHEAD[k + 1]);
        let first = plan.first_acceleration(&relative, self.last_command, [acceleration, speed]);
        self.reachable(self.last_command + self.period * first)
    }

    /// Returns the velocity that follows a virtual joint whose positions at [`TIMES_AHEAD`] are predicted: only the first ones count.
    pub fn predicting(&self, ahead: &[f64; TIMES_AHEAD.len()]) -> f64 {
        let acceleration = self.can.acceleration;
        let needed = acceleration_now(ahead).abs().min(PREDICTED * acceleration);
        let feedback = self.feedback(ahead[0] - self.position, acceleration - needed, PREDICTED_GAIN);
        self.reachable(velocity_now(ahead, 0.5 * self.period) + feedback)
    }

    /// Returns the velocity that follows a virtual joint at a position with a velocity; `room`: the deceleration left for the feedback.
    pub fn tracking(&self, position: f64, velocity: f64, room: f64) -> f64 {
        self.reachable(velocity + self.feedback(position - self.position, room, GAIN))
    }

    /// Returns the velocity towards a position at this distance from which the joint stops there with the deceleration `room`;
    /// `gain`: the largest one near it, 1/s.
    fn feedback(&self, distance: f64, room: f64, gain: f64) -> f64 {
        let gain = gain.min(GAIN_PERIODS / self.period);
        let bare = gain * distance;
        if bare == 0.0 {
            return 0.0;
        }
        let delay = if self.can.jerk.is_finite() { DELAY_PER_CHANGE * room / self.can.jerk } else { 0.0 };
        let linear = linear_share(gain, 0.5 * self.period + delay);
        bare * braking_factor(room / (gain * bare.abs()), linear)
    }

    /// Returns the velocity nearest to a wanted one that the limits of acceleration and velocity permit.
    fn reachable(&self, wanted: f64) -> f64 {
        let Capability { speed, acceleration, .. } = self.can;
        let change = acceleration * self.period;
        wanted.clamp(self.last_command - change, self.last_command + change).clamp(-speed, speed)
    }
}

/// Returns the velocity of a virtual joint from one time to the next.
fn slope(ahead: &[f64; TIMES_AHEAD.len()], k: usize) -> f64 {
    (ahead[k + 1] - ahead[k]) / (TIMES_AHEAD[k + 1] - TIMES_AHEAD[k])
}

/// Returns the largest speed of a virtual joint.
fn largest_speed(ahead: &[f64; TIMES_AHEAD.len()]) -> f64 {
    (0..INTERVALS).map(|k| slope(ahead, k).abs()).fold(0.0, f64::max)
}

/// Returns the largest acceleration of a virtual joint, from second differences.
fn largest_acceleration(ahead: &[f64; TIMES_AHEAD.len()]) -> f64 {
    let second = |k: usize| (slope(ahead, k) - slope(ahead, k - 1)) / (0.5 * (TIMES_AHEAD[k + 1] - TIMES_AHEAD[k - 1]));
    (1..TIMES_AHEAD.len() - 1).map(|k| second(k).abs()).fold(0.0, f64::max)
}

/// Returns the acceleration of a virtual joint on the parabola through its first three positions.
pub(super) fn acceleration_now(ahead: &[f64; TIMES_AHEAD.len()]) -> f64 {
    2.0 * (slope(ahead, 1) - slope(ahead, 0)) / TIMES_AHEAD[2]
}

/// Returns the velocity of a virtual joint on this parabola at a time near 0.
fn velocity_now(ahead: &[f64; TIMES_AHEAD.len()], time: f64) -> f64 {
    slope(ahead, 0) + acceleration_now(ahead) * (time - 0.5 * TIMES_AHEAD[1])
}
