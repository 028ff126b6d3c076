//! The numbers of the results table, each computed from one [`Recording`].

use std::collections::BTreeMap;

use crate::simulator::recording::{Recording, Sample};
use crate::wire::Path;

/// A run longer than this (s) is judged on its steady part only.
pub const LONG_RUN_S: f64 = 10.0;
/// Where the steady part of a long run begins (s).
pub const STEADY_FROM_S: f64 = 5.0;
/// Half width of the settling band, as a fraction of the target.
pub const SETTLING_BAND: f64 = 0.05;
/// How long (s) a force has to stay inside the band to count as settled. A stiff contact rings at
/// some 80 rad/s; one whole period of that is 0.08 s, so a ringing force cannot pass by ending the
/// run as it crosses the band.
pub const SETTLED_FOR_S: f64 = 0.1;

/// By how much a force exceeded its target, in the direction of the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overshoot {
    /// Largest excess over the target of the same instant (N), at least 0.
    pub newton: f64,
    /// The same as a percentage of the target of that instant; infinite where that target is 0.
    pub percent: f64,
}

/// Measures of one run. The tool is *in contact* while its distance to the wall is not positive
/// or, without a wall, while a force is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Metrics {
    /// Root mean square of `F_x − F_d,x` (N) from [`evaluation_start`] on; `None` when x has no
    /// target or nothing was touched.
    pub rmse_fx: Option<f64>,
    /// The same for y (N).
    pub rmse_fy: Option<f64>,
    /// Overshoot of `F_x` from the first contact on; `None` without target or contact.
    pub overshoot: Option<Overshoot>,
    /// Simulated time (s) from which `F_x` stays within [`SETTLING_BAND`] of its target until the
    /// end, and for [`SETTLED_FOR_S`] at least; `None` when it does not settle.
    pub settling_time_s: Option<f64>,
    /// `F_x` of the last sample (N); `None` for an empty run.
    pub final_force: Option<f64>,
    /// Largest `F_x` (N), at least 0.
    pub peak_force: f64,
    /// Simulated time of the first contact (s).
    pub first_contact_s: Option<f64>,
    /// Number of separate intervals in contact.
    pub contacts: usize,
    /// Largest `|q̇_i|` of any joint (rad/s).
    pub max_joint_speed: f64,
    /// Control periods per second of real time; `None` when the run took no measurable time.
    pub calls_per_second: Option<f64>,
    /// How many periods each solve path served.
    pub paths: BTreeMap<Path, usize>,
}

impl Metrics {
    /// Measures a run.
    #[must_use]
    pub fn of(recording: &Recording) -> Self {
        let samples = &recording.samples;
        let touched = from_first_contact(samples);
        Self {
            rmse_fx: rmse(recording, 0),
            rmse_fy: rmse(recording, 1),
            overshoot: overshoot(touched),
            settling_time_s: settling_time(touched),
            final_force: samples.last().map(|s| s.force[0]),
            peak_force: samples.iter().map(|s| s.force[0]).fold(0.0, larger),
            first_contact_s: touched.first().map(|s| s.time_s),
            contacts: contacts(samples),
            max_joint_speed: max_joint_speed(samples),
            calls_per_second: calls_per_second(recording),
            paths: paths(samples),
        }
    }
}

/// Largest difference of two runs' commands, `max_i ‖q̇_a,i − q̇_b,i‖∞` (rad/s).
///
/// Infinite when the runs have a different number of samples or joints, or a command is not a
/// number: runs that cannot be compared must not look alike.
#[must_use]
pub fn largest_difference(a: &Recording, b: &Recording) -> f64 {
    if a.samples.len() != b.samples.len() {
        return f64::INFINITY;
    }
    a.samples
        .iter()
        .zip(&b.samples)
        .map(|(a, b)| command_difference(&a.joint_velocity, &b.joint_velocity))
        .fold(0.0, larger)
}

/// Start of the part that the RMSE judges (s): [`STEADY_FROM_S`] for a run longer than
/// [`LONG_RUN_S`], otherwise the first contact; `None` when a short run touches nothing.
#[must_use]
pub fn evaluation_start(recording: &Recording) -> Option<f64> {
    let (first, last) = (recording.samples.first()?, recording.samples.last()?);
    if last.time_s - first.time_s > LONG_RUN_S {
        return Some(STEADY_FROM_S);
    }
    from_first_contact(&recording.samples).first().map(|s| s.time_s)
}

/// `F − F_d` on one axis (N); `None` where the axis has no target.
#[must_use]
pub fn force_error(sample: &Sample, axis: usize) -> Option<f64> {
    sample.target_force[axis].map(|target| sample.force[axis] - target)
}

fn in_contact(sample: &Sample) -> bool {
    match sample.wall_distance {
        Some(distance) => distance <= 0.0,
        None => sample.force.iter().any(|f| f.abs() > 0.0),
    }
}

fn from_first_contact(samples: &[Sample]) -> &[Sample] {
    let start = samples.iter().position(in_contact).unwrap_or(samples.len());
    &samples[start..]
}

fn contacts(samples: &[Sample]) -> usize {
    samples.chunk_by(|a, b| in_contact(a) == in_contact(b)).filter(|run| in_contact(&run[0])).count()
}

fn rmse(recording: &Recording, axis: usize) -> Option<f64> {
    let start = evaluation_start(recording)?;
    let judged = recording.samples.iter().filter(|s| s.time_s >= start);
    mean_square(judged.filter_map(|s| force_error(s, axis))).map(f64::sqrt)
}

fn mean_square(errors: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), e| (e.mul_add(e, sum), count + 1.0));
    (count > 0.0).then_some(sum / count)
}

fn overshoot(samples: &[Sample]) -> Option<Overshoot> {
    let excess = |s: &Sample| {
        let target = s.target_force[0]?;
        Some(((s.force[0] - target) * target.signum(), target.abs()))
    };
    let (newton, target) = samples.iter().filter_map(excess).max_by(|a, b| a.0.total_cmp(&b.0))?;
    if newton <= 0.0 {
        return Some(Overshoot { newton: 0.0, percent: 0.0 });
    }
    Some(Overshoot { newton, percent: 100.0 * newton / target })
}

fn settling_time(samples: &[Sample]) -> Option<f64> {
    let end = samples.last()?.time_s;
    let settled = samples.iter().rev().take_while(|s| in_band(s)).last()?.time_s;
    (end - settled >= SETTLED_FOR_S).then_some(settled)
}

fn in_band(sample: &Sample) -> bool {
    sample.target_force[0].is_some_and(|target| (sample.force[0] - target).abs() <= SETTLING_BAND * target.abs())
}

fn max_joint_speed(samples: &[Sample]) -> f64 {
    samples.iter().flat_map(|s| &s.joint_velocity).map(|v| v.abs()).fold(0.0, larger)
}

fn calls_per_second(recording: &Recording) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "far fewer than 2^53 samples")]
    let calls = recording.samples.len() as f64;
    (recording.wall_time_s > 0.0).then(|| calls / recording.wall_time_s)
}

fn paths(samples: &[Sample]) -> BTreeMap<Path, usize> {
    let mut counts = BTreeMap::new();
    for sample in samples {
        *counts.entry(sample.path).or_default() += 1;
    }
    counts
}

fn command_difference(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() {
        return f64::INFINITY;
    }
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, larger)
}

/// The larger of two numbers. A value that is not a number counts as infinite, where `f64::max`
/// would drop it and so hide the worst sample.
fn larger(a: f64, b: f64) -> f64 {
    if b.is_nan() { f64::INFINITY } else { a.max(b) }
}

#[cfg(test)]
mod tests;
