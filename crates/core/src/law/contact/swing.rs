//! The swing guard: a contact whose swings do not decay gets a stiffer model, which is more damping.

use super::settings::ContactSettings;
use super::timing::ContactTiming;

/// Smallest swing in units of σ, and as a share of F_d.
const SMALLEST: (f64, f64) = (6.0, 0.05);

/// Share of the swing before that a swing must exceed.
const KEPT: f64 = 0.8;

/// Factor by which the swing factor grows, and its largest value.
const GROWTH: (f64, f64) = (1.6, 16.0);

/// How F swings about F_d.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swing {
    /// s ≥ 1, factor of K̂.
    pub factor: f64,
    /// Largest |F − F_d| since F crossed F_d, N.
    pub amplitude: f64,
    /// The same before that, N.
    pub before: f64,
    /// Whether F is above F_d.
    pub above: bool,
}

impl Swing {
    /// No swing.
    pub const NONE: Self = Self { factor: 1.0, amplitude: 0.0, before: 0.0, above: false };

    /// Updates the swing by F − F_d and F_d, N.
    pub(super) fn update(
        &mut self,
        (settings, timing): (&ContactSettings, &ContactTiming),
        difference: f64,
        target: f64,
    ) {
        let above = difference > 0.0;
        if above != self.above {
            let least = (SMALLEST.0 * settings.noise).max(SMALLEST.1 * target);
            let both = self.amplitude.min(self.before) > SMALLEST.0 * settings.noise && self.amplitude > least;
            if both && self.amplitude > KEPT * self.before {
                self.factor = (GROWTH.0 * self.factor).min(GROWTH.1);
            }
            (self.before, self.amplitude, self.above) = (self.amplitude, 0.0, above);
        }
        self.amplitude = self.amplitude.max(difference.abs());
        self.factor = 1.0 + (self.factor - 1.0) * (-timing.period / timing.swing_decay).exp();
    }
}
