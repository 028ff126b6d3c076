//! The `why` of an answer: sentences that say what restricts the joint velocities, and what the tasks give up.

use std::sync::Arc;

use revprio_api::wire;
use revprio_core::controller::{Command, ControllerConfig, Limits, Measurement, StuckTask, TaskConfig};
use revprio_core::law::{ContactPhase, ContactReport};
use revprio_core::limits::BoundCause;
use revprio_core::resolution::{ActiveBound, Resolution, Side, Status, TaskOutcome};
use revprio_lab::number::significant;
use revprio_robot::RobotModel;

use super::constraint_names::ConstraintNames;

/// Distance beyond an end of a range that is rounding, rad or m.
const ROUNDED: f64 = 1e-9;

/// Distance from the end of its range at which a joint is there, rad or m, if it can move no faster than [`SLOW`] towards it.
const RANGE_END: f64 = 0.02;

/// Speed at which a joint has all but stopped, rad/s or m/s.
const SLOW: f64 = 0.05;

/// Smallest velocity that a task gives up, m/s or rad/s.
const MIN_GIVEN_UP: f64 = 1e-4;

/// Smallest part of its speed that a scaled task gives up.
const MIN_SCALED: f64 = 1e-4;

/// Smallest part of its target force that a contact misses, and the smallest force, N and N·m: less is the noise of the sensor.
const MISSING_PART: f64 = 0.1;
const MISSING_FORCE: f64 = 1.0;
const MISSING_TORQUE: f64 = 0.1;

/// The unit of a row of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// m/s.
    Metres,
    /// rad/s.
    Radians,
    /// A row of a given Jacobian.
    Unknown,
}

impl Unit {
    /// Returns the unit of an axis of the tool.
    pub fn of_axis(axis: wire::Axis) -> Self {
        match axis {
            wire::Axis::X | wire::Axis::Y | wire::Axis::Z => Self::Metres,
            wire::Axis::Rx | wire::Axis::Ry | wire::Axis::Rz => Self::Radians,
        }
    }

    const ALL: [Self; 3] = [Self::Metres, Self::Radians, Self::Unknown];

    fn velocity(self) -> &'static str {
        match self {
            Self::Metres => "m/s",
            Self::Radians => "rad/s",
            Self::Unknown => "m/s or rad/s",
        }
    }
}

/// A task of the sentences.
pub struct NamedTask<'a> {
    /// Name.
    pub name: &'a str,
    /// Requested velocity; for a task with bounds the allowed one nearest to the achieved one.
    pub requested: Vec<f64>,
    /// Units of the rows.
    pub units: Vec<Unit>,
    /// Whether it moves joints to a posture.
    pub is_posture: bool,
    /// The axes of a law `contact`.
    pub contacts: &'a [ContactReport],
    /// The task whose retreat releases it; `None`: none does.
    pub released_by: Option<&'a str>,
}

/// What is said where `collisions.violated` is true.
const TOO_NEAR: &str = "on its way to a stop the arm comes nearer to a shape than `min_distance_m`: something comes towards it, it was nearer \
     before, or its limits permit nothing else";

/// A resolution with the names and limits of its sentences.
pub struct Explained<'a> {
    /// The resolution.
    pub resolution: &'a Resolution,
    /// Names of the joints, n.
    pub joints: Vec<&'a str>,
    /// Names of the inequalities.
    pub inequalities: ConstraintNames<'a>,
    /// A link and what it would come too near to.
    pub held_by: Option<&'a [Arc<str>; 2]>,
    /// Whether the arm comes nearer to a shape than the smallest distance, although it avoids it.
    pub comes_too_near: bool,
    /// The robot, if known.
    pub robot: Option<&'a RobotModel>,
    /// Joint position, n, if position limits apply.
    pub position: Option<&'a [f64]>,
    /// The limit that sets each active limit of a joint, in their order.
    pub causes: Vec<BoundCause>,
    /// Whether jerk limits apply.
    pub keeps_jerk: bool,
    /// Threshold of the damping, if there is damping.
    pub threshold: Option<f64>,
    /// Joints whose acceleration or jerk limit is not kept.
    pub conflicts: &'a [usize],
    /// Tasks, highest priority first.
    pub tasks: Vec<NamedTask<'a>>,
    /// The share of what the tasks ask for that is passed on.
    pub request_share: f64,
}

