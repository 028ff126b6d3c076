//! The memory of a controller: its state from period to period.

use nalgebra::IsometryMatrix3;

use super::answered_state::AnsweredState;
use super::jerk_state::JerkState;
use super::progress::Progress;
use super::rest::RestState;
use super::stall::Stall;
use super::virtual_arm::VirtualArm;
use crate::arm_state::ArmAt;
use crate::channel::ChannelState;
use crate::controller::config::{ControllerConfig, TaskConfig};
use crate::law::ContactAxis;
use crate::limits::DriveState;
use crate::linalg::{Vector, all_finite};
use crate::resolution::{ActiveSet, Bound, BoundId};
use crate::streaming::{
    Chunk, Fade, MAX_KEPT_ACTIONS, MAX_TARGETS_AHEAD, MIN_INTERVAL, Quantity, Target, TargetStream, TargetValue,
};
use crate::wrench::SensorState;

/// Time above which a clock counts from the year 1970, s, and no profile does: the year 2001.
pub const UNIX_TIME_S: f64 = 1e9;

/// The complete state of a controller. Another process with the same
/// controller can continue from it and computes the same commands, to the last bit.
#[derive(Debug, Clone, PartialEq)]
pub struct Memory {
    /// ẋ in the integrator of each task, m_k each, m/s and rad/s.
    pub task_velocities: Vec<Vector>,
    /// The time from which profiles count, s: that of the first step if it is above 10⁹ s, otherwise 0.
    pub start_time_s: f64,
    /// Tool pose at the first step, base frame, m.
    pub initial_pose: IsometryMatrix3<f64>,
    /// q at the first step, n, rad or m; `None`: unknown, then the next step sets it.
    pub initial_position: Option<Vector>,
    /// q̇ of the last command, n, rad/s or m/s.
    pub last_command: Vector,
    /// The commands that the drive still has to follow.
    pub drive: DriveState,
    /// The state that the last command answers; `None`: unknown, then the next state counts as one period later.
    pub answered: Option<AnsweredState>,
    /// What joints with a jerk limit remember; `None`: they have moved at a constant velocity.
    pub jerk: Option<JerkState>,
    /// Active limits of the last command, per level.
    pub active_set: Vec<ActiveSet>,
    /// Streams of targets, in the order of tasks and quantities; empty if no target was streamed.
    pub target_streams: Vec<TargetStream>,
    /// How each task follows its requests; empty: all follow.
    pub progress: Vec<Progress>,
    /// How each joint follows its commands, n; empty: all follow.
    pub stalls: Vec<Stall>,
    /// How the joints turn and what the tasks gained by it; `None`: the next step starts anew.
    pub rest: Option<RestState>,
    /// The virtual arm; `None`: no law looks ahead, or the next step starts from the arm.
    pub virtual_arm: Option<VirtualArm>,
    /// What the contact law remembers, per axis, in the order of the tasks; empty: the next step starts.
    pub contacts: Vec<ContactAxis>,
    /// Whether the controller replaces another one and still limits accelerations for that.
    pub in_transition: bool,
    /// What the wrench sensors remember, in the order of the controller; empty: they start.
    pub wrench_sensors: Vec<SensorState>,
    /// The channels of the controller, in their order; empty: no command was given.
    pub channels: Vec<ChannelState>,
}

/// Why a memory is refused: it belongs to another controller or is damaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MemoryError {
    /// The task velocities do not fit the tasks.
    #[error("the memory's task velocities do not fit the tasks; send back the memory of this controller's last answer")]
    TaskVelocities,
    /// The initial position does not fit the robot.
    #[error(
        "the memory's initial position does not fit the robot; send back the memory of this controller's last answer"
    )]
    InitialPosition,
    /// The progress does not fit the tasks.
    #[error("the memory's progress does not fit the tasks; send back the memory of this controller's last answer")]
    Progress,
    /// The state of rest does not fit the controller.
    #[error(
        "the memory's state of rest does not fit the controller; send back the memory of this controller's last answer"
    )]
    Rest,
    /// The virtual arm does not fit the robot.
    #[error("the memory's virtual arm does not fit the robot; send back the memory of this controller's last answer")]
    VirtualArm,
    /// The contacts do not fit the tasks.
    #[error("the memory's contacts do not fit the tasks; send back the memory of this controller's last answer")]
    Contacts,
    /// The wrench sensors do not fit the controller.
    #[error(
        "the memory's wrench sensors do not fit the controller; send back the memory of this controller's last answer"
    )]
    WrenchSensors,
    /// The stalls do not fit the robot.
    #[error("the memory's stalls do not fit the robot; send back the memory of this controller's last answer")]
    Stalls,
    /// The last command does not fit the robot.
    #[error("the memory's last command does not fit the robot; send back the memory of this controller's last answer")]
    LastCommand,
    /// The state of the drive does not fit the robot or the drive.
    #[error("the memory's drive does not fit the controller; send back the memory of this controller's last answer")]
    Drive,
    /// The last state does not fit the robot.
    #[error("the memory's last state does not fit the robot; send back the memory of this controller's last answer")]
    AnsweredState,
    /// The state of the jerk limits does not fit the robot.
    #[error("the memory's jerk state does not fit the robot; send back the memory of this controller's last answer")]
    Jerk,
    /// The active set names a joint, an inequality or a row of a task that the controller does not have.
    #[error(
        "the memory's active set does not fit the controller; send back the memory of this controller's last answer"
    )]
    ActiveSet,
    /// The channels do not fit the controller.
    #[error("the memory's channels do not fit the controller; send back the memory of this controller's last answer")]
    Channels,
    /// A stream of targets does not fit the tasks.
    #[error("the memory's targets do not fit the tasks; send back the memory of this controller's last answer")]
    Targets,
}

