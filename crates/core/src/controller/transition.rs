//! Another controller for an arm that moves: tasks are added, removed, reordered or weighted anew without a jump.
//!
//! The new controller continues from the memory of the old one. In the transition, no joint changes its velocity by more than
//! A T in a period, where A is its acceleration limit. Limits that contain accelerations ensure this in every period. For
//! other limits the transition adds accelerations, until the answer without them changes no joint by more.
//!
//! Position limits win over the acceleration limit, as always: the answer names the joint as a limit conflict. A joint
//! without acceleration limit may jump.

use nalgebra::Vector3;
use revprio_robot::kinematics::ConfigurationError;

use super::config::{Controller, ControllerConfig, TaskConfig};
use super::state::{Memory, MemoryError, Progress, fits_task};
use crate::arm_state::ArmAt;
use crate::channel::{ChannelConfig, ChannelState};
use crate::law::{ContactAxis, ContactLaw, ContactPhase};
use crate::resolution::Solver;
use crate::streaming::TargetStream;

/// Cosine of the angle between two pressing directions below which one reverses the other.
const REVERSED: f64 = -0.5;

/// Why a controller cannot continue the motion of another one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TransitionError {
    /// The robots differ.
    #[error("the robot or its tool offset differs from that of the running controller; open another session for it")]
    Robot,
    /// The periods differ.
    #[error("the period {new} s differs from {old} s of the running controller; open another session for it")]
    Period {
        /// T of the running controller, s.
        old: f64,
        /// T of the new controller, s.
        new: f64,
    },
    /// The drives differ.
    #[error("the drive differs from that of the running controller; it belongs to the arm")]
    Drive,
    /// The new controller ignores limits, so nothing bounds its first command.
    #[error("the solver `closed_form` ignores limits, so the command would jump; use `auto` or `qp`")]
    IgnoresLimits,
    /// A contact law reverses its direction while it presses: it would begin behind the surface.
    #[error("the task presses on a surface, and its target force would reverse; let the tool leave the surface first")]
    Reverses {
        /// Index of the task in the new controller.
        task: usize,
    },
    /// The posture does not fit the robot.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
    /// The memory does not fit the old controller.
    #[error(transparent)]
    Memory(#[from] MemoryError),
}

impl Controller {
    /// Returns the memory with which this controller continues the motion of another one.
    ///
    /// `memory` is that of the last step of `previous`, and `joint_position` (n, rad or m) the posture of that step. Laws
    /// that integrate continue from the velocity that the last command gives their task at the position of rest. Streamed
    /// targets and progress stay with the name of their task; another target velocity or force takes the place of the
    /// streamed ones. The initial pose stays: a task without a target holds the pose of the very first step.
    pub fn continue_from(
        &self,
        previous: &Self,
        memory: &Memory,
        joint_position: &[f64],
    ) -> Result<Memory, TransitionError> {
        let (old, new) = (previous.config(), self.config());
        self.check_transition(previous)?;
        memory.check(old)?;
        let to_rest = |joint| memory.drive.distance_to_rest(old.drive, joint, old.period_s);
        let rest: Vec<f64> = joint_position.iter().enumerate().map(|(joint, q)| q + to_rest(joint)).collect();
        let mut arm = new.allocate_arm()?;
        arm.move_to(&rest, memory.last_command.as_slice())?;
        check_directions(memory, old, new, arm.measured())?;
        arm.initial_pose = memory.initial_pose;
        let contacts = kept_contacts(memory, old, new);
        arm.recall_surfaces(|index| contacts.get(index).map(ContactAxis::known).unwrap_or_default());
        let initial = Memory::at_start(new, arm.measured());
        let target_streams = kept_streams(memory, old, new);
        Ok(Memory {
            start_time_s: memory.start_time_s,
            drive: memory.drive.clone(),
            answered: memory.answered.clone(),
            jerk: if new.keeps_jerk() { memory.jerk.clone().or(initial.jerk) } else { None },
            initial_position: memory.initial_position.clone(),
            progress: kept_progress(memory, old, new),
            stalls: memory.stalls.clone(),
            contacts,
            wrench_sensors: if new.wrench_sensors == old.wrench_sensors {
                memory.wrench_sensors.clone()
            } else {
                Vec::new()
            },
            in_transition: new.limits_let_joints_jump(),
            channels: kept_channels(memory, old, new, &target_streams),
            target_streams,
            ..initial
        })
    }

