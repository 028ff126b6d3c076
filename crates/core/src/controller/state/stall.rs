//! Joints that are commanded and do not move: a brake holds them, the arm ignores commands, or something is in the way.
//!
//! c is the distance that a joint moves behind the modelled drive, and m the distance that is measured. While m along c is
//! below c/10 plus 1 mrad (mm), both count on. Otherwise the joint follows, and both begin again from 0. They also begin
//! again while the modelled speed is below 0.05 rad/s (m/s) and where it changes its sign: noise, friction and the remaining
//! error of an arm at rest do not count.
//!
//! A joint stalls when they have counted on for t = 0.5 s + L + D T, where L + D T is the time of its drive. From then on c and m
//! are those of about the last t, so that the joint need not move far to follow again.

/// Modelled speed below which a joint need not move, rad/s or m/s: friction may hold a joint that is asked for less.
const MIN_SPEED: f64 = 0.05;

/// Share of the commanded distance that a joint which follows moves at least. A joint behind a slower drive than stated still moves
/// more.
const MIN_SHARE: f64 = 0.1;

/// Measured distance that noise may explain, rad or m: twice the noise that the position limits allow for.
const NOISE_DISTANCE: f64 = 1e-3;

/// How far a joint was commanded and has moved since it last followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stall {
    /// c, distance behind the modelled drive, rad or m.
    pub commanded: f64,
    /// m, measured distance, rad or m.
    pub moved: f64,
    /// Time of both, s: since the joint last followed, and at most that after which it stalls.
    pub time_s: f64,
}

/// A joint that does not follow its commands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StalledJoint {
    /// Index of the joint, from 0.
    pub joint: usize,
    /// What it does in place of its commands.
    pub stall: Stall,
}

impl Stall {
    /// A joint that follows, or has nothing to follow.
    pub const NONE: Self = Self { commanded: 0.0, moved: 0.0, time_s: 0.0 };

    /// Returns whether the numbers are finite and the time is not negative.
    pub(in crate::controller) fn is_valid(&self) -> bool {
        self.commanded.is_finite() && self.moved.is_finite() && self.time_s.is_finite() && self.time_s >= 0.0
    }

    /// Updates to a period (T, s) in which the joint moved by `moved` at the modelled speed `speed`; `window`: t, s. Returns
    /// whether the joint stalls.
    pub(in crate::controller) fn update(&mut self, speed: f64, moved: f64, period: f64, window: f64) -> bool {
        if speed * self.commanded < 0.0 {
            *self = Self::NONE;
        }
        self.commanded += speed * period;
        self.moved += moved;
        self.time_s += period;
        let follows = self.moved * speed.signum() > MIN_SHARE * self.commanded.abs() + NOISE_DISTANCE;
        if follows || speed.abs() < MIN_SPEED {
            *self = Self::NONE;
        }
        let stalls = self.time_s >= window;
        if stalls {
            let kept = window / self.time_s;
            *self = Self { commanded: kept * self.commanded, moved: kept * self.moved, time_s: window };
        }
        stalls
    }
}