/// Returns the sentences about the command for a measurement.
pub fn why_of_step(config: &ControllerConfig, command: &Command, measurement: &Measurement) -> Vec<String> {
    let unit = |task: &TaskConfig, row| match task.rows.is_angular(row, &config.robot) {
        Some(true) => Unit::Radians,
        Some(false) => Unit::Metres,
        None => Unit::Unknown,
    };
    let tasks = config.tasks.iter().zip(&command.targets).map(|(task, target)| NamedTask {
        name: &task.name,
        requested: target.velocity.as_slice().to_vec(),
        units: (0..target.velocity.len()).map(|row| unit(task, row)).collect(),
        is_posture: task.law.follows_position() && !task.rows.joints().is_empty(),
        contacts: &target.contact,
        released_by: target.released_by.map(|task| config.tasks[task].name.as_str()),
    });
    let includes_position = matches!(config.limits, Limits::Robot(kind) if kind.includes_position());
    let explained = Explained {
        resolution: &command.resolution,
        joints: config.robot.joints().iter().map(|joint| joint.name.as_str()).collect(),
        inequalities: ConstraintNames::of_command(config, command),
        held_by: command.collisions.as_ref().and_then(|report| report.held_by.as_ref()),
        comes_too_near: command.collisions.as_ref().is_some_and(|report| report.is_violated),
        robot: Some(&config.robot),
        position: includes_position.then_some(measurement.joint_position.as_slice()),
        causes: command.limit_causes.clone(),
        keeps_jerk: config.keeps_jerk(),
        threshold: config.damping.map(|damping| damping.threshold()),
        conflicts: &command.limit_conflicts,
        tasks: tasks.collect(),
        request_share: command.request_share,
    };
    let mut sentences = explained.sentences();
    if command.fading_since_s.is_some() {
        let percent = (100.0 * command.request_share).round();
        sentences.push(format!(
            "{percent} % of what the tasks ask for is passed on, because the arm turned and turned without coming nearer to its targets"
        ));
    }
    sentences.extend(command.stuck.iter().map(|stuck| explained.stuck(stuck)));
    sentences
}