impl Memory {
    /// Returns the memory for the first step: integrators and last command equal the measured motion of an arm.
    pub(in crate::controller) fn at_start(config: &ControllerConfig, at: ArmAt) -> Self {
        let velocity = Vector::from_row_slice(&at.arm.joint_velocity);
        Self {
            task_velocities: config.tasks.iter().map(|task| task.rows.velocity(at).to_vector()).collect(),
            start_time_s: if at.arm.time_s > UNIX_TIME_S { at.arm.time_s } else { 0.0 },
            initial_pose: at.arm.initial_pose,
            drive: DriveState::moving(config.drive, &velocity),
            answered: None,
            jerk: config.keeps_jerk().then(|| JerkState::moving(&velocity)),
            last_command: velocity,
            active_set: Vec::new(),
            target_streams: Vec::new(),
            initial_position: None,
            progress: Vec::new(),
            stalls: Vec::new(),
            rest: None,
            virtual_arm: None,
            contacts: Vec::new(),
            wrench_sensors: Vec::new(),
            in_transition: false,
            channels: Vec::new(),
        }
    }

    /// Checks that the memory fits the controller.
    pub(in crate::controller) fn check(&self, config: &ControllerConfig) -> Result<(), MemoryError> {
        let n = config.robot.joint_count();
        let finite = |v: &Vector| all_finite(v.as_slice());
        let fits = |(velocity, task): (&Vector, &TaskConfig)| velocity.len() == task.rows.len() && finite(velocity);
        if self.task_velocities.len() != config.tasks.len() || !self.task_velocities.iter().zip(&config.tasks).all(fits)
        {
            return Err(MemoryError::TaskVelocities);
        }
        if self.last_command.len() != n || !finite(&self.last_command) || !self.start_time_s.is_finite() {
            return Err(MemoryError::LastCommand);
        }
        let DriveState { velocity, pending } = &self.drive;
        let mut drive = pending.iter().chain([velocity]);
        if pending.len() != config.drive.delay_periods || !drive.all(|v| v.len() == n && finite(v)) {
            return Err(MemoryError::Drive);
        }
        let fits = |state: &AnsweredState| {
            let mut vectors = state.way.iter().chain([&state.joint_position]);
            let stops = state.stop_time_s.is_none_or(|time| time > 0.0 && time.is_finite());
            stops && state.time_s.is_finite() && vectors.all(|v| v.len() == n && finite(v))
        };
        if !self.answered.as_ref().is_none_or(fits) {
            return Err(MemoryError::AnsweredState);
        }
        let mut jerk = self.jerk.iter().flat_map(|JerkState { acceleration, requested }| [acceleration, requested]);
        if !jerk.all(|v| v.len() == n && finite(v)) {
            return Err(MemoryError::Jerk);
        }
        if !self.initial_position.as_ref().is_none_or(|position| position.len() == n && finite(position)) {
            return Err(MemoryError::InitialPosition);
        }
        let count = self.progress.len();
        if (count != 0 && count != config.tasks.len()) || !self.progress.iter().all(Progress::is_valid) {
            return Err(MemoryError::Progress);
        }
        if !self.rest.as_ref().is_none_or(|rest| rest.is_valid(n, config.tasks.len())) {
            return Err(MemoryError::Rest);
        }
        if !self.virtual_arm.as_ref().is_none_or(|arm| arm.is_valid(n, target_rows(config))) {
            return Err(MemoryError::VirtualArm);
        }
        let count = self.channels.len();
        if (count != 0 && count != config.channels.len()) || !self.channels.iter().all(ChannelState::is_valid) {
            return Err(MemoryError::Channels);
        }
        let count = self.contacts.len();
        if (count != 0 && count != config.contact_axes()) || !self.contacts.iter().all(ContactAxis::is_valid) {
            return Err(MemoryError::Contacts);
        }
        let count = self.wrench_sensors.len();
        if (count != 0 && count != config.wrench_sensors.len())
            || !self.wrench_sensors.iter().all(SensorState::is_valid)
        {
            return Err(MemoryError::WrenchSensors);
        }
        let count = self.stalls.len();
        if (count != 0 && count != n) || !self.stalls.iter().all(Stall::is_valid) {
            return Err(MemoryError::Stalls);
        }
        // The solver writes each bound once, in ascending order.
        let ordered = |set: &ActiveSet| set.windows(2).all(|pair| pair[0].id < pair[1].id);
        let is_bounded = |bound: &Bound| match bound.id {
            BoundId::Joint(joint) => joint < n,
            BoundId::Constraint { index, row } => {
                config.constraints.get(index).is_some_and(|constraint| row < constraint.row_count())
            }
            BoundId::Task { index, row } => {
                config.tasks.get(index).is_some_and(|task| row < task.rows.len() && task.law.bounds().is_some())
            }
        };
        if !self.active_set.iter().all(|set| ordered(set) && set.iter().all(is_bounded)) {
            return Err(MemoryError::ActiveSet);
        }
        let ascending = self.target_streams.windows(2).all(|pair| key(&pair[0]) < key(&pair[1]));
        if ascending && self.target_streams.iter().all(|stream| fits_task(stream, config)) {
            Ok(())
        } else {
            Err(MemoryError::Targets)
        }
    }
}