    /// Checks that this controller can continue the motion of another one.
    pub fn check_transition(&self, previous: &Self) -> Result<(), TransitionError> {
        let (old, new) = (previous.config(), self.config());
        if new.robot != old.robot {
            return Err(TransitionError::Robot);
        }
        if new.period_s.to_bits() != old.period_s.to_bits() {
            return Err(TransitionError::Period { old: old.period_s, new: new.period_s });
        }
        if new.drive != old.drive {
            return Err(TransitionError::Drive);
        }
        if new.solver == Solver::ClosedForm { Err(TransitionError::IgnoresLimits) } else { Ok(()) }
    }
}

/// Returns the index of the task with this name.
fn task_index(config: &ControllerConfig, name: &str) -> Option<usize> {
    config.tasks.iter().position(|task| task.name == name)
}

/// Returns the streams of the tasks that stay with the same rows. A target velocity or force that changes takes the place of those that
/// states have brought; the target of a position is one of the rows.
fn kept_streams(memory: &Memory, old: &ControllerConfig, new: &ControllerConfig) -> Vec<TargetStream> {
    let kept = |stream: &TargetStream| {
        let follower = &old.tasks[stream.task];
        let task = task_index(new, &follower.name).filter(|&task| new.tasks[task].rows == follower.rows)?;
        if !stream.quantity.is_position() && new.tasks[task].law.target() != follower.law.target() {
            return None;
        }
        Some(TargetStream { task, ..stream.clone() }).filter(|stream| fits_task(stream, new))
    };
    let mut streams: Vec<_> = memory.target_streams.iter().filter_map(kept).collect();
    streams.sort_by_key(|stream| (stream.task, stream.quantity));
    streams
}

/// Returns the channels that stay with their names and kinds, and new ones: newtons are no metres. A target that changes takes the
/// place of those that states have brought, and the targets to come end with the last chunk. `streams`: those that stay.
fn kept_channels(
    memory: &Memory,
    old: &ControllerConfig,
    new: &ControllerConfig,
    streams: &[TargetStream],
) -> Vec<ChannelState> {
    let has_chunk = |streams: &[TargetStream]| streams.iter().any(TargetStream::has_chunk);
    let has_lost_chunks = has_chunk(&memory.target_streams) && !has_chunk(streams);
    let stays_from_s = memory.answered.as_ref().map(|answered| answered.time_s).filter(|_| has_lost_chunks);
    let kept = |new: &ChannelConfig| {
        let is_same = |old: &ChannelConfig| old.name == new.name && old.kind == new.kind;
        let index = old.channels.iter().position(is_same)?;
        let mut state = memory.channels.get(index)?.clone();
        if new.target != old.channels[index].target {
            state.targets.clear();
        }
        if let Some(time_s) = stays_from_s {
            state.stay(time_s);
        }
        Some(state)
    };
    new.channels.iter().map(|channel| kept(channel).unwrap_or_default()).collect()
}

/// Returns the contact law of the old task with the name and the rows of a new one, and its contacts.
fn contact_before<'a>(
    memory: &'a Memory,
    old: &'a ControllerConfig,
    task: &TaskConfig,
) -> Option<(&'a ContactLaw, &'a [ContactAxis])> {
    let same = task_index(old, &task.name).filter(|&k| old.tasks[k].rows == task.rows)?;
    Some((old.tasks[same].law.contact()?, old.contacts_of(same, &memory.contacts)?))
}

