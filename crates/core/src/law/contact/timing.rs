//! The times of the contact law, which follow from period, drive and sensor.

use crate::limits::Drive;

/// τ_c over the reaction time.
const CONTACT_REACTIONS: f64 = 1.2;

/// Smallest time constant of the contact, s.
const MIN_CONTACT_TIME: f64 = 0.03;

/// τ_r over the reaction time.
const STOP_REACTIONS: f64 = 0.25;

/// Smallest window of the estimator, s, and the window over the reaction time.
const WINDOW: (f64, f64) = (0.05, 3.0);

/// Smallest time in which K̂ falls by the factor e, s.
const MIN_FALL_TIME: f64 = 0.03;

/// τ_s over τ_c.
const SURFACE_REACTIONS: f64 = 8.0;

/// τ_t over the reaction time and over the period.
const TRACKING: (f64, f64) = (0.5, 2.0);

/// Smallest time in which the swing factor decays, s, and that time over the reaction time.
const SWING_DECAY: (f64, f64) = (0.3, 10.0);

/// The times of the contact law, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactTiming {
    /// T, period.
    pub period: f64,
    /// L, lag of the drive.
    pub lag: f64,
    /// (D + 1) T and the time in which the joints change their acceleration.
    pub dead_time: f64,
    /// τ_f, time constant of the force sensor.
    pub sensor_lag: f64,
    /// τ_d = L + (D + 1) T + τ_f and the time in which the joints change their acceleration, reaction time.
    pub reaction: f64,
    /// τ_c, time constant of the contact.
    pub contact: f64,
    /// τ_r, time constant of the emergency stop.
    pub stop: f64,
    /// τ_h, window of the estimator.
    pub window: f64,
    /// τ_k, time in which K̂ falls by the factor e at the fastest.
    pub fall: f64,
    /// τ_s, time constant of the velocity of the surface.
    pub surface: f64,
    /// τ_t, time constant with which position and force are followed while the contact is held.
    pub tracking: f64,
    /// L + D T + τ_f, by which a tool that moves steadily is ahead of the force sensor.
    pub following: f64,
    /// Time in which the swing factor decays by the factor e.
    pub swing_decay: f64,
}

impl ContactTiming {
    /// Returns the times for a period T (s), a drive and a sensor with the time constant τ_f (s). `rise`: time in which the
    /// joints change their acceleration, s.
    pub fn new(period: f64, drive: Drive, sensor_lag: f64, rise: f64) -> Self {
        let dead_time = (drive.delay_periods + 1) as f64 * period + rise;
        let reaction = drive.lag_s + dead_time + sensor_lag;
        Self {
            period,
            lag: drive.lag_s,
            dead_time,
            sensor_lag,
            reaction,
            contact: (CONTACT_REACTIONS * reaction).max(MIN_CONTACT_TIME),
            stop: (STOP_REACTIONS * reaction).max(period),
            window: (WINDOW.1 * reaction).max(WINDOW.0),
            fall: reaction.max(MIN_FALL_TIME),
            surface: SURFACE_REACTIONS * (CONTACT_REACTIONS * reaction).max(MIN_CONTACT_TIME),
            tracking: (TRACKING.0 * reaction).max(TRACKING.1 * period),
            following: drive.lag_s + drive.delay_periods as f64 * period + sensor_lag,
            swing_decay: (SWING_DECAY.1 * reaction).max(SWING_DECAY.0),
        }
    }
}
