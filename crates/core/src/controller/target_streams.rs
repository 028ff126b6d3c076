//! The streamed targets of all tasks in one period.

use nalgebra::{UnitQuaternion, Vector3};

use super::task::ArmState;
use super::{ControllerConfig, Measurement, Memory, TaskConfig};
use crate::law::TargetForce;
use crate::linalg::TaskVector;
use crate::streaming::{Bound, Ignored, MAX_AHEAD, Quantity, Target, TargetState, TargetStream, TargetValue};

/// A target that arrives with a measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamedTarget {
    /// Index of the task, from 0.
    pub task: usize,
    /// Time of the target on the clock of the measurements, s.
    pub time_s: f64,
    /// The value.
    pub value: StreamedValue,
    /// Velocity of the value along the rows of the task, m entries, m/s and rad/s; `None`: estimated. In the tool
    /// frame: along the axes of the target.
    pub velocity: Option<Vec<f64>>,
}

/// The value of a target.
#[derive(Debug, Clone, PartialEq)]
pub enum StreamedValue {
    /// A pose (m) of the reference point, in the task's fixed frame, if it has one, otherwise in the base frame. A part
    /// that is `None` is that of the tool.
    Pose {
        /// The position, m.
        position: Option<Vector3<f64>>,
        /// The orientation.
        orientation: Option<UnitQuaternion<f64>>,
    },
    /// Positions of the joints of the task, rad or m.
    JointPosition(Vec<f64>),
    /// The velocity ẋ of the task, m/s and rad/s.
    Velocity(Vec<f64>),
    /// The force F_d of the task, N and N·m.
    Force(Vec<f64>),
}

/// Why a target is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// There is no such task, or its law does not follow such targets.
    #[error("the law of this task does not follow such targets")]
    Quantity,
    /// The number of values is not the number of rows.
    #[error("{given} values for {expected} rows; give one per row")]
    Rows {
        /// Rows of the task.
        expected: usize,
        /// Values given.
        given: usize,
    },
    /// A number is not finite.
    #[error("the numbers of a target must be finite")]
    NotFinite,
    /// Time of the target is too far ahead.
    #[error("the target is {ahead_s} s ahead of the state; give at most {MAX_AHEAD} s, on the clock of the states")]
    Ahead {
        /// Time of the target minus time of the state, s.
        ahead_s: f64,
    },
}

/// The streamed target of a task in one period, as the answer reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetReport {
    /// Where the target comes from.
    pub state: TargetState,
    /// Time of the measurement minus time of the newest target, s; `None`: no target on this clock.
    pub age_s: Option<f64>,
    /// A target of this measurement that was ignored.
    pub ignored: Option<Ignored>,
}

/// A stream with the values that only this period uses.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ActiveStream {
    pub stream: TargetStream,
    /// Velocity of the target for the law. A law that integrates uses the velocity of the last period and the
    /// acceleration, as of the arm; the others use the velocity of this period.
    pub velocity: TaskVector,
    /// Acceleration of the target, velocity per second.
    pub acceleration: TaskVector,
    ignored: Option<Ignored>,
}

/// The streams of one task in this period.
#[derive(Clone, Copy, Default)]
pub(super) struct TaskStreams<'a> {
    /// Pose or joint positions.
    pub position: Option<&'a ActiveStream>,
    /// Velocity or force.
    pub rows: Option<&'a ActiveStream>,
}

impl StreamedValue {
    fn quantity(&self) -> Quantity {
        match self {
            Self::Pose { .. } => Quantity::Pose,
            Self::JointPosition(_) => Quantity::JointPosition,
            Self::Velocity(_) => Quantity::Velocity,
            Self::Force(_) => Quantity::Force,
        }
    }

    fn is_finite(&self) -> bool {
        match self {
            Self::Pose { position, orientation } => {
                position.is_none_or(|position| position.iter().all(|entry| entry.is_finite()))
                    && orientation.is_none_or(|orientation| orientation.coords.iter().all(|entry| entry.is_finite()))
            }
            Self::JointPosition(rows) | Self::Velocity(rows) | Self::Force(rows) => {
                rows.iter().all(|entry| entry.is_finite())
            }
        }
    }
}