/// Returns the number of rows of all tasks with targets.
fn target_rows(config: &ControllerConfig) -> usize {
    config.tasks.iter().filter(|task| task.law.bounds().is_none()).map(|task| task.rows.len()).sum()
}

fn key(stream: &TargetStream) -> (usize, Quantity) {
    (stream.task, stream.quantity)
}

/// Returns whether the values of a stream fit its task.
pub(in crate::controller) fn fits_task(stream: &TargetStream, config: &ControllerConfig) -> bool {
    let Some(task) = config.tasks.get(stream.task) else { return false };
    let is_pose = stream.quantity == Quantity::Pose;
    let entries = if is_pose { 6 } else { task.rows.len() };
    let fits_value = |value: &TargetValue| {
        matches!(value, TargetValue::Pose(_)) == is_pose && value.len() == entries && value.is_valid()
    };
    let fits_velocity = |velocity: &[f64]| velocity.len() == entries && velocity.iter().all(|entry| entry.is_finite());
    let fits = |target: &Target| {
        target.time_s.is_finite() && fits_value(&target.value) && target.velocity.as_deref().is_none_or(fits_velocity)
    };
    let in_order = match (&stream.previous, &stream.newest) {
        (Some(previous), Some(newest)) => newest.time_s - previous.time_s >= MIN_INTERVAL,
        (Some(_), None) => false,
        (None, _) => true,
    };
    task.accepts(stream.quantity)
        && stream.previous.iter().chain(&stream.newest).all(fits)
        && in_order
        && stream.ahead.windows(2).all(|pair| pair[1].time_s - pair[0].time_s > 0.0)
        && stream.ahead.iter().all(|later| later.time_s.is_finite() && fits_value(&later.value))
        && stream
            .ahead
            .first()
            .is_none_or(|first| stream.newest.as_ref().is_some_and(|newest| first.time_s > newest.time_s))
        && stream.ahead.len() <= MAX_TARGETS_AHEAD
        && fits_chunk(&stream.chunk, fits_value, fits_velocity)
        && (stream.chunk.actions.is_empty() || stream.newest.is_some())
        && fits_value(&stream.reference.value)
        && fits_velocity(&stream.reference.velocity)
}

/// Returns whether the actions of a chunk are in order, and their values and what fades fit a task.
fn fits_chunk(chunk: &Chunk, fits_value: impl Fn(&TargetValue) -> bool, fits_entries: impl Fn(&[f64]) -> bool) -> bool {
    let Chunk { actions, merged_s, first_s, fade } = chunk;
    let fits_fade = |fade: &Fade| {
        let is_time = fade.start_s.is_finite() && fade.duration_s.is_finite() && fade.duration_s > 0.0;
        is_time && [&fade.offset, &fade.rate, &fade.acceleration].into_iter().all(|entries| fits_entries(entries))
    };
    merged_s.is_finite()
        && first_s.is_none_or(f64::is_finite)
        && actions.len() <= MAX_KEPT_ACTIONS
        && actions.iter().all(|action| action.time_s.is_finite() && fits_value(&action.value))
        && actions.windows(2).all(|pair| pair[1].time_s - pair[0].time_s > 0.0)
        && fade.as_ref().is_none_or(fits_fade)
}
