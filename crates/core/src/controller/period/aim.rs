//! The second step: what the tasks wish.

mod braking;
mod channels;
mod contacts;
mod gains;
mod look_ahead;
mod null_space;
mod streams;

pub use self::braking::BRAKING_SHARE;
use self::braking::RequestBounds;
pub(super) use self::contacts::{Contacts, PressingAxis};
pub(super) use self::gains::Gains;
use self::look_ahead::{LookAhead, Scene};
use crate::arm_state::ArmState;
use crate::channel::ChannelState;
use crate::constraint;
use crate::controller::config::{ControllerConfig, TaskConfig};
use crate::controller::state::{ANGULAR_REACHED, Measurement, Memory, REACHED, TaskTarget, VirtualArm};
use crate::law::{Law, TargetForce, TaskState, TaskVector};
use crate::linalg::{Matrix, Vector, row_times};
use crate::resolution::Problem;
use crate::streaming::{ActiveStream, Quantity, TargetValue, TaskStreams};
use crate::task::{Task, TaskError, TaskStack};

/// What the tasks wish in one period.
pub(super) struct Wishes<'a> {
    /// The problem, as far as the tasks state it: their weighed Jacobians at the posture of rest with a velocity or two bounds per
    /// row, and the null-space velocity. The next steps add what is allowed.
    pub problem: &'a mut Problem,
    /// What the tasks follow.
    pub requests: Requests<'a>,
}

/// What the tasks follow in one period.
#[derive(Debug, Clone, Copy)]
pub(super) struct Requests<'a> {
    /// The target of each task.
    pub targets: &'a [TaskTarget],
    /// Whether a joint moves each row of each task at some posture.
    pub moved: &'a [Vec<bool>],
    /// The streams of targets.
    pub streams: &'a [ActiveStream],
    /// The axes with the contact law.
    pub contacts: &'a Contacts,
    /// What the tasks gain.
    pub gains: &'a Gains,
    /// s, the share of all requests that remains.
    pub share: f64,
    /// The virtual arm; `None`: no law looks ahead.
    pub virtual_arm: Option<&'a VirtualArm>,
    /// The channels besides the joints.
    pub channels: &'a [ChannelState],
}

/// The memory of this step.
#[derive(Debug)]
pub(super) struct Aiming {
    problem: Problem,
    targets: Vec<TaskTarget>,
    streams: Vec<ActiveStream>,
    bounds: RequestBounds,
    /// Whether a joint moves each row of each task at some posture.
    moved: Vec<Vec<bool>>,
    gains: Gains,
    contacts: Contacts,
    look_ahead: Option<LookAhead>,
    channels: Vec<ChannelState>,
}

impl Aiming {
    /// Allocates the rows of all tasks and constraints of a checked configuration; `moved`: its [`ControllerConfig::moved_rows`].
    pub fn new(config: &ControllerConfig, moved: Vec<Vec<bool>>) -> Result<Self, TaskError> {
        let n = config.robot.joint_count();
        let tasks = TaskStack::new(config.tasks.iter().map(|task| empty_task(task, n)).collect())?;
        let target = |task: &Task| TaskTarget { velocity: Vector::zeros(task.lower.len()), ..TaskTarget::default() };
        Ok(Self {
            targets: tasks.tasks().iter().map(target).collect(),
            problem: Problem {
                inequalities: constraint::allocate(&config.constraints, n),
                method: config.method,
                damping: config.fading_damping(),
                null_space_velocity: config.moves_null_space().then(|| Vector::zeros(n)),
                ..Problem::new(tasks)
            },
            streams: Vec::new(),
            bounds: RequestBounds::new(config),
            moved,
            gains: Gains::default(),
            contacts: Contacts::new(config),
            look_ahead: LookAhead::new(config),
            channels: config.channels.iter().map(|_| ChannelState::default()).collect(),
        })
    }

    /// Returns the targets of the last period; before the first one, those of tasks that rest.
    pub fn targets(&self) -> &[TaskTarget] {
        &self.targets
    }
}

/// Returns a task over n joints whose rows a period overwrites.
fn empty_task(task: &TaskConfig, n: usize) -> Task {
    let (name, jacobian) = (task.name.clone(), Matrix::zeros(task.rows.len(), n));
    let empty = match task.law.bounds() {
        Some(bounds) => Task::between(name, jacobian, bounds.lower().clone(), bounds.upper().clone()),
        None => Task::new(name, jacobian, Vector::zeros(task.rows.len())),
    };
    Task { scaled: task.scaled, ..empty }
}

