//! An axis of a figure: its range, and ticks at round numbers.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;

use super::number;

/// Approximate number of intervals between ticks.
const INTERVALS: f64 = 6.0;
/// Distance of the curves from the frame, as a fraction of their extent.
const MARGIN: f64 = 0.06;
/// Largest number of decimals in a label; longer labels would overlap the name of the axis.
const MAX_DECIMALS: usize = 4;
/// An extent below this is rounding noise in any unit drawn here (N, mm, s) and is not magnified.
const MIN_EXTENT: f64 = 1e-9;

/// A linear axis from `low` to `high` with a tick at every multiple of `step`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    /// Returns an axis without margins.
    #[must_use]
    pub fn exactly((low, high): (f64, f64)) -> Self {
        let (low, high) = if high - low < MIN_EXTENT { (low - 1.0, high + 1.0) } else { (low, high) };
        Self { low, high, step: round_step((high - low) / INTERVALS) }
    }

    /// Returns an axis with a margin on both sides.
    #[must_use]
    pub fn around((low, high): (f64, f64)) -> Self {
        let margin = MARGIN * (high - low);
        Self::exactly((low - margin, high + margin))
    }

    /// Returns the ticks inside the axis, ascending.
    #[must_use]
    pub fn ticks(&self) -> Vec<f64> {
        // Because of rounding, an end may not be an exact multiple of the step. It still gets a tick.
        let slack = 1e-6;
        let first = (self.low / self.step - slack).ceil();
        let last = self.high / self.step + slack;
        std::iter::successors(Some(first), |k| Some(k + 1.0))
            .take_while(|k| *k <= last)
            .map(|k| k * self.step)
            .collect()
    }

    /// Returns the label of a tick, with as many decimals as the step needs, or as a multiple of a power of ten. The minus
    /// sign is U+2212.
    #[must_use]
    pub fn label(&self, tick: f64) -> String {
        let exponent = number::exponent(self.step, 0);
        let decimals = usize::try_from(-exponent).unwrap_or(0);
        let power = 10_f64.powi(exponent);
        // Adding zero turns a negative zero into a positive one.
        let multiple = (tick / power).round() + 0.0;
        let text = match multiple {
            0.0 if decimals > MAX_DECIMALS => "0".to_owned(),
            _ if decimals > MAX_DECIMALS => format!("{multiple}e{exponent}"),
            _ => format!("{:.decimals$}", multiple * power),
        };
        text.replace('-', "−")
    }
}

/// Returns the smallest of 1, 2 and 5 times a power of ten that is not below `raw`.
fn round_step(raw: f64) -> f64 {
    let power = 10_f64.powi(number::exponent(raw, 17));
    let steps = [1.0, 2.0, 5.0].map(|digit| digit * power);
    steps.into_iter().find(|step| *step >= raw).unwrap_or(10.0 * power)
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        RangedCoordf64::from(self.low..self.high).map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        self.label(*value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|tick| axis.label(tick)).collect()
    }

    #[test]
    fn ticks_are_round_and_reach_both_ends() {
        assert_eq!(labels(Axis::exactly((0.0, 20.0))), ["0", "5", "10", "15", "20"]);
        assert_eq!(labels(Axis::exactly((0.0, 0.6))), ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6"]);
    }

    #[test]
    fn labels_have_the_decimals_of_the_step_and_no_negative_zero() {
        assert_eq!(labels(Axis::exactly((-0.3, 0.25))), ["−0.3", "−0.2", "−0.1", "0.0", "0.1", "0.2"]);
        assert_eq!(labels(Axis::exactly((0.0, 4e-6))), ["0", "1e−6", "2e−6", "3e−6", "4e−6"]);
    }

    #[test]
    fn adjacent_small_ticks_have_different_labels() {
        let axis = Axis::exactly((-1.5e-6, 0.0));
        assert_eq!(labels(axis), ["−15e−7", "−10e−7", "−5e−7", "0"]);
    }

    #[test]
    fn rounding_noise_is_not_magnified() {
        assert_eq!(labels(Axis::around((0.0, 1e-15))), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
    }

    #[test]
    fn axis_around_an_extent_has_a_margin() {
        let range = Axis::around((0.0, 100.0)).range();
        assert!(range.start < -5.0 && range.end > 105.0);
    }
}
