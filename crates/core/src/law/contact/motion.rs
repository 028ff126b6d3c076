//! The velocity of a surface that moves.
//!
//! The surface is at w = x_s − F/K_l, whatever the tool does, if K_l is its stiffness. Its filtered velocity v̂ = (w − w̄)/τ_s, with
//! the mean w̄ ← w̄ + (T/τ_s) (w − w̄), is fed forward. An error of K_l feeds the share |1 − K/K_l| of the tool's own velocity back; τ_s
//! is so long that this adds less than |1 − K/K_l| τ_c/τ_s to the ratio that the claim bounds.

use super::settings::ContactSettings;
use super::timing::ContactTiming;

/// Velocity that is no motion, m/s: swings of a contact on a drive that yields look like it.
const REST: f64 = 5e-4;

/// Uncertainties of v̂ by which the velocity that is fed forward is smaller.
const SIGMAS: f64 = 3.0;

/// How a surface moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceMotion {
    /// w̄, mean place of the surface, m.
    pub mean: f64,
    /// K_l of that mean, N/m; 0: the surface was not seen yet.
    pub slope: f64,
    /// The velocity that is fed forward, m/s.
    pub velocity: f64,
}

impl SurfaceMotion {
    /// Updates the velocity by x_s (m), F (N) and K_l (N/m; 0: unknown).
    pub(super) fn update(
        &mut self,
        (settings, timing): (&ContactSettings, &ContactTiming),
        (position, force): (f64, f64),
        slope: f64,
    ) {
        if slope <= 0.0 {
            return;
        }
        let place = position - force / slope;
        if self.slope <= 0.0 {
            self.mean = place;
        } else {
            // Another stiffness moves the place, not the surface.
            self.mean += force / self.slope - force / slope;
        }
        self.slope = slope;
        let velocity = (place - self.mean) / timing.surface;
        self.mean += timing.period * velocity;
        let noise = settings.noise / slope / timing.surface * (0.5 * timing.period / timing.surface).sqrt();
        let correlation = (1.0 + 2.0 * timing.sensor_lag / timing.period).sqrt();
        let sure = (velocity.abs() - (SIGMAS * noise * correlation).max(REST * settings.metre)).max(0.0);
        self.velocity = sure.min(settings.followed_speed).copysign(velocity);
    }
}
