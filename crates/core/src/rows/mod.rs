//! The rows of a task: what it measures and moves. One file for each kind.
//!
//! The rows of a kind are functions of the arm at a posture: the Jacobian J_k, the velocity J_k q̇, and the state that the law
//! reads. Their number never changes. So a controller allocates the block of each task once, and each period overwrites it.

mod frame;
mod gaze;
mod joints;
mod kind;
mod raw;
mod rows_error;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Frame, TaskFrame};

pub use frame::{TargetPose, ToolRows};
pub use gaze::GazeRows;
pub(crate) use joints::mid_range_rate;
pub use joints::{JointRows, JointTarget};
pub(crate) use kind::RowKind;
pub use raw::RawRows;
pub use rows_error::RowsError;

use crate::arm_state::{ArmAt, ArmState};
use crate::law::{Law, Profile, TaskState, TaskVector};
use crate::linalg::Matrix;
use crate::streaming::{ActiveStream, Quantity, Reference, StreamedTarget, StreamedValue, TargetValue};

/// The rows of a task.
#[derive(Debug, Clone, PartialEq)]
pub enum TaskRows {
    /// Axes of the tool.
    Tool(ToolRows),
    /// Joints.
    Joints(JointRows),
    /// Constant rows over the joints.
    Raw(RawRows),
    /// A direction that looks at a point.
    Gaze(GazeRows),
}

impl TaskRows {
    /// Returns the pose (base frame, m) of the frame in which target poses are given; `None` if that is the base frame.
    pub fn fixed_frame(&self) -> Option<&IsometryMatrix3<f64>> {
        match self {
            Self::Tool(ToolRows { frame: TaskFrame { frame: Frame::Fixed(frame), .. }, .. }) => Some(frame),
            Self::Tool(_) | Self::Joints(_) | Self::Raw(_) | Self::Gaze(_) => None,
        }
    }