impl Explained<'_> {
    /// Returns what restricts the answer, then what the contacts miss and what each task gives up.
    pub fn sentences(&self) -> Vec<String> {
        let outcomes = self.tasks.iter().zip(&self.resolution.tasks);
        let losses: Vec<String> = outcomes.filter_map(|(task, outcome)| loss(task, outcome)).collect();
        let (mut sentences, contacts) = (self.restrictions(), self.contacts());
        let gives_up_posture_alone = !losses.is_empty() && self.gives_up_posture_alone();
        if losses.is_empty() || gives_up_posture_alone {
            if contacts.is_empty() {
                let which = if gives_up_posture_alone { "every task above" } else { "every task" };
                let only = if sentences.is_empty() && losses.is_empty() { "no limit is active; " } else { "" };
                let of = if self.request_share < 1.0 { " as far as its request is passed on" } else { "" };
                sentences.push(format!("{only}{which} is achieved{of}"));
            }
            sentences.extend(contacts);
            sentences.extend(losses.iter().map(|loss| format!("{loss}, since it has the motion that is left")));
            return sentences;
        }
        if !self.names_a_pair() {
            // An answer that was made continuous may lie beside the bounds of the rows that hold it back.
            add_once(&mut sentences, self.inequalities.of_distances().filter_map(near));
        }
        sentences.extend(self.singularities());
        if sentences.is_empty() {
            sentences.push("the tasks are in conflict".to_owned());
        }
        sentences.extend(contacts);
        sentences.extend(losses);
        sentences
    }

    /// Returns which limits, inequalities and links restrict the answer.
    fn restrictions(&self) -> Vec<String> {
        let resolution = self.resolution;
        let mut sentences: Vec<String> = self.solver().into_iter().collect();
        let limits = resolution.active_limits().zip(&self.causes);
        sentences.extend(limits.map(|((joint, active), cause)| self.limit(joint, active, *cause)));
        sentences.extend(resolution.broken_limits().map(|(joint, violated)| {
            let (joint, unit) = (self.joints[joint], self.unit(joint));
            let [value, limit] = [violated.value, violated.limit].map(|value| significant(value, 2));
            format!("joint `{joint}` moves at {value} {unit}, beyond its bound of {limit} {unit}")
        }));
        let is_kept = |id| resolution.broken_constraints().all(|(_, broken)| broken.bound.id != id);
        let active = resolution.active_constraints().filter(|(_, active)| is_kept(active.bound.id));
        let active = active.filter_map(|(_, active)| self.inequalities.get(active.bound.id));
        add_once(&mut sentences, active.map(at_its_bound));
        let violated = resolution.broken_constraints().filter_map(|(_, broken)| self.inequalities.get(broken.bound.id));
        add_once(&mut sentences, violated.map(|name| format!("inequality `{name}` is not kept")));
        sentences.extend(
            self.held_by.map(|[link, other]| format!("`{link}` would come too near to `{other}` before the arm stops")),
        );
        sentences.extend(self.comes_too_near.then(|| TOO_NEAR.to_owned()));
        sentences.extend(self.conflicts.iter().map(|&index| {
            let joint = self.joints[index];
            format!("the {} of joint `{joint}` contradicts its other limits and is not kept", self.conflicting(index))
        }));
        sentences
    }

    /// Returns which tasks a retreat has released, and which contacts miss their force.
    fn contacts(&self) -> Vec<String> {
        let retreats = |task: &NamedTask| task.contacts.iter().any(|axis| matches!(axis.phase, ContactPhase::Fault(_)));
        let released = self.tasks.iter().filter(|task| !retreats(task));
        let released = released.filter_map(|task| Some((task.name, task.released_by?)));
        let released = released.map(|(task, faulty)| {
            format!("task `{task}` asks for nothing, because task `{faulty}` has given its contact up")
        });
        let pressing = self.tasks.iter().filter(|task| task.released_by.is_none() || retreats(task));
        let missing = pressing.flat_map(|task| {
            task.contacts.iter().zip(&task.units).filter_map(|(axis, unit)| missing_force(task.name, axis, *unit))
        });
        released.chain(missing).collect()
    }

    /// Returns whether a sentence says which shapes keep clear of each other.
    fn names_a_pair(&self) -> bool {
        let mut active =
            self.resolution.active_constraints().filter_map(|(_, active)| self.inequalities.get(active.bound.id));
        self.held_by.is_some() || active.any(|name| pair(name).is_some())
    }

    /// Returns whether only the lowest task gives way, and that task is a posture: a redundant arm that moves does so all the time.
    fn gives_up_posture_alone(&self) -> bool {
        let Some((lowest, above)) = self.tasks.split_last() else { return false };
        let outcomes = &self.resolution.tasks;
        lowest.is_posture
            && !above.is_empty()
            && above.iter().zip(outcomes).all(|(task, outcome)| loss(task, outcome).is_none())
    }

    fn solver(&self) -> Option<String> {
        let text = match self.resolution.solver.status {
            Status::Optimal => return None,
            Status::NotCertified => "the joint velocities are inside the limits, but may not be optimal",
            Status::Failed => "no answer was found; the joint velocities are the slowest ones inside the limits",
        };
        Some(text.to_owned())
    }

    /// Returns which limit of a joint is active.
    fn limit(&self, index: usize, active: &ActiveBound, cause: BoundCause) -> String {
        let (joint, unit) = (self.joints[index], self.unit(index));
        let side = if active.bound.side == Side::Upper { "upper" } else { "lower" };
        let speed = significant(active.value.abs(), 2);
        let left = self.left(index, active.bound.side);
        let margin = self.robot.map_or(0.0, |robot| robot.joints()[index].limits.envelope.margin());
        match cause {
            BoundCause::Unlimited | BoundCause::Given => {
                format!("joint `{joint}` is at its {side} velocity bound of {} {unit}", significant(active.value, 2))
            }
            _ if left < -ROUNDED => format!("joint `{joint}` is beyond its {side} limit and must move back"),
            BoundCause::Velocity => format!("joint `{joint}` is at its speed limit of {speed} {unit}"),
            BoundCause::Position if left < RANGE_END && active.value.abs() < SLOW => {
                format!("joint `{joint}` is at its {side} limit")
            }
            BoundCause::Position => format!("joint `{joint}` brakes before its {side} limit, at {speed} {unit}"),
            BoundCause::Envelope if left < margin => {
                format!(
                    "joint `{joint}` is nearer to its {side} limit than its velocity envelope allows and must move back"
                )
            }
            BoundCause::Envelope if left < margin + RANGE_END => {
                format!("joint `{joint}` is as near to its {side} limit as its velocity envelope allows")
            }
            BoundCause::Envelope => {
                format!("joint `{joint}` is at its velocity limit near the {side} end of its range, {speed} {unit}")
            }
            BoundCause::Acceleration => format!("joint `{joint}` is at its acceleration limit"),
            BoundCause::Transition => {
                format!("joint `{joint}` is at its acceleration limit, in the transition from another controller")
            }
            BoundCause::Distance => {
                format!("joint `{joint}` brakes so that the arm stops before it comes too near to something")
            }
            BoundCause::Jerk => format!("joint `{joint}` is at its jerk limit"),
            BoundCause::LevellingOff => {
                format!("joint `{joint}` levels off within its jerk limit at the velocity that the tasks want")
            }
        }
    }

    /// Returns the distance of a joint from the end of its range on one side, rad or m; infinite if it does not matter.
    fn left(&self, joint: usize, side: Side) -> f64 {
        let Some((robot, position)) = self.robot.zip(self.position) else { return f64::INFINITY };
        let limits = robot.joints()[joint].limits;
        match side {
            Side::Upper => limits.upper - position[joint],
            Side::Lower => position[joint] - limits.lower,
        }
    }

    /// Returns the name of the limit that a conflict gives up.
    fn conflicting(&self, joint: usize) -> &'static str {
        let has_jerk = |robot: &RobotModel| robot.joints()[joint].limits.jerk.is_finite();
        if self.keeps_jerk && self.robot.is_some_and(has_jerk) {
            "acceleration or jerk limit"
        } else {
            "acceleration limit"
        }
    }

    /// Returns the singularities that tasks give way to.
    fn singularities(&self) -> Vec<String> {
        let tasks = self.tasks.iter().zip(&self.resolution.tasks);
        let deficient = tasks.filter(|(task, outcome)| task.released_by.is_none() && outcome.rank < task.units.len());
        // The singular values are those of all tasks, also of tasks that were not in the problem.
        let is_whole = self.tasks.iter().all(|task| task.released_by.is_none());
        let mut sentences: Vec<String> = deficient
            .map(|(task, outcome)| {
                let rows = task.units.len();
                format!(
                    "the posture is singular: task `{}` can move in {} of {rows} directions",
                    task.name, outcome.rank
                )
            })
            .collect();
        let singularity = &self.resolution.singularity;
        if singularity.algorithmic {
            sentences.push("the tasks are in conflict".to_owned());
        } else if sentences.is_empty()
            && is_whole
            && let Some(threshold) = self.threshold
            && singularity.smallest_singular_value() < threshold
        {
            let [sigma, threshold] =
                [singularity.smallest_singular_value(), threshold].map(|value| significant(value, 2));
            sentences.push(format!(
                "the arm is near a singularity: the smallest singular value is {sigma}, damping starts below {threshold}"
            ));
        }
        sentences
    }

    fn stuck(&self, stuck: &StuckTask) -> String {
        let (name, since) = (self.tasks[stuck.task].name, stuck.since_s);
        let leaving = if stuck.leaving { "; the arm leaves this posture" } else { "" };
        format!("task `{name}` has made no progress since t = {since:.3} s{leaving}")
    }

    /// Returns the unit of the velocity of a joint.
    fn unit(&self, joint: usize) -> &'static str {
        let unit = match self.robot.map(|robot| robot.joints()[joint].kind.is_translation()) {
            Some(true) => Unit::Metres,
            Some(false) => Unit::Radians,
            None => Unit::Unknown,
        };
        unit.velocity()
    }
}

