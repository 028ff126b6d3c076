//! A reading that does not change although the tool moves: the sensor sticks, or is saturated.

use super::settings::ContactSettings;

/// Change of the force that ends a stretch of equal readings, in units of σ. Noise of the stated size stays within it in no run.
const SAME: f64 = 0.01;

/// Time and way, s and m, after which equal readings away from the target come from no surface: one of the softest kind changes its force
/// by 0.3 N on it.
const AWAY: (f64, f64) = (0.1, 1e-3);

/// The same near the target, where a surface may move along with the tool: then only noise tells the sensor from one that sticks.
const NEAR: (f64, f64) = (1.0, 1e-2);

/// Rms change of a reading that shows noise, in units of σ: such a reading never stays the same.
const NOISY: f64 = 0.2;

/// Steps of the reading on the softest surface, within which it may stay the same.
const STEPS: f64 = 2.0;

/// Share of a new change in that mean, and the periods without a change that count.
const MEMORY: (f64, f64) = (0.3, 3.0);

/// The stretch of periods with the same reading.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Unchanged {
    /// The reading, N.
    pub force: f64,
    /// Position of the tool at its beginning, m.
    pub position: f64,
    /// Its length, s.
    pub time: f64,
    /// Rms change of the readings before it, N.
    pub change: f64,
    /// The smallest change of the reading so far, N: its resolution, or less than the noise; 0: there was none.
    pub step: f64,
}

impl Unchanged {
    /// No readings yet.
    pub(super) const START: Self = Self { force: 0.0, position: 0.0, time: 0.0, change: 0.0, step: 0.0 };

    /// Adds a reading (N) at a position (m) after a time (s).
    pub(super) fn add(&mut self, settings: &ContactSettings, (force, position): (f64, f64), time: f64) {
        let change = force - self.force;
        let is_same = change.abs() <= SAME * settings.noise;
        if !is_same || self.time < MEMORY.1 * time {
            self.change = ((1.0 - MEMORY.0).sqrt() * self.change).hypot(MEMORY.0.sqrt() * change);
        }
        if is_same {
            self.time += time;
        } else {
            let step = if self.step > 0.0 { self.step.min(change.abs()) } else { change.abs() };
            *self = Self { force, position, time: 0.0, change: self.change, step };
        }
    }

    /// Returns whether no surface gives such a reading, at a position of the tool (m). `is_near`: the force is near its target; `near`: how
    /// much of it that is, N; `stiffness`: the best known one, N/m.
    pub(super) fn is_stuck(
        &self,
        settings: &ContactSettings,
        position: f64,
        (is_near, near): (bool, f64),
        stiffness: f64,
    ) -> bool {
        let (time, way) = if is_near { NEAR } else { AWAY };
        let moved = (position - self.position).abs();
        // A coarse reading stays the same while the tool sinks into something soft, and shows no noise.
        let way = (way * settings.metre).max(STEPS * self.step / settings.softest);
        let noise = NOISY * settings.noise;
        let is_noisy = self.change > noise && self.step < noise;
        self.time > time && moved > way || is_noisy && self.time > AWAY.0 && stiffness * moved > near
    }
}
