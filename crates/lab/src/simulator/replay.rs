//! Sends the states of a recording again and compares the answers.

use std::collections::{BTreeMap, VecDeque};
use std::ops::ControlFlow;

use revprio_api::Service;
use revprio_api::wire;

use super::callee::Callee;
use super::caller::{CallMode, Caller};
use super::moving_obstacles::MovingObstacles;
use super::recording::{Recording, Sample, Sensed, TableLayout, Value};
use super::run_error::RunError;
use super::target_program::TargetPrograms;
use super::watchdog::HeldCommand;

/// Why a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording has no controller.
    #[error("the recording does not contain its controller")]
    NoController,
    /// The service did not answer.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Result of a replay.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Replay {
    /// Periods of the recording.
    pub periods: usize,
    /// Number of compared answers; the other periods have no answer.
    pub compared: usize,
    /// Number of answers that differ by more than the tolerance.
    pub differing: usize,
    /// The first of these differences.
    pub first: Option<Difference>,
    /// The largest difference of any number, also if it is below the tolerance.
    pub worst: Option<Difference>,
}

/// A difference between a recorded and a new value.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Number of the period, from 0.
    pub period: usize,
    /// Simulated time, s.
    pub time_s: f64,
    /// Name of the column in the file.
    pub column: String,
    /// Recorded value.
    pub recorded: Value,
    /// New value.
    pub answered: Value,
}

/// Sends every recorded state to a service, in order, and compares each answer with the recorded one: commands, residuals,
/// limits, path and status. Numbers may differ by `tolerance`; with 0 they must be equal.
///
/// If the recorded arm executed an older answer because of a fault, that answer is compared, with the joint velocities of the arm's
/// reaction to the fault. With faults, the answers are only reproducible in the mode in which they were recorded.
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
    let obstacles = MovingObstacles::new(controller, &scenario.obstacle_motions).map_err(RunError::from)?;
    let mut streams = TargetPrograms::new(&scenario.target_programs, controller).map_err(RunError::from)?;
    let mut caller = Caller::open(controller, Callee::Borrowed(service), mode).map_err(refused(0.0))?;
    let mut again = Recording { timings: Vec::new(), samples: Vec::new(), ..recording.clone() };
    let mut answers = Answers::new(recording, controller.period_s);
    let mut result = Replay { periods: recording.samples.len(), ..Replay::default() };
    let columns = TableLayout::from_recording(recording, false).columns();
    for (period, sample) in recording.samples.iter().enumerate() {
        let time_s = sample.time_s;
        let last = period.checked_sub(1).map(|last| &recording.samples[last]);
        let targets = streams.next(sample.position, last.is_some_and(Sample::presses));
        // There was no call while the service was down.
        let answer = if scenario.faults.is_down(time_s) {
            None
        } else {
            let state = wire::State { obstacles: obstacles.states(time_s), targets, ..state(period, sample) };
            Some(caller.call(state).map_err(refused(time_s))?)
        };
        if answer.is_some() && sample.answer_age > 0 {
            caller.discard_answer();
        }
        if let (Some(held), true) = (answers.next(answer, sample), sample.answered) {
            again.samples = vec![sample.clone().answered(&controller.tasks, &held.answer, &recording.joint_names)];
            result.compared += 1;
            let differences = columns.iter().filter(|column| column.quantity.is_answered()).filter_map(|column| {
                let (recorded, answered) = (column.value(recording, period), column.value(&again, 0));
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

/// The answers that may still arrive, and the command of the arm.
struct Answers {
    period_s: f64,
    /// The newest last; `None`: the service was down.
    recent: VecDeque<Option<wire::StepAnswer>>,
    /// Number of answers that are kept.
    kept: usize,
    held: Option<HeldCommand>,
    /// Number of states so far.
    periods: u64,
}

impl Answers {
    /// Keeps as many answers as the recorded arm needs.
    fn new(recording: &Recording, period_s: f64) -> Self {
        let oldest = recording.samples.iter().filter(|sample| sample.answered).map(|sample| sample.answer_age).max();
        let kept = usize::try_from(oldest.unwrap_or(0)).unwrap_or(usize::MAX).min(recording.samples.len()) + 1;
        Self { period_s, recent: VecDeque::new(), kept, held: None, periods: 0 }
    }

    /// Adds the answer to the state of a period. Returns the command of the arm in it, from the answer that it had.
    fn next(&mut self, answer: Option<wire::StepAnswer>, sample: &Sample) -> Option<&HeldCommand> {
        // Sequence numbers begin with the recording, which may be a later part of a run.
        let time_s = self.periods as f64 * self.period_s;
        self.periods += 1;
        self.recent.push_back(answer);
        if self.recent.len() > self.kept {
            self.recent.pop_front();
        }
        let age = usize::try_from(sample.answer_age).unwrap_or(usize::MAX);
        let arrived = self.recent.iter().rev().nth(age).filter(|_| sample.answered).cloned().flatten();
        let before = self.held.take();
        self.held = match arrived {
            Some(answer) => Some(HeldCommand::new(answer, before.as_ref(), time_s, self.period_s)),
            None => before.map(|before| before.hold(time_s, self.period_s)),
        };
        self.held.as_ref()
    }
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
    /// Returns the absolute difference; infinite if the values are not numbers.
    pub fn distance(&self) -> f64 {
        distance(&self.recorded, &self.answered).unwrap_or(0.0)
    }
}

/// Returns the absolute difference of two values; `None` if they are the same to the last bit.
fn distance(a: &Value, b: &Value) -> Option<f64> {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) if a.to_bits() == b.to_bits() => None,
        (Value::Number(a), Value::Number(b)) => Some((a - b).abs()).filter(|far| !far.is_nan()).or(Some(f64::INFINITY)),
        _ => (a != b).then_some(f64::INFINITY),
    }
}

/// Returns the state that the controller received.
fn state(period: usize, sample: &Sample) -> wire::State {
    let sensed = sample.sensed.as_deref().cloned().unwrap_or_else(|| Sensed {
        joint_position: sample.joint_position.clone(),
        joint_velocity: sample.actual_velocity.clone(),
        force: sample.force,
        torque: sample.torque,
    });
    wire::State {
        wrenches: BTreeMap::new(),
        obstacles: Vec::new(),
        sequence: period as u64,
        time_s: sample.time_s,
        joint_position: sensed.joint_position.into(),
        joint_velocity: Some(sensed.joint_velocity.into()),
        wrench: Some(wire::Wrench { force: sensed.force, torque: sensed.torque }),
        targets: BTreeMap::new(),
        channels: BTreeMap::new(),
    }
}