/// Adds sentences that are not there yet: several rows may belong to one pair of shapes.
fn add_once(sentences: &mut Vec<String>, more: impl Iterator<Item = String>) {
    for sentence in more {
        if !sentences.contains(&sentence) {
            sentences.push(sentence);
        }
    }
}

/// Returns the link and the other shape of a row that watches a distance, by its name.
fn pair(name: &str) -> Option<(&str, &str)> {
    name.strip_prefix("collision:")?.split_once('/')
}

/// Returns the sentence about an active inequality, by its name.
fn at_its_bound(name: &str) -> String {
    match pair(name) {
        Some((link, other)) => format!("`{link}` keeps clear of `{other}`"),
        None => format!("inequality `{name}` is at its bound"),
    }
}

/// Returns the sentence about a row that watches a distance and that a command within the limits could break.
fn near(name: &str) -> Option<String> {
    pair(name).map(|(link, other)| format!("`{link}` is near `{other}` and may come nearer only slowly"))
}

/// Returns that an axis does not press yet, not as it should, or no more; a task achieves its velocity then all the same.
fn missing_force(task: &str, axis: &ContactReport, unit: Unit) -> Option<String> {
    let least = if matches!(unit, Unit::Radians) { MISSING_TORQUE } else { MISSING_FORCE };
    let is_near = (axis.force - axis.target).abs() <= least.max(MISSING_PART * axis.target.abs());
    let [force, target] = [axis.force, axis.target].map(|force| significant(force, 2));
    let state = match axis.phase {
        ContactPhase::Contact if is_near => return None,
        ContactPhase::Contact => "presses",
        ContactPhase::Approach => "approaches its surface",
        ContactPhase::Loss => "has lost its surface",
        ContactPhase::Fault(_) => "has given its contact up",
    };
    let unit = if matches!(unit, Unit::Radians) { "N·m" } else { "N" };
    Some(format!("task `{task}` {state}: {force} of {target} {unit}"))
}

/// Returns what a task gives up, if anything.
fn loss(task: &NamedTask, outcome: &TaskOutcome) -> Option<String> {
    if task.released_by.is_some() {
        return None;
    }
    if let Some(scale) = outcome.scale.filter(|scale| *scale < 1.0 - MIN_SCALED) {
        let percent = significant(100.0 * scale, 2);
        return Some(format!("task `{}` moves in its direction at {percent} % of its speed", task.name));
    }
    let part = |unit: Unit| {
        let rows = task.requested.iter().zip(&outcome.achieved).zip(&task.units).filter(|(_, known)| **known == unit);
        let norm = rows.fold(0.0_f64, |norm, ((requested, achieved), _)| norm.hypot(achieved - requested));
        (norm >= MIN_GIVEN_UP).then(|| format!("{} {}", significant(norm, 2), unit.velocity()))
    };
    let parts: Vec<String> = Unit::ALL.into_iter().filter_map(part).collect();
    (!parts.is_empty()).then(|| format!("task `{}` gives up {}", task.name, parts.join(" and ")))
}
