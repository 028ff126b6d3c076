//! A reading that does not change although the tool moves: the sensor sticks, or is saturated.

use super::settings::ContactSettings;

/// Change of the force that ends a stretch of equal readings, in units of σ. Noise of the stated size stays within it in no run.
const SAME: f64 = 0.01;

/// Time and way, s and m, after which equal readings away from the target come from no surface: one of the softest kind changes its force
/// by 0.3 N on it.
const AWAY: (f64, f64) = (0.1, 1e-3);

/// The same near the target, where a surface may move along with the tool: then only noise tells the sensor from one that sticks.
const NEAR: (f64, f64) = (1.0, 1e-2);

/// The stretch of periods with the same reading.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Unchanged {
    /// The reading, N.
    pub force: f64,
    /// Position of the tool at its beginning, m.
    pub position: f64,
    /// Its length, s.
    pub time: f64,
}

impl Unchanged {
    /// Adds a reading (N) at a position (m) after a time (s).
    pub(super) fn add(&mut self, settings: &ContactSettings, (force, position): (f64, f64), time: f64) {
        if (force - self.force).abs() > SAME * settings.noise {
            *self = Self { force, position, time: 0.0 };
        } else {
            self.time += time;
        }
    }

    /// Returns whether no surface gives such a reading, at a position of the tool (m); `is_near`: the force is near its target.
    pub(super) fn is_stuck(&self, settings: &ContactSettings, position: f64, is_near: bool) -> bool {
        let (time, way) = if is_near { NEAR } else { AWAY };
        self.time > time && (position - self.position).abs() > way * settings.metre
    }
}
