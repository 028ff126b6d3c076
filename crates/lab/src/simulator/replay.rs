//! The states of a recording once more, and whether the answers are still the same.

use std::ops::ControlFlow;

use revprio_api::Service;
use revprio_api::wire;

use super::caller::Caller;
use super::plant::target_force;
use super::recording::{AtLimit, Extent, Recording, Sample, Sensed, Value};
use super::run::{CallMode, RunError};

/// Why nothing can be compared.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The controller is not known.
    #[error("the recording does not say which controller it is of")]
    NoController,
    /// The service gave no answer.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// What came of a replay.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Replay {
    /// Periods of the recording.
    pub periods: usize,
    /// Answers of the recording that were compared; the service was silent in the other periods.
    pub compared: usize,
    /// Answers that differ by more than the tolerance.
    pub differing: usize,
    /// The first of these differences.
    pub first: Option<Difference>,
    /// The largest difference of any number, below the tolerance too.
    pub worst: Option<Difference>,
}

/// Two values that should be the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Number of the period, from 0.
    pub period: usize,
    /// Simulated time, s.
    pub time_s: f64,
    /// Name of the column, as in the files.
    pub column: String,
    /// As recorded.
    pub recorded: Value,
    /// As answered now.
    pub answered: Value,
}

/// Sends every recorded state to a service, in order, and compares each answer with the recorded one: commands, residuals,
/// limits, path and status. Numbers may differ by `tolerance`; with 0 they must be the same bits.
///
/// Where the recording obeys an older answer, as after a fault of the line, that one is compared. With faults, answers can
/// only be the same in the mode in which they were recorded.
pub fn replay(
    recording: &Recording,
    service: &dyn Service,
    mode: CallMode,
    tolerance: f64,
    mut progress: impl FnMut(u64) -> ControlFlow<()>,
) -> Result<Replay, ReplayError> {
    let scenario = recording.setup.as_deref().ok_or(ReplayError::NoController)?;
    let controller = &scenario.controller;
    let refused = |time_s| move |source| RunError::Service { time_s, source };
    let mut caller = Caller::open(controller, service, mode).map_err(refused(0.0))?;
    let mut again = Recording { timings: Vec::new(), samples: Vec::new(), ..recording.clone() };
    let mut result = Replay { periods: recording.samples.len(), ..Replay::default() };
    let columns = Extent::of(recording, false).columns();
    for (period, sample) in recording.samples.iter().enumerate() {
        let time_s = sample.time_s;
        // A service that was dead was not asked.
        if scenario.faults.is_dead(time_s) {
            again.samples.push(sample.clone());
        } else {
            let answer = caller.call(state(period, sample)).map_err(refused(time_s))?;
            again.samples.push(answered(sample, &controller.tasks, &answer, &recording.joint_names));
        }
        let age = usize::try_from(sample.answer_age).ok().and_then(|age| period.checked_sub(age));
        if let (true, Some(asked)) = (sample.answered, age) {
            result.compared += 1;
            let differences = columns.iter().filter(|column| column.quantity.is_answered()).filter_map(|column| {
                let (recorded, answered) = (column.value(recording, period), column.value(&again, asked));
                let distance = distance(&recorded, &answered)?;
                Some((distance, Difference { period, time_s, column: column.name.clone(), recorded, answered }))
            });
            result.add(differences.collect(), tolerance);
        }
        if progress(period as u64 + 1).is_break() {
            return Err(RunError::Stopped { time_s }.into());
        }
    }
    Ok(result)
}

impl Replay {
    fn add(&mut self, differences: Vec<(f64, Difference)>, tolerance: f64) {
        let mut beyond = differences.iter().filter(|(distance, _)| *distance > tolerance);
        if let Some((_, first)) = beyond.next() {
            self.differing += 1;
            self.first.get_or_insert_with(|| first.clone());
        }
        for (far, difference) in differences {
            if self.worst.as_ref().is_none_or(|worst| far > worst.distance()) {
                self.worst = Some(difference);
            }
        }
    }
}

impl Difference {
    /// How far the two are apart; infinite where they are no numbers.
    pub fn distance(&self) -> f64 {
        distance(&self.recorded, &self.answered).unwrap_or(0.0)
    }
}

/// How far two values are apart; `None` if they are the same to the last bit.
fn distance(a: &Value, b: &Value) -> Option<f64> {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) if a.to_bits() == b.to_bits() => None,
        (Value::Number(a), Value::Number(b)) => Some((a - b).abs()).filter(|far| !far.is_nan()).or(Some(f64::INFINITY)),
        _ => (a != b).then_some(f64::INFINITY),
    }
}

/// The state as the controller was told it.
fn state(period: usize, sample: &Sample) -> wire::State {
    let told = sample.sensed.as_deref().cloned().unwrap_or_else(|| Sensed {
        joint_position: sample.joint_position.clone(),
        joint_velocity: sample.actual_velocity.clone(),
        force: sample.force,
        torque: sample.torque,
    });
    wire::State {
        sequence: period as u64,
        time_s: sample.time_s,
        joint_position: told.joint_position.into(),
        joint_velocity: Some(told.joint_velocity.into()),
        wrench: Some(wire::Wrench { force: told.force, torque: told.torque }),
    }
}

/// The sample with what another answer says.
fn answered(
    sample: &Sample,
    tasks: &[wire::ControllerTask],
    answer: &wire::StepAnswer,
    joint_names: &[String],
) -> Sample {
    Sample {
        joint_velocity: answer.joint_velocity.clone(),
        target_force: target_force(tasks, answer),
        path: answer.solver.path,
        status: answer.solver.status,
        kkt_residual: answer.solver.kkt_residual,
        smallest_singular_value: answer.singularity.smallest_singular_value,
        manipulability: answer.singularity.manipulability,
        residual_norms: answer.tasks.iter().map(|task| task.residual_norm).collect(),
        limits: AtLimit::of(answer, joint_names),
        ..sample.clone()
    }
}
