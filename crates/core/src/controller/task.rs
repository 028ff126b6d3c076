//! One task: its rows and its law.

use nalgebra::IsometryMatrix3;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::Configuration;

use super::target_bounds::RowKind;
use super::target_streams::TaskStreams;
use super::{JointRows, JointTarget, RawRows, StreamedTarget, StreamedValue, ToolRows};
use crate::law::{Law, Profile, TaskState};
use crate::linalg::{Matrix, TaskVector};
use crate::streaming::{Quantity, Reference, Streaming, StreamingError, TargetValue};

/// One task with its law.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskConfig {
    /// Name that answers use.
    pub name: String,
    /// The rows: axes of the tool, joints, or constant rows.
    pub rows: TaskRows,
    /// The law that computes the velocity, or bounds; as many rows as the task.
    pub law: Law,
    /// Whether the task is slowed down in its direction to keep limits, instead of changing its direction. A task with
    /// bounds cannot be.
    pub scaled: bool,
    /// How the task follows streamed targets.
    pub streaming: Streaming,
}

/// The rows of a task.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a few per controller, made once")]
pub enum TaskRows {
    /// Axes of the tool.
    Tool(ToolRows),
    /// Joints.
    Joints(JointRows),
    /// Constant rows over the joints.
    Raw(RawRows),
}

/// Why a task is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TaskConfigError {
    /// Law, target and rows differ in number.
    #[error("{given} values for {expected} rows; give one per row")]
    Rows {
        /// Rows of the task.
        expected: usize,
        /// Rows of the law or the target.
        given: usize,
    },
    /// A law that reads the wrench is set on joints.
    #[error("joints can have the laws velocity and position, or bounds, only")]
    JointLaw,
    /// A law that reads positions or the wrench is set on constant rows.
    #[error("constant rows can have the law velocity, or bounds, only")]
    RawLaw,
    /// Constant rows do not fit the robot or are not finite.
    #[error("a Jacobian needs at least one row of {expected} finite numbers, one per joint")]
    Jacobian {
        /// Joints of the robot.
        expected: usize,
    },
    /// A task with bounds is to be scaled.
    #[error("a task with bounds has no direction to keep; do not scale it")]
    Scaled,
    /// The settings of streamed targets are out of range.
    #[error(transparent)]
    Streaming(#[from] StreamingError),
    /// A joint does not exist, is listed twice, or has no range although the target is the middle of it.
    #[error("joints must exist and be listed once; the target mid-range needs joints with a range")]
    Joints,
    /// With this gain and period the law oscillates without decay.
    #[error("a gain of {gain} makes the law unstable at this period; it must be below {bound}")]
    Unstable {
        /// Row, from 0.
        row: usize,
        /// The gain.
        gain: f64,
        /// The smallest unstable gain.
        bound: f64,
    },
}

/// The measured state of the arm in one period, as all tasks use it.
#[derive(Clone, Copy)]
pub(super) struct ArmState<'a> {
    /// t, s.
    pub time_s: f64,
    pub robot: &'a RobotModel,
    pub configuration: &'a Configuration,
    /// q̇, n.
    pub joint_velocity: &'a [f64],
    /// Ẋ = J q̇, base axes, at the tool point.
    pub twist: [f64; 6],
    /// F_e on the environment, base axes, at the tool point.
    pub wrench: [f64; 6],
    /// Tool pose at the first step.
    pub initial_pose: IsometryMatrix3<f64>,
    /// The arm at its position of rest p behind the drive: where it goes if all later commands are zero.
    pub rest: &'a Configuration,
    /// L + D T, the time for which the arm goes there at a constant velocity, s.
    pub time_to_rest: f64,
}