/// Checks that no contact law presses against the direction in which its tip presses now, whatever the names and the frames of the tasks.
fn check_directions(
    memory: &Memory,
    old: &ControllerConfig,
    new: &ControllerConfig,
    at: ArmAt,
) -> Result<(), TransitionError> {
    let mut pressing = Vec::new();
    for (task, config) in old.tasks.iter().enumerate() {
        let Some(law) = config.law.contact() else { continue };
        for (row, axis) in old.contacts_of(task, &memory.contacts).unwrap_or_default().iter().enumerate() {
            if axis.presses(&law.axes()[row]) {
                pressing.extend(Direction::of(old, (task, row), at).map(|stated| stated.turned_to(axis.normal.normal)));
            }
        }
    }
    for (task, config) in new.tasks.iter().enumerate() {
        let rows = config.law.contact().map_or(0, ContactLaw::rows);
        let mut directions = (0..rows).filter_map(|row| Direction::of(new, (task, row), at));
        if directions.any(|direction| pressing.iter().any(|now| direction.reverses(now))) {
            return Err(TransitionError::Reverses { task });
        }
    }
    Ok(())
}

/// A direction in which a tip presses.
struct Direction {
    tip: Option<usize>,
    is_angular: Option<bool>,
    /// A unit vector, axes of the base.
    vector: Vector3<f64>,
}

impl Direction {
    /// Returns the pressing direction of a row; `None`: it presses on nothing.
    fn of(config: &ControllerConfig, (task, row): (usize, usize), at: ArmAt) -> Option<Self> {
        let TaskConfig { rows, law, .. } = &config.tasks[task];
        let vector = law.contact()?.direction(row) * rows.direction(row, at)?;
        Some(Self { tip: rows.tip(&config.robot), is_angular: rows.is_angular(row, &config.robot), vector })
    }

    /// Returns the direction along the normal of the surface that the row follows; zero: it follows none, or does not know it yet.
    fn turned_to(self, normal: Vector3<f64>) -> Self {
        if normal == Vector3::zeros() { self } else { Self { vector: normal, ..self } }
    }

    fn reverses(&self, other: &Self) -> bool {
        self.tip == other.tip && self.is_angular == other.is_angular && self.vector.dot(&other.vector) < REVERSED
    }
}

/// Returns the contacts of the tasks that stay with their name, their rows and the contact law; others start. A fault ends: who
/// replaces the controller has seen it.
fn kept_contacts(memory: &Memory, old: &ControllerConfig, new: &ControllerConfig) -> Vec<ContactAxis> {
    let mut contacts = Vec::new();
    for task in &new.tasks {
        let Some(law) = task.law.contact() else { continue };
        let before = contact_before(memory, old, task);
        for row in 0..task.rows.len() {
            // The memory is along the pressing direction, which may be that of a surface.
            let is_along_it = |before: &ContactLaw| {
                before.direction(row) == law.direction(row) && before.surface().is_some() == law.surface().is_some()
            };
            let axis =
                before.filter(|(before, _)| is_along_it(before)).map_or(ContactAxis::START, |(_, axes)| axes[row]);
            let is_fault = matches!(axis.phase, ContactPhase::Fault(_));
            contacts.push(if is_fault { ContactAxis::START } else { axis });
        }
    }
    contacts
}

/// Returns the progress of the tasks that stay, and that of new tasks. A motion that leaves a posture ends: nobody has asked the new
/// controller for it.
fn kept_progress(memory: &Memory, old: &ControllerConfig, new: &ControllerConfig) -> Vec<Progress> {
    let known = |name: &str| memory.progress.get(task_index(old, name)?);
    let ended = |progress: &Progress| match *progress {
        Progress { leaving_since_s: Some(_), attempts, left_at, .. } => {
            Progress { attempts, left_at, ..Progress::FREE }
        }
        followed => followed,
    };
    new.tasks.iter().map(|task| known(&task.name).map_or(Progress::FREE, ended)).collect()
}