impl StreamedTarget {
    /// Checks that the target fits its task and the time of the measurement.
    pub fn check(&self, config: &ControllerConfig, time_s: f64) -> Result<(), TargetError> {
        let task = config.tasks.get(self.task).ok_or(TargetError::Quantity)?;
        let quantity = self.value.quantity();
        if !task.accepts(quantity) || (self.velocity.is_some() && !quantity.is_position()) {
            return Err(TargetError::Quantity);
        }
        let expected = task.rows.len();
        let rows = match &self.value {
            StreamedValue::Pose { .. } => None,
            StreamedValue::JointPosition(rows) | StreamedValue::Velocity(rows) | StreamedValue::Force(rows) => {
                Some(rows)
            }
        };
        for given in rows.into_iter().chain(&self.velocity).map(Vec::len) {
            if given != expected {
                return Err(TargetError::Rows { expected, given });
            }
        }
        let is_finite = |rows: &Vec<f64>| rows.iter().all(|entry| entry.is_finite());
        if !(self.time_s.is_finite() && self.value.is_finite() && self.velocity.as_ref().is_none_or(is_finite)) {
            return Err(TargetError::NotFinite);
        }
        let ahead_s = self.time_s - time_s;
        if ahead_s > MAX_AHEAD { Err(TargetError::Ahead { ahead_s }) } else { Ok(()) }
    }
}

/// Overwrites `streams` with the streams of this period.
pub(super) fn update(
    streams: &mut Vec<ActiveStream>,
    previous: &Memory,
    measurement: &Measurement,
    arm: &ArmState,
    config: &ControllerConfig,
) {
    streams.truncate(previous.target_streams.len());
    for (k, stream) in previous.target_streams.iter().enumerate() {
        match streams.get_mut(k) {
            Some(active) => active.stream.clone_from(stream),
            None => streams.push(ActiveStream::new(stream.clone())),
        }
    }
    for active in &mut *streams {
        active.ignored = None;
        active.stream.forget_future(measurement.time_s);
    }
    for target in &measurement.targets {
        accept(streams, target, previous, arm, config);
    }
    for active in streams {
        active.update(previous, arm, config);
    }
}

/// Adds a checked target to its stream, which it starts if there is none.
fn accept(
    streams: &mut Vec<ActiveStream>,
    given: &StreamedTarget,
    previous: &Memory,
    arm: &ArmState,
    config: &ControllerConfig,
) {
    let (k, quantity) = (given.task, given.value.quantity());
    let task = &config.tasks[k];
    let index = match streams.binary_search_by_key(&(k, quantity), |active| active.key()) {
        Ok(index) => index,
        Err(index) => {
            let reference = task.own_reference(quantity, arm, previous.task_velocities[k].as_slice());
            streams.insert(index, ActiveStream::new(TargetStream::new(k, quantity, reference)));
            index
        }
    };
    let (value, velocity) = task.rows.target(given, arm);
    let target = Target { time_s: given.time_s, value, velocity };
    let ignored = streams[index].stream.accept(target, &task.streaming);
    streams[index].ignored = ignored.or(streams[index].ignored);
}

impl ActiveStream {
    fn new(stream: TargetStream) -> Self {
        let acceleration = TaskVector::zeros(stream.reference.velocity.len());
        Self { stream, velocity: acceleration.clone(), acceleration, ignored: None }
    }

    fn key(&self) -> (usize, Quantity) {
        (self.stream.task, self.stream.quantity)
    }

    /// Computes the reference of this period.
    fn update(&mut self, previous: &Memory, arm: &ArmState, config: &ControllerConfig) {
        let task = &config.tasks[self.stream.task];
        let before = self.stream.reference.velocity.clone();
        let quantity = self.stream.quantity;
        let bound = |entry: usize| task.bound(quantity, entry, arm.robot);
        // A law with a spring keeps its reference, so that it keeps a contact.
        let is_held = quantity.is_position() && !task.law.integrates();
        let achieved = previous.task_velocities[self.stream.task].as_slice();
        let held = is_held.then(|| task.rows.actual(achieved, arm));
        self.stream.update(arm.time_s, &task.streaming, bound, held.as_ref(), config.period_s);
        let after = &self.stream.reference.velocity;
        self.acceleration = &(after - &before) * (1.0 / config.period_s);
        self.velocity = if task.law.integrates() { before } else { after.clone() };
    }

    fn report(&self, time_s: f64) -> TargetReport {
        TargetReport { state: self.stream.state, age_s: self.stream.age(time_s), ignored: self.ignored }
    }
}

impl<'a> TaskStreams<'a> {
    /// Finds the streams of a task (index from 0).
    pub fn of(streams: &'a [ActiveStream], task: usize) -> Self {
        let mut found = Self::default();
        for active in streams.iter().filter(|active| active.stream.task == task) {
            let place = if active.stream.quantity.is_position() { &mut found.position } else { &mut found.rows };
            *place = Some(active);
        }
        found
    }

