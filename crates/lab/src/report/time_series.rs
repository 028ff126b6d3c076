//! Curves and panels over the simulated time of a recording.

use super::figure::{Curve, Panel, TIME};
use crate::simulator::recording::{Recording, Sample};

/// Names of the base axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];
/// Millimetres per metre.
pub const MM: f64 = 1e3;

/// Returns time (s) and value of every sample that has the value.
#[must_use]
pub fn points(run: &Recording, value: impl Fn(&Sample) -> Option<f64>) -> Vec<(f64, f64)> {
    run.samples.iter().filter_map(|sample| Some((sample.time_s, value(sample)?))).collect()
}

/// Returns the time of the first sample and the end of the last period (s).
#[must_use]
pub fn span(run: &Recording) -> (f64, f64) {
    let time = |sample: Option<&Sample>| sample.map_or(0.0, |sample| sample.time_s);
    (time(run.samples.first()), time(run.samples.last()) + run.period_s)
}

/// Largest value that counts as zero, in the unit of the panel: rounding errors of the solver are smaller.
const ZERO: f64 = 1e-9;

/// Returns whether all values of the curves are zero or not finite.
#[must_use]
pub fn is_zero(curves: &[Curve]) -> bool {
    curves.iter().flat_map(|curve| &curve.points).all(|(_, value)| !value.is_finite() || value.abs() < ZERO)
}

/// Returns a panel over a window of time (s).
#[must_use]
pub fn panel(heading: &str, y_label: &str, window: (f64, f64), curves: Vec<Curve>) -> Panel {
    Panel {
        heading: heading.to_owned(),
        x_label: TIME.to_owned(),
        y_label: y_label.to_owned(),
        window,
        y_covers: Vec::new(),
        curves,
    }
}
