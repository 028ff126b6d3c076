//! Metrics of one [`Recording`].

pub mod limits;

use std::collections::BTreeMap;

use revprio_api::wire::{Path, Status};
use serde::Serialize;

use crate::simulator::recording::{ContactEvent, Recording, Sample};

/// For a run longer than this (s), only the steady part is evaluated.
pub const LONG_RUN_S: f64 = 10.0;
/// Start of the steady part of a long run (s).
pub const STEADY_FROM_S: f64 = 5.0;
/// Half width of the settling band, as a fraction of the target.
pub const SETTLING_BAND: f64 = 0.05;
/// Time (s) for which a force must stay inside the band to count as settled. A stiff contact oscillates at some 80 rad/s
/// with a period of 0.08 s. Therefore a force that only crosses the band at the end of a run does not count.
pub const SETTLED_FOR_S: f64 = 0.1;
/// The last part of a run, as a fraction of its samples, over which the steady error is averaged.
pub const STEADY_PART: f64 = 0.1;

/// Excess of a force over its target, in the direction of the target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Overshoot {
    /// Largest excess over the target of the same instant (N), at least 0.
    pub newton: f64,
    /// The same as a percentage of that target; infinite if the target is 0.
    pub percent: f64,
}

/// Residual of one task over a run, `‖J_k q̇ − ẋ_k‖` (m/s and rad/s).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Residual {
    /// Root mean square over all samples.
    pub rms: f64,
    /// Largest value.
    pub largest: f64,
}

/// How often the law `contact` lost its surface and gave a contact up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct ContactFailures {
    /// Losses: the tool left the surface, and went back to it.
    pub losses: usize,
    /// Faults: the law gave the contact up.
    pub faults: usize,
}

/// The direction of the force `F` of [`Metrics`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// An axis of the base, 0 = x.
    Base(usize),
    /// The pressing direction of the first axis with the law `contact`.
    Contact,
}

impl Direction {
    /// Returns the force of a sample along the direction, N; 0 without such an axis.
    fn force(self, sample: &Sample) -> f64 {
        match self {
            Self::Base(axis) => sample.force[axis],
            Self::Contact => sample.contacts.force.first().copied().unwrap_or(0.0),
        }
    }

    /// Returns the target force of a sample along the direction, N; `None` without one.
    fn target(self, sample: &Sample) -> Option<f64> {
        match self {
            Self::Base(axis) => sample.target_force[axis],
            Self::Contact => sample.contacts.target_force.first().copied(),
        }
    }

    /// Returns the force minus its target, N; `None` without a target.
    fn error(self, sample: &Sample) -> Option<f64> {
        self.target(sample).map(|target| self.force(sample) - target)
    }

    /// Returns the sign of the target force, ±1; +1 without a target.
    fn sign(self, sample: &Sample) -> f64 {
        self.target(sample).map_or(1.0, f64::signum)
    }
}

/// Metrics of one run. `F` is the force along one direction, x by default. The tool is *in contact* while its distance to the
/// wall is not positive or, without a wall, while a force is measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Metrics {
    /// Root mean square of `F_x − F_d,x` (N) from [`evaluation_start`] on; `None` if x has no
    /// target or there was no contact.
    pub rmse_fx: Option<f64>,
    /// The same for y (N).
    pub rmse_fy: Option<f64>,
    /// The same for z (N).
    pub rmse_fz: Option<f64>,
    /// The same for the measured force along the pressing direction of an axis with the law `contact` (N); `None` if `F` has another
    /// direction.
    pub rmse_contact: Option<f64>,
    /// Overshoot of `F` after the first contact; `None` without target or contact.
    pub overshoot: Option<Overshoot>,
    /// Simulated time (s) from which `F` stays within [`SETTLING_BAND`] of its target until the
    /// end, and for at least [`SETTLED_FOR_S`]; `None` if it does not settle.
    pub settling_time_s: Option<f64>,
    /// Mean of `F − F_d` (N) over the last [`STEADY_PART`] of the run; `None` without target or contact.
    pub steady_error: Option<f64>,
    /// `F` of the last sample (N); `None` for an empty run.
    pub final_force: Option<f64>,
    /// Largest `F` (N) in the direction of its target, at least 0.
    pub peak_force: f64,
    /// Simulated time of the first contact (s).
    pub first_contact_s: Option<f64>,
    /// Number of separate contact intervals.
    pub contacts: usize,
    /// Losses and faults that the law `contact` told on all its axes; `None` if no task has this law.
    pub contact_failures: Option<ContactFailures>,
    /// Largest `|q̇_i|` of any joint (rad/s).
    pub max_joint_speed: f64,
    /// Least distance of the watched pairs of shapes (m); `None` if no pair is watched.
    pub least_distance_m: Option<f64>,
    /// Residuals of the tasks, highest priority first.
    pub residuals: Vec<Residual>,
    /// Control periods per second of real time; `None` if the run took no measurable time.
    pub calls_per_second: Option<f64>,
    /// Number of answers of each solution path.
    pub paths: BTreeMap<Path, usize>,
    /// Number of answers with each status.
    pub statuses: BTreeMap<Status, usize>,
    /// Largest KKT residual of any answer; `None` if no answer has one.
    pub largest_kkt_residual: Option<f64>,
    /// Periods without an answer.
    pub unanswered: usize,
}