impl TaskConfig {
    /// Checks that the parts fit each other and the robot, and that the law is stable at this period (s).
    pub(super) fn check(&self, robot: &RobotModel, period: f64) -> Result<(), TaskConfigError> {
        let expected = self.rows.len();
        let fits =
            |given: usize| if given == expected { Ok(()) } else { Err(TaskConfigError::Rows { expected, given }) };
        fits(self.law.rows())?;
        match &self.rows {
            TaskRows::Tool(rows) => fits(rows.target_displacement.as_ref().map_or(expected, Profile::rows))?,
            TaskRows::Joints(rows) => {
                rows.check(robot)?;
                if let JointTarget::Position(profile) = &rows.target {
                    fits(profile.rows())?;
                }
                if self.law.integrates() {
                    return Err(TaskConfigError::JointLaw);
                }
            }
            TaskRows::Raw(rows) => {
                rows.check(robot)?;
                if !matches!(self.law, Law::Velocity(_) | Law::Bounds(_)) {
                    return Err(TaskConfigError::RawLaw);
                }
            }
        }
        self.streaming.check(expected)?;
        if self.scaled && self.law.bounds().is_some() {
            return Err(TaskConfigError::Scaled);
        }
        self.check_gain(robot, period)
    }

    /// Returns the target from which streamed targets start: that of the configuration. `velocity`: ẋ of the last period, m.
    pub(super) fn own_reference(&self, quantity: Quantity, arm: &ArmState, velocity: &[f64]) -> Reference {
        match (quantity, &self.rows) {
            (Quantity::Pose, TaskRows::Tool(rows)) => rows.own_reference(arm),
            (Quantity::JointPosition, TaskRows::Joints(rows)) => rows.own_reference(arm),
            _ => Reference::at_rest(TargetValue::Rows(TaskVector::from_slice(velocity))),
        }
    }

    /// Returns the state for the law. A velocity law reads the time and streamed values alone.
    pub(super) fn state(&self, arm: &ArmState, streams: TaskStreams) -> TaskState {
        let streamed = streams.values().cloned();
        if self.law.follows_velocity() {
            return TaskState { time_s: arm.time_s, streamed, ..TaskState::default() };
        }
        let velocity = self.rows.velocity(arm);
        let state = match &self.rows {
            TaskRows::Tool(rows) => rows.state(velocity, arm, streams.position),
            TaskRows::Joints(rows) => rows.state(velocity, arm, streams.position),
            TaskRows::Raw(_) => RawRows::state(velocity, arm),
        };
        TaskState { streamed, ..state }
    }

    /// Returns the state as a position law sees it: of the arm at p, and of the target at the time when the arm is there.
    pub(super) fn state_at_rest(&self, arm: &ArmState, streams: TaskStreams) -> TaskState {
        let mut state = self.state(&ArmState { configuration: arm.rest, ..*arm }, streams);
        // Not even the sign of a zero changes without a drive.
        if arm.time_to_rest > 0.0 {
            for (displacement, velocity) in state.displacement.iter_mut().zip(state.target_velocity.iter()) {
                *displacement -= velocity * arm.time_to_rest;
            }
        }
        state
    }

    /// Checks the gain of a position law: each period multiplies a displacement by 1 − K T, so K T must be below 2.
    fn check_gain(&self, robot: &RobotModel, period: f64) -> Result<(), TaskConfigError> {
        let Law::Position(law) = &self.law else { return Ok(()) };
        let rate = |row: usize| self.rows.joint(robot, row).map_or(1.0, |(_, rate)| rate);
        let bounds = (0..law.rows()).map(|row| 2.0 / (rate(row) * period));
        match bounds.zip(law.gain().iter()).enumerate().find(|(_, (bound, gain))| *gain >= bound) {
            Some((row, (bound, &gain))) => Err(TaskConfigError::Unstable { row, gain, bound }),
            None => Ok(()),
        }
    }
}

impl TaskRows {
    /// Returns m, the number of rows.
    #[expect(clippy::len_without_is_empty, reason = "a task has at least one row")]
    pub fn len(&self) -> usize {
        match self {
            Self::Tool(rows) => rows.axes.len(),
            Self::Joints(rows) => rows.joints.len(),
            Self::Raw(rows) => rows.jacobian.nrows(),
        }
    }

    /// Returns the joint that a row moves, and the rate per unit of gain at which a position law moves it to its target;
    /// `None` for rows that move several joints. All rows of a task are of one kind.
    pub(super) fn joint(&self, robot: &RobotModel, row: usize) -> Option<(usize, f64)> {
        match self {
            Self::Joints(rows) => Some((rows.joints[row], rows.rate(robot, rows.joints[row]))),
            Self::Tool(_) | Self::Raw(_) => None,
        }
    }