    /// Returns whether both are rows of axes of the same body and frame; the reference points may differ.
    pub(crate) fn has_axes_of(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Tool(a), Self::Tool(b)) => a.frame.body == b.frame.body && a.frame.frame == b.frame.frame,
            _ => false,
        }
    }

    /// Returns whether the rows move another body than the tool, or see it from another link than the base.
    pub fn has_body(&self) -> bool {
        match self {
            Self::Tool(rows) => rows.frame.body.is_some(),
            Self::Gaze(rows) => rows.has_body(),
            Self::Joints(_) | Self::Raw(_) => false,
        }
    }

    /// Returns the index of the robot's tip whose wrench the rows read; `None`: they read none.
    pub(crate) fn tip(&self, robot: &RobotModel) -> Option<usize> {
        match self {
            Self::Tool(rows) => rows.frame.tip(robot),
            Self::Joints(_) | Self::Raw(_) | Self::Gaze(_) => None,
        }
    }

    /// Returns F_e, m, of the wrench that the rows read; `None`: they read none.
    pub(crate) fn force(&self, at: ArmAt) -> Option<TaskVector> {
        match self {
            Self::Tool(rows) => Some(rows.force_at(at)),
            Self::Joints(_) | Self::Raw(_) | Self::Gaze(_) => None,
        }
    }

    /// Returns the direction of a row in the axes of the base, a unit vector; `None` for rows that are no axis of a tool.
    pub(crate) fn direction(&self, row: usize, at: ArmAt) -> Option<Vector3<f64>> {
        match self {
            Self::Tool(rows) => Some(rows.direction(row, at)),
            Self::Joints(_) | Self::Raw(_) | Self::Gaze(_) => None,
        }
    }

    /// Returns m, the number of rows.
    #[expect(clippy::len_without_is_empty, reason = "a task has at least one row")]
    pub fn len(&self) -> usize {
        match self {
            Self::Tool(rows) => rows.axes.len(),
            Self::Joints(rows) => rows.joints.len(),
            Self::Raw(rows) => rows.jacobian.nrows(),
            Self::Gaze(_) => GazeRows::count(),
        }
    }

    /// Checks that the rows fit the robot and the law.
    pub(crate) fn check(&self, robot: &RobotModel, law: &Law) -> Result<(), RowsError> {
        RowsError::unless_equal(self.len(), law.rows())?;
        match self {
            Self::Tool(rows) => {
                rows.check_body(robot, law)?;
                RowsError::unless_equal(self.len(), rows.target_displacement.as_ref().map_or(self.len(), Profile::rows))
            }
            Self::Joints(rows) => rows.check(robot, law),
            Self::Raw(rows) => rows.check(robot, law),
            Self::Gaze(rows) => rows.check(robot, law),
        }
    }

    /// Returns the joint that a row moves, and the rate per unit of gain at which a position law moves it to its target;
    /// `None` for rows that move several joints. All rows of a task are of one kind.
    pub(crate) fn joint(&self, robot: &RobotModel, row: usize) -> Option<(usize, f64)> {
        match self {
            Self::Joints(rows) => Some((rows.joints[row], rows.rate(robot, rows.joints[row]))),
            Self::Tool(_) | Self::Raw(_) | Self::Gaze(_) => None,
        }
    }

    /// Returns the joints of the task, index from 0; empty for tasks of the tool and for constant rows.
    pub fn joints(&self) -> &[usize] {
        match self {
            Self::Joints(rows) => &rows.joints,
            Self::Tool(_) | Self::Raw(_) | Self::Gaze(_) => &[],
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

    /// Returns the kind of a row.
    pub(crate) fn kind<'a>(&self, row: usize, robot: &'a RobotModel) -> RowKind<'a> {
        match self {
            Self::Tool(rows) => rows.kind(row),
            Self::Joints(rows) => RowKind::Joint(&robot.joints()[rows.joints[row]]),
            Self::Raw(_) => RowKind::Raw,
            Self::Gaze(_) => RowKind::Angular,
        }
    }

    /// Returns whether a row is a linear axis of the tool.
    pub(crate) fn is_linear(&self, row: usize) -> bool {
        matches!(self, Self::Tool(rows) if matches!(rows.kind(row), RowKind::Linear))
    }

    /// Overwrites `jacobian` with J_k, m × n.
    pub(crate) fn write_jacobian(&self, at: ArmAt, jacobian: &mut Matrix) {
        match self {
            Self::Tool(rows) => rows.write_jacobian(at, jacobian),
            Self::Joints(rows) => rows.write_jacobian(jacobian),
            Self::Raw(rows) => jacobian.copy_from(&rows.jacobian),
            Self::Gaze(rows) => rows.write_jacobian(at, jacobian),
        }
    }

    /// Overwrites `jacobian` with J_k at one posture, along the axes that the frame of a tool task has at another one.
    pub(crate) fn write_jacobian_along(&self, at: ArmAt, axes_at: ArmAt, jacobian: &mut Matrix) {
        match self {
            Self::Tool(rows) => rows.write_jacobian_along(at, axes_at, jacobian),
            _ => self.write_jacobian(at, jacobian),
        }
    }

    /// Returns J_k q̇, m, m/s and rad/s.
    pub(crate) fn velocity(&self, at: ArmAt) -> TaskVector {
        match self {
            Self::Tool(rows) => rows.velocity(at),
            Self::Joints(rows) => rows.select(&at.arm.joint_velocity),
            Self::Raw(rows) => rows.velocity(&at.arm.joint_velocity),
            Self::Gaze(rows) => rows.velocity(at),
        }
    }

    /// Returns the state for the law; `position`: the stream of positions, if there is one.
    pub(crate) fn state(&self, at: ArmAt, position: Option<&ActiveStream>) -> TaskState {
        let velocity = self.velocity(at);
        match self {
            Self::Tool(rows) => rows.state(velocity, at, position),
            Self::Joints(rows) => rows.state(velocity, at, position),
            Self::Raw(_) => RawRows::state(velocity, at.arm.profile_time(at.time_s)),
            Self::Gaze(rows) => rows.state(velocity, at),
        }
    }

    /// Returns the quantity of streamed positions; `None` if the rows have no position target.
    pub(crate) fn position_quantity(&self) -> Option<Quantity> {
        match self {
            Self::Tool(_) => Some(Quantity::Pose),
            Self::Joints(rows) => rows.has_position_target().then_some(Quantity::JointPosition),
            Self::Raw(_) | Self::Gaze(_) => None,
        }
    }

    /// Returns whether the target of the configuration moves or may jump.
    pub(crate) fn target_moves(&self) -> bool {
        let moves = |profile: &Profile| !profile.is_constant();
        match self {
            Self::Tool(rows) => rows.target_displacement.as_ref().is_some_and(moves),
            Self::Joints(JointRows { target: JointTarget::Position(profile), .. }) => moves(profile),
            Self::Gaze(rows) => moves(rows.target()),
            Self::Joints(_) | Self::Raw(_) => false,
        }
    }

    /// Returns the target of the configuration, at which the streamed poses of laws with a spring start; for other quantities ẋ of the last
    /// period, `velocity` (m).
    pub(crate) fn own_reference(&self, quantity: Quantity, arm: &ArmState, velocity: &[f64]) -> Reference {
        match (quantity, self) {
            (Quantity::Pose, Self::Tool(rows)) => rows.own_reference(arm),
            _ => Reference::at_rest(TargetValue::Rows(TaskVector::from_slice(velocity))),
        }
    }

    /// Overwrites `target` with the target of a position law at a displacement from it (m), without allocating.
    pub(crate) fn write_target(
        &self,
        at: ArmAt,
        streamed: Option<&ActiveStream>,
        displacement: &[f64],
        target: &mut TargetValue,
    ) {
        match (streamed, self) {
            (Some(active), _) => target.copy_from(&active.stream.reference.value),
            (None, Self::Tool(rows)) => *target = rows.own_reference(at.arm).value,
            (None, Self::Joints(rows)) => rows.write_target(at, displacement, target),
            (None, Self::Gaze(rows)) => *target = TargetValue::Rows(rows.target_at(at)),
            // A position law has no raw rows.
            (None, Self::Raw(_)) => {}
        }
    }

    /// Returns the position at a posture with a velocity of the task, m.
    pub(crate) fn actual(&self, velocity: &[f64], at: ArmAt) -> Reference {
        match self {
            Self::Tool(rows) => rows.actual(velocity, at),
            Self::Joints(rows) => rows.actual(velocity, at),
            Self::Raw(_) | Self::Gaze(_) => Reference::at_rest(TargetValue::Rows(TaskVector::from_slice(velocity))),
        }
    }

    /// Returns value and velocity of a streamed target.
    pub(crate) fn target(&self, given: &StreamedTarget, at: ArmAt) -> (TargetValue, Option<TaskVector>) {
        let value = self.target_value(&given.value, at);
        let velocity = given.velocity.as_ref().map(|velocity| match self {
            Self::Tool(rows) => rows.target_velocity(velocity, &value),
            Self::Joints(_) | Self::Raw(_) | Self::Gaze(_) => TaskVector::from_slice(velocity),
        });
        (value, velocity)
    }

    /// Returns the value of a streamed target.
    pub(crate) fn target_value(&self, given: &StreamedValue, at: ArmAt) -> TargetValue {
        match (given, self) {
            (StreamedValue::Pose { position, orientation }, Self::Tool(rows)) => {
                rows.streamed_pose(*position, *orientation, at)
            }
            (StreamedValue::Pose { .. }, _) => TargetValue::Rows(TaskVector::zeros(self.len())),
            (StreamedValue::JointPosition(rows) | StreamedValue::Velocity(rows) | StreamedValue::Force(rows), _) => {
                TargetValue::Rows(TaskVector::from_slice(rows))
            }
        }
    }
}