/// Returns the wishes of a period.
pub(super) fn aim<'a>(
    config: &ControllerConfig,
    arm: &ArmState,
    previous: &Memory,
    measurement: &Measurement,
    Aiming { problem, targets, streams, bounds, moved, gains, contacts, look_ahead, channels }: &'a mut Aiming,
) -> Result<Wishes<'a>, TaskError> {
    let Problem { tasks, null_space_velocity, damping, .. } = &mut *problem;
    let unused = streams::update(streams, previous, (&measurement.targets, &measurement.chunks), arm, config);
    channels::update(channels, previous, measurement, streams, (arm, config));
    tasks.overwrite_jacobians(|k, jacobian| write_jacobian(k, &moved[k], (config, arm), jacobian))?;
    bounds.start_period();
    gains.start(previous.rest.as_ref(), config.tasks.len());
    contacts.start_period(config, arm, previous, tasks);
    for (k, target) in targets.iter_mut().enumerate() {
        evaluate_law(k, target, (bounds, gains, contacts), (config, arm, previous), (tasks, streams));
    }
    for (k, target) in targets.iter_mut().enumerate() {
        target.unused = unused.iter().find(|(task, _)| *task == k).map(|(_, ignored)| *ignored);
    }
    contacts.slide_slowly(config, targets);
    contacts.give_way_to_a_retreat(config, targets, tasks)?;
    match null_space_velocity {
        // An operator who lost the link expects an arm that rests.
        Some(velocity) if streams::have_dropped_out(streams) => velocity.fill(0.0),
        Some(velocity) => null_space::write(velocity, targets, bounds, (config, arm, previous), (tasks, moved)),
        None => {}
    }
    if let (Some(look_ahead), Some(velocity)) = (&mut *look_ahead, null_space_velocity.as_mut()) {
        look_ahead.smooth(streams, previous, config.period_s);
        let follows = follow_ahead(look_ahead, (targets, velocity), (config, arm, previous), (tasks, streams));
        // Joints that follow the virtual arm ask for velocities that they can have, also at a singularity.
        *damping = if follows { None } else { config.fading_damping() };
    }
    let share = fade(config, arm, previous, gains, (targets, null_space_velocity.as_mut()));
    tasks.overwrite(|k, _, lower, upper| {
        let TaskTarget { velocity, released_by, .. } = &targets[k];
        let (least, greatest) =
            config.tasks[k].law.bounds().map_or((velocity, velocity), |bounds| (bounds.lower(), bounds.upper()));
        lower.copy_from_slice(&config.weighed(k, least.as_slice()));
        upper.copy_from_slice(&config.weighed(k, greatest.as_slice()));
        if released_by.is_some() && config.tasks[k].law.bounds().is_some() {
            // Rows that are zero keep them.
            lower.iter_mut().for_each(|bound| *bound = bound.min(0.0));
            upper.iter_mut().for_each(|bound| *bound = bound.max(0.0));
        }
    })?;
    let virtual_arm = look_ahead.as_ref().map(LookAhead::virtual_arm);
    let requests = Requests { targets, moved, streams, contacts, gains, share, virtual_arm, channels };
    Ok(Wishes { problem, requests })
}

/// Writes the weighed Jacobian of task `k` at the posture of rest. Rows that no joint moves at any posture, `moved`, are zero: what rounding
/// leaves of them is no motion.
pub(super) fn write_jacobian(
    k: usize,
    moved: &[bool],
    (config, arm): (&ControllerConfig, &ArmState),
    jacobian: &mut Matrix,
) {
    config.tasks[k].rows.write_jacobian(arm.at_rest(), jacobian);
    config.weigh_jacobian(k, jacobian);
    for (row, _) in moved.iter().enumerate().filter(|(_, moved)| !**moved) {
        jacobian.row_mut(row).fill(0.0);
    }
}

/// Computes the target of task `k` by its law, bounded by what the joints can give. `tasks`: with the Jacobians of this period.
fn evaluate_law(
    k: usize,
    target: &mut TaskTarget,
    (bounds, gains, contacts): (&mut RequestBounds, &mut Gains, &mut Contacts),
    (config, arm, previous): (&ControllerConfig, &ArmState, &Memory),
    (tasks, streams): (&TaskStack, &[ActiveStream]),
) {
    let (task, integrator) = (&config.tasks[k], previous.task_velocities[k].as_slice());
    let streams = TaskStreams::of(streams, k);
    let state = task_state(task, arm, streams);
    if matches!(task.law, Law::Position(_)) {
        let write = |target: &mut TargetValue| {
            task.rows.write_target(arm.at_rest(), streams.position, &state.displacement, target);
        };
        gains.add(k, &state.displacement, write);
    }
    let velocity = task.law.velocity(&state, integrator, config.period_s);
    let mut velocity = bounds.bounded(k, (config, &arm.capability), tasks, &state, velocity);
    let mut force = task.law.target_force(arm.profile_time(arm.time_s));
    if let Some(streamed) = streams.values() {
        force.iter_mut().zip(streamed.iter()).for_each(|(force, value)| *force = force.map(|_| *value));
    }
    if let Law::Contact(law) = &task.law {
        let terms = (law, &state, integrator);
        contacts.press(k, terms, &mut force, (config, arm, tasks, bounds), (&mut velocity, &mut target.contact));
    }
    if streams.force_brakes() {
        let max_change = |row| task.bound(Quantity::Force, row, &arm.robot).acceleration * config.period_s;
        // A contact goes on with the last force, and a retreat with its retreat: only what moves freely brakes.
        let is_held = |row: usize| target.contact.get(row).is_some_and(|report| report.phase.touches());
        brake_forces(&mut velocity, (&force, integrator), max_change, is_held);
    }
    target.velocity.copy_from_slice(&velocity);
    target.force.clear();
    target.force.extend(force);
    target.streamed = streams.report(arm.time_s);
}