    /// Overwrites `jacobian` with J_k, m × n.
    pub(super) fn write_jacobian(&self, configuration: &Configuration, jacobian: &mut Matrix) {
        match self {
            Self::Tool(rows) => rows.frame.at(configuration).write_rows(&rows.axes, jacobian),
            Self::Joints(rows) => {
                jacobian.fill(0.0);
                rows.joints.iter().enumerate().for_each(|(row, &joint)| jacobian[(row, joint)] = 1.0);
            }
            Self::Raw(rows) => jacobian.copy_from(&rows.jacobian),
        }
    }

    /// Returns J_k q̇, m, m/s and rad/s.
    pub(super) fn velocity(&self, arm: &ArmState) -> TaskVector {
        match self {
            Self::Tool(rows) => rows.select(&rows.frame.at(arm.configuration).twist(&arm.twist)),
            Self::Joints(rows) => rows.select(arm.joint_velocity),
            Self::Raw(rows) => rows.velocity(arm.joint_velocity),
        }
    }

    /// Returns the joints of the task, index from 0; empty for tasks of the tool and for constant rows.
    pub fn joints(&self) -> &[usize] {
        match self {
            Self::Joints(rows) => &rows.joints,
            Self::Tool(_) | Self::Raw(_) => &[],
        }
    }

    /// Returns the quantity of streamed positions; `None` if the rows have no position target.
    pub(super) fn position_quantity(&self) -> Option<Quantity> {
        match self {
            Self::Tool(_) => Some(Quantity::Pose),
            Self::Joints(rows) => matches!(rows.target, JointTarget::Position(_)).then_some(Quantity::JointPosition),
            Self::Raw(_) => None,
        }
    }

    /// Returns whether a row is an angular velocity, rad/s, and not a linear one, m/s; `None` for constant rows, of any unit.
    pub fn is_angular(&self, row: usize, robot: &RobotModel) -> Option<bool> {
        match self.kind(row, robot) {
            RowKind::Linear => Some(false),
            RowKind::Angular => Some(true),
            RowKind::Joint(joint) => Some(!joint.kind.is_translation()),
            RowKind::Raw => None,
        }
    }

    /// Returns the kind of a row, which decides the default bounds of its streamed targets.
    pub(super) fn kind<'a>(&self, row: usize, robot: &'a RobotModel) -> RowKind<'a> {
        match self {
            Self::Tool(rows) => rows.kind(row),
            Self::Joints(rows) => RowKind::Joint(&robot.joints()[rows.joints[row]]),
            Self::Raw(_) => RowKind::Raw,
        }
    }

    /// Returns whether a row is a linear axis of the tool.
    pub(super) fn is_linear(&self, row: usize) -> bool {
        matches!(self, Self::Tool(rows) if matches!(rows.kind(row), RowKind::Linear))
    }

    /// Returns the measured position with a velocity of the task, m.
    pub(super) fn actual(&self, velocity: &[f64], arm: &ArmState) -> Reference {
        match self {
            Self::Tool(rows) => rows.actual(velocity, arm),
            Self::Joints(rows) => rows.actual(velocity, arm),
            Self::Raw(_) => Reference::at_rest(TargetValue::Rows(TaskVector::from_slice(velocity))),
        }
    }

    /// Returns value and velocity of a streamed target.
    pub(super) fn target(&self, given: &StreamedTarget, arm: &ArmState) -> (TargetValue, Option<TaskVector>) {
        match (&given.value, self) {
            (StreamedValue::Pose { .. }, Self::Tool(rows)) => rows.streamed_target(given, arm),
            (StreamedValue::Pose { .. }, _) => (TargetValue::Rows(TaskVector::zeros(self.len())), None),
            (StreamedValue::JointPosition(rows) | StreamedValue::Velocity(rows) | StreamedValue::Force(rows), _) => {
                let velocity = given.velocity.as_ref().map(|velocity| TaskVector::from_slice(velocity));
                (TargetValue::Rows(TaskVector::from_slice(rows)), velocity)
            }
        }
    }
}
