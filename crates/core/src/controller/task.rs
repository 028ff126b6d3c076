//! One task: what it is about, and its law.

use nalgebra::IsometryMatrix3;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::Configuration;

use super::null_space::mid_range_rate;
use super::{JointRows, JointTarget, ToolRows};
use crate::law::{Law, Profile, TaskState};
use crate::linalg::{Matrix, TaskVector};

/// One task with its law.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskConfig {
    /// Name, for people and answers.
    pub name: String,
    /// What the task is about.
    pub rows: TaskRows,
    /// How its velocity is made; as many rows as the task.
    pub law: Law,
    /// Whether limits may slow the task down, but not bend it.
    pub scaled: bool,
}

/// What a task is about.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a few per controller, made once")]
pub enum TaskRows {
    /// Directions of the tool.
    Tool(ToolRows),
    /// Joints.
    Joints(JointRows),
}

/// Why a task is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TaskConfigError {
    /// Law, target and rows differ in size.
    #[error("{given} values for {expected} rows; give one per row")]
    Rows {
        /// Rows of the task.
        expected: usize,
        /// Rows of the law or the target.
        given: usize,
    },
    /// Joints feel no force.
    #[error("joints take the laws velocity and position")]
    JointLaw,
    /// A joint that the robot does not have, stands twice, or has no middle.
    #[error("joints must exist and stand once; to be led to the middle of their ranges they need ranges")]
    Joints,
    /// From period to period the law would overshoot more than it corrects.
    #[error("a gain of {gain} overshoots from period to period; it must stay below {bound}")]
    Unstable {
        /// Row, from 0.
        row: usize,
        /// The gain.
        gain: f64,
        /// The smallest one that swings for ever.
        bound: f64,
    },
}

/// What all tasks of one period are seen against.
pub(super) struct Sensed<'a> {
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
}

impl TaskConfig {
    /// Checks that the parts fit together, fit the robot, and settle at this period (s).
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
        }
        self.check_gain(robot, period)
    }

    /// A displacement is multiplied by 1 − K T each period: |1 − K T| must be below 1, or equal for K = 0.
    fn check_gain(&self, robot: &RobotModel, period: f64) -> Result<(), TaskConfigError> {
        let Law::Position(law) = &self.law else { return Ok(()) };
        let rate = |row: usize| match &self.rows {
            TaskRows::Joints(JointRows { joints, target: JointTarget::MidRange }) => mid_range_rate(robot, joints[row]),
            _ => 1.0,
        };
        let bounds = (0..law.rows()).map(|row| 2.0 / (rate(row) * period));
        match bounds.zip(law.gain().iter()).enumerate().find(|(_, (bound, gain))| *gain >= bound) {
            Some((row, (bound, &gain))) => Err(TaskConfigError::Unstable { row, gain, bound }),
            None => Ok(()),
        }
    }
}

impl TaskRows {
    /// m, the number of rows.
    #[expect(clippy::len_without_is_empty, reason = "a task has at least one row")]
    pub fn len(&self) -> usize {
        match self {
            Self::Tool(rows) => rows.axes.len(),
            Self::Joints(rows) => rows.joints.len(),
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
        }
    }

    /// J_k q̇, m, m/s and rad/s.
    pub(super) fn velocity(&self, sensed: &Sensed) -> TaskVector {
        match self {
            Self::Tool(rows) => rows.entries_of(&rows.frame.at(sensed.configuration).twist(&sensed.twist)),
            Self::Joints(rows) => rows.entries_of(sensed.joint_velocity),
        }
    }

    /// What the law sees.
    pub(super) fn state(&self, sensed: &Sensed) -> TaskState {
        match self {
            Self::Tool(rows) => rows.state(self.velocity(sensed), sensed),
            Self::Joints(rows) => rows.state(self.velocity(sensed), sensed),
        }
    }
}