    /// Returns the streamed velocity or force, m; `None` without one.
    pub fn values(&self) -> Option<&'a TaskVector> {
        match &self.rows?.stream.reference.value {
            TargetValue::Rows(rows) => Some(rows),
            TargetValue::Pose(_) => None,
        }
    }

    /// Replaces the velocity ẋ of force-controlled rows by one that brakes, if the stream of the force brakes.
    pub fn brake_forces(
        &self,
        velocity: &mut TaskVector,
        force: &TargetForce,
        integrator: &[f64],
        bound: impl Fn(usize) -> Bound,
        period: f64,
    ) {
        let brakes = |active: &ActiveStream| {
            active.stream.quantity == Quantity::Force && active.stream.state == TargetState::Braking
        };
        if !self.rows.is_some_and(brakes) {
            return;
        }
        for (row, velocity) in velocity.iter_mut().enumerate().filter(|(row, _)| force[*row].is_some()) {
            let change = bound(row).acceleration * period;
            *velocity = integrator[row] - integrator[row].clamp(-change, change);
        }
    }

    /// Returns the report of the stream with the oldest target; `None` without a stream.
    pub fn report(&self, time_s: f64) -> Option<TargetReport> {
        let reports = [self.position, self.rows].into_iter().flatten().map(|active| active.report(time_s));
        reports.reduce(|a, b| {
            let worst = if b.state > a.state { b } else { a };
            TargetReport { ignored: a.ignored.or(b.ignored), ..worst }
        })
    }
}

/// Maximum velocity and acceleration of a streamed target on a row, unless the task states its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RowKind<'a> {
    /// A linear axis of the tool, m.
    Linear,
    /// An angular axis of the tool, rad.
    Angular,
    /// A joint.
    Joint(&'a revprio_robot::Joint),
    /// A constant row, of any unit.
    Raw,
}

/// Acceleration of joints without an acceleration limit, and of constant rows.
const DEFAULT_ACCELERATION: f64 = 5.0;

impl RowKind<'_> {
    /// Linear axes: 1 m/s and 5 m/s²; angular axes: 2 rad/s and 10 rad/s². A hand moves so when it works, not when it
    /// throws.
    fn bound(self) -> Bound {
        match self {
            Self::Linear => Bound { velocity: 1.0, acceleration: 5.0 },
            Self::Angular => Bound { velocity: 2.0, acceleration: 10.0 },
            Self::Joint(joint) => {
                let acceleration = Some(joint.limits.acceleration).filter(|value| value.is_finite() && *value > 0.0);
                let acceleration = acceleration.unwrap_or(DEFAULT_ACCELERATION);
                Bound { velocity: joint.limits.velocity, acceleration }
            }
            Self::Raw => Bound { velocity: f64::INFINITY, acceleration: DEFAULT_ACCELERATION },
        }
    }
}

impl TaskConfig {
    /// Returns whether streamed targets of this task can be of a quantity.
    pub fn accepts(&self, quantity: Quantity) -> bool {
        match quantity {
            Quantity::Pose | Quantity::JointPosition => {
                self.law.follows_position() && self.rows.position_quantity() == Some(quantity)
            }
            Quantity::Velocity => self.law.follows_velocity(),
            Quantity::Force => self.law.follows_force(),
        }
    }

    /// Returns what streamed targets of this task can be.
    pub fn quantities(&self) -> Vec<Quantity> {
        Quantity::ALL.into_iter().filter(|quantity| self.accepts(*quantity)).collect()
    }

    /// Returns the bound of an entry of a streamed target: a row, or the first entry of a part of a pose. A part of a pose
    /// has the smallest bounds of its rows.
    pub(super) fn bound(&self, quantity: Quantity, entry: usize, robot: &revprio_robot::RobotModel) -> Bound {
        let of_row = |row: usize| {
            let default = self.rows.kind(row, robot).bound();
            let own = |values: &Option<Vec<f64>>, default: f64| values.as_ref().map_or(default, |values| values[row]);
            Bound {
                velocity: own(&self.streaming.max_velocity, default.velocity),
                acceleration: own(&self.streaming.max_acceleration, default.acceleration),
            }
        };
        if quantity != Quantity::Pose {
            return of_row(entry);
        }
        let kind = if entry < 3 { RowKind::Linear } else { RowKind::Angular };
        let rows = (0..self.rows.len()).filter(|&row| self.rows.kind(row, robot) == kind).map(of_row);
        let smallest = rows.reduce(|a, b| Bound {
            velocity: a.velocity.min(b.velocity),
            acceleration: a.acceleration.min(b.acceleration),
        });
        smallest.unwrap_or_else(|| kind.bound())
    }
}