impl Metrics {
    /// Computes the metrics of a run, with `F` along x.
    #[must_use]
    pub fn of(recording: &Recording) -> Self {
        Self::along(recording, Direction::Base(0))
    }

    /// Computes the metrics of a run, with `F` along a direction.
    #[must_use]
    pub fn along(recording: &Recording, direction: Direction) -> Self {
        let samples = &recording.samples;
        let touched = from_first_contact(samples);
        let answered = samples.iter().filter(|s| s.answered);
        Self {
            rmse_fx: rmse(recording, Direction::Base(0)),
            rmse_fy: rmse(recording, Direction::Base(1)),
            rmse_fz: rmse(recording, Direction::Base(2)),
            rmse_contact: rmse(recording, Direction::Contact).filter(|_| direction == Direction::Contact),
            overshoot: overshoot(touched, direction),
            settling_time_s: settling_time(touched, direction),
            steady_error: steady_error(samples, direction).filter(|_| !touched.is_empty()),
            final_force: samples.last().map(|s| direction.force(s)),
            peak_force: samples.iter().map(|s| direction.force(s) * direction.sign(s)).fold(0.0, larger),
            first_contact_s: touched.first().map(|s| s.time_s),
            contacts: contacts(samples),
            contact_failures: contact_failures(samples),
            max_joint_speed: max_joint_speed(samples),
            least_distance_m: samples.iter().filter_map(|s| s.least_distance).reduce(f64::min),
            residuals: residuals(samples),
            calls_per_second: calls_per_second(recording),
            paths: counts(answered.clone().map(|s| s.path)),
            statuses: counts(answered.map(|s| s.status)),
            largest_kkt_residual: samples.iter().filter_map(|s| s.kkt_residual).reduce(larger),
            unanswered: samples.iter().filter(|s| !s.answered).count(),
        }
    }
}

/// Returns the pressing direction of the law `contact` if it follows a surface, otherwise the main axis.
#[must_use]
pub fn main_direction(recording: &Recording) -> Direction {
    let follows = |sample: &Sample| sample.contacts.surface.is_followed();
    if recording.samples.first().is_some_and(follows) {
        return Direction::Contact;
    }
    Direction::Base(main_axis(recording))
}

/// Returns the first axis whose force has a target, or x if there is none.
#[must_use]
pub fn main_axis(recording: &Recording) -> usize {
    let targets = recording.samples.first().map_or([None; 3], |sample| sample.target_force);
    targets.iter().position(Option::is_some).unwrap_or(0)
}

/// Returns the largest difference between the commands of two runs, `max_i ‖q̇_a,i − q̇_b,i‖∞` (rad/s).
///
/// The result is infinite if the runs have a different number of samples or joints, or if a command is not a number, so
/// that runs that cannot be compared never count as equal.
#[must_use]
pub fn largest_difference(a: &Recording, b: &Recording) -> f64 {
    if a.samples.len() != b.samples.len() {
        return f64::INFINITY;
    }
    differences(a, b).fold(0.0, larger)
}

/// Returns the difference between the commands of two runs in each control period, `‖q̇_a,i − q̇_b,i‖∞` (rad/s).
pub fn differences<'a>(a: &'a Recording, b: &'a Recording) -> impl Iterator<Item = f64> + 'a {
    a.samples.iter().zip(&b.samples).map(|(a, b)| command_difference(&a.joint_velocity, &b.joint_velocity))
}

/// Returns the start of the part over which the RMSE is computed (s): [`STEADY_FROM_S`] for a run longer than
/// [`LONG_RUN_S`], otherwise the first contact; `None` if a short run has no contact.
#[must_use]
pub fn evaluation_start(recording: &Recording) -> Option<f64> {
    let (first, last) = (recording.samples.first()?, recording.samples.last()?);
    if last.time_s - first.time_s > LONG_RUN_S {
        return Some(STEADY_FROM_S);
    }
    from_first_contact(&recording.samples).first().map(|s| s.time_s)
}