/// Replaces a share of the requests by those of joints that follow the virtual arm, u: J_k u for each task, and u in their null space.
///
/// Returns whether the joints follow the virtual arm alone. The requests stay those of the laws if the virtual arm jumps, if the arm leaves a posture, or if targets fail to come.
fn follow_ahead(
    look_ahead: &mut LookAhead,
    (targets, null_space_velocity): (&mut [TaskTarget], &mut Vector),
    (config, arm, previous): (&ControllerConfig, &ArmState, &Memory),
    (tasks, streams): (&TaskStack, &[ActiveStream]),
) -> bool {
    let scene = Scene { config, arm, previous, streams };
    let leaves = previous.progress.iter().any(|progress| progress.is_leaving(arm.time_s));
    if leaves || streams::have_dropped_out(streams) {
        look_ahead.stand(scene);
        return false;
    }
    let Some((velocity, share)) = look_ahead.update(scene) else { return false };
    for (k, (target, task)) in targets.iter_mut().zip(tasks.tasks()).enumerate() {
        if task.is_equation() {
            for (row, speed) in target.velocity.iter_mut().enumerate() {
                let wished = row_times(&task.jacobian, row, velocity.as_slice()) / config.weight(k, row);
                *speed += share * (wished - *speed);
            }
        }
    }
    *null_space_velocity *= 1.0 - share;
    null_space_velocity.axpy(share, velocity, 1.0);
    share >= 1.0
}

/// Scales all requests by s of [`RestState`](crate::controller::state::RestState); returns s. A motion that leaves a posture is not
/// scaled: it ends by itself.
fn fade(
    config: &ControllerConfig,
    arm: &ArmState,
    previous: &Memory,
    gains: &Gains,
    (targets, null_space_velocity): (&mut [TaskTarget], Option<&mut Vector>),
) -> f64 {
    let leaves = previous.progress.iter().any(|progress| progress.is_leaving(arm.time_s));
    let share = match &previous.rest {
        Some(rest) if config.comes_to_rest() && !gains.has_new_target && !leaves => rest.share(),
        _ => 1.0,
    };
    for (k, target) in targets.iter_mut().enumerate() {
        target.is_short = share < 1.0 && is_short(config, k, &target.velocity);
    }
    if share < 1.0 {
        for target in targets {
            target.velocity *= share;
        }
        if let Some(velocity) = null_space_velocity {
            *velocity *= share;
        }
    }
    share
}

/// Returns whether a task that follows a position requests more than one that has reached its target.
fn is_short(config: &ControllerConfig, k: usize, velocity: &Vector) -> bool {
    let task = &config.tasks[k];
    let square = |angular: bool| {
        let is_of_unit = |row: &usize| task.rows.is_angular(*row, &config.robot).unwrap_or(true) == angular;
        (0..velocity.len()).filter(is_of_unit).map(|row| velocity[row] * velocity[row]).sum::<f64>()
    };
    task.law.follows_position()
        && (square(false) > REACHED * REACHED || square(true) > ANGULAR_REACHED * ANGULAR_REACHED)
}

/// Returns the state for the law of a task. A velocity law reads the time and streamed values alone.
///
/// A position law sees the arm at p, and the target at the time when the arm is there.
fn task_state(task: &TaskConfig, arm: &ArmState, streams: TaskStreams) -> TaskState {
    let streamed = streams.values().cloned();
    if task.law.follows_velocity() {
        return TaskState { time_s: arm.profile_time(arm.time_s), streamed, ..TaskState::default() };
    }
    let sees_rest = matches!(task.law, Law::Position(_));
    let at = if sees_rest { arm.at_rest() } else { arm.measured() };
    let mut state = TaskState { streamed, ..task.rows.state(at, streams.position) };
    // Not even the sign of a zero changes without a drive.
    if sees_rest && arm.time_to_rest > 0.0 {
        for (displacement, velocity) in state.displacement.iter_mut().zip(state.target_velocity.iter()) {
            *displacement -= velocity * arm.time_to_rest;
        }
    }
    state
}

/// Replaces the velocity ẋ of force-controlled rows by one that brakes, except in rows that a contact holds. `max_change`: of a row in a
/// period.
fn brake_forces(
    velocity: &mut TaskVector,
    (force, integrator): (&TargetForce, &[f64]),
    max_change: impl Fn(usize) -> f64,
    is_held: impl Fn(usize) -> bool,
) {
    for (row, velocity) in velocity.iter_mut().enumerate().filter(|(row, _)| force[*row].is_some() && !is_held(*row)) {
        let change = max_change(row);
        *velocity = integrator[row] - integrator[row].clamp(-change, change);
    }
}