/// Returns `F − F_d` on one axis (N); `None` if the axis has no target.
#[must_use]
pub fn force_error(sample: &Sample, axis: usize) -> Option<f64> {
    Direction::Base(axis).error(sample)
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

/// Counts losses and faults; `None` without an axis with the law `contact`.
fn contact_failures(samples: &[Sample]) -> Option<ContactFailures> {
    samples.first().filter(|sample| !sample.contacts.is_empty())?;
    let events = samples.iter().flat_map(|sample| &sample.contacts.event);
    Some(events.fold(ContactFailures::default(), |count, event| match event {
        ContactEvent::None | ContactEvent::Approach | ContactEvent::Contact => count,
        ContactEvent::Loss => ContactFailures { losses: count.losses + 1, ..count },
        ContactEvent::Pull | ContactEvent::StaysInRetreat | ContactEvent::ForceLimit | ContactEvent::Stuck => {
            ContactFailures { faults: count.faults + 1, ..count }
        }
    }))
}

fn contacts(samples: &[Sample]) -> usize {
    samples.chunk_by(|a, b| in_contact(a) == in_contact(b)).filter(|run| in_contact(&run[0])).count()
}

fn rmse(recording: &Recording, direction: Direction) -> Option<f64> {
    let start = evaluation_start(recording)?;
    let evaluated = recording.samples.iter().filter(|s| s.time_s >= start);
    mean_square(evaluated.filter_map(|s| direction.error(s))).map(f64::sqrt)
}

fn mean_square(errors: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), e| (e.mul_add(e, sum), count + 1.0));
    (count > 0.0).then_some(sum / count)
}

fn overshoot(samples: &[Sample], direction: Direction) -> Option<Overshoot> {
    let excess = |s: &Sample| {
        let target = direction.target(s)?;
        Some(((direction.force(s) - target) * target.signum(), target.abs()))
    };
    let (newton, target) = samples.iter().filter_map(excess).max_by(|a, b| a.0.total_cmp(&b.0))?;
    if newton <= 0.0 {
        return Some(Overshoot { newton: 0.0, percent: 0.0 });
    }
    Some(Overshoot { newton, percent: 100.0 * newton / target })
}

fn settling_time(samples: &[Sample], direction: Direction) -> Option<f64> {
    let end = samples.last()?.time_s;
    let settled = samples.iter().rev().take_while(|s| in_band(s, direction)).last()?.time_s;
    (end - settled >= SETTLED_FOR_S).then_some(settled)
}

fn in_band(sample: &Sample, direction: Direction) -> bool {
    let within = |target: f64| (direction.force(sample) - target).abs() <= SETTLING_BAND * target.abs();
    direction.target(sample).is_some_and(within)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count below that of the samples")]
fn steady_error(samples: &[Sample], direction: Direction) -> Option<f64> {
    let part = (STEADY_PART * samples.len() as f64).ceil() as usize;
    let errors: Option<Vec<f64>> = samples.iter().rev().take(part).map(|s| direction.error(s)).collect();
    let errors = errors.filter(|errors| !errors.is_empty())?;
    Some(errors.iter().sum::<f64>() / errors.len() as f64)
}

fn residuals(samples: &[Sample]) -> Vec<Residual> {
    let tasks = samples.first().map_or(0, |s| s.residual_norms.len());
    let of_task = |k: usize| samples.iter().filter_map(move |s| s.residual_norms.get(k).copied());
    let residual =
        |k| Residual { rms: mean_square(of_task(k)).map_or(0.0, f64::sqrt), largest: of_task(k).fold(0.0, larger) };
    (0..tasks).map(residual).collect()
}

fn max_joint_speed(samples: &[Sample]) -> f64 {
    samples.iter().flat_map(|s| &s.joint_velocity).map(|v| v.abs()).fold(0.0, larger)
}

fn calls_per_second(recording: &Recording) -> Option<f64> {
    let calls = recording.samples.len() as f64;
    (recording.wall_time_s > 0.0).then(|| calls / recording.wall_time_s)
}

fn counts<T: Ord>(values: impl Iterator<Item = T>) -> BTreeMap<T, usize> {
    let mut counts = BTreeMap::new();
    for value in values {
        *counts.entry(value).or_default() += 1;
    }
    counts
}

fn command_difference(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() {
        return f64::INFINITY;
    }
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, larger)
}

/// Returns the larger of two numbers. NaN counts as infinite; `f64::max` would ignore it and hide the worst sample.
#[must_use]
pub fn larger(a: f64, b: f64) -> f64 {
    if b.is_nan() { f64::INFINITY } else { a.max(b) }
}

#[cfg(test)]
mod tests;
