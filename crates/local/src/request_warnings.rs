//! Warnings about what a request states: a method that does not keep the order of its tasks, and numbers that are probably in
//! another unit, degrees in place of radians, millimetres in place of metres.

use std::fmt;

use nalgebra::Vector3;
use revprio_api::wire::{self, Axis, LawTarget, PerAxis};
use revprio_core::controller::{Controller, Measurement, TaskConfig};
use revprio_core::streaming::StreamedValue;
use revprio_robot::{Joint, RobotModel};

/// Distance of a target from the base above which it is reported, reaches of the arm. Targets beyond reach are common, and
/// they are near: the next unit is a thousand times larger.
const FAR_REACHES: f64 = 3.0;

/// Reach that even a short arm counts as having, m: its first joint may stand off the base.
const SMALLEST_REACH_M: f64 = 0.3;

/// Speed of a tool above which it is reported, m/s. The fastest industrial robots reach 10 m/s.
const FAST_M_S: f64 = 15.0;

/// Angular velocity of a tool above which it is reported, rad/s: 10 turns a second.
const FAST_RAD_S: f64 = 20.0 * std::f64::consts::PI;

/// Speed of an approach to a surface, or of a retreat from it, above which it is reported, m/s. A drop from 5 cm reaches it.
const FAST_APPROACH_M_S: f64 = 1.0;

/// The same about an axis, rad/s: 1 m/s at 0.1 m from it.
const FAST_APPROACH_RAD_S: f64 = 10.0;

/// Rotation vector above which it is reported, rad: a whole turn.
const WHOLE_TURN: f64 = 2.0 * std::f64::consts::PI;

/// Distance outside the range of a joint that is reported, rad or m. Some joint of an arm is as far outside in degrees, and in
/// millimetres.
const OUTSIDE: f64 = 1.0;

/// Speed of a joint above which it is reported, speed limits of the joint. Degrees are 57 times as many as radians.
const FAST_JOINT: f64 = 3.0;

/// Returns the warnings about the method and the targets of a checked controller.
pub fn of_controller(request: &wire::Controller, robot: &RobotModel) -> Vec<String> {
    let order = disturbed_order(request.method, request.tasks.len());
    let tasks = request.tasks.iter().flat_map(|task| {
        let about = About { task: &task.name, robot };
        task.law.iter().flat_map(move |law| about.law(task, law)).collect::<Vec<_>>()
    });
    order.into_iter().chain(tasks).chain(of_null_space(request.null_space_velocity.as_ref(), robot)).collect()
}

/// Returns the warnings about the motion of the joints that the tasks leave free.
fn of_null_space(motion: Option<&wire::NullSpaceVelocity>, robot: &RobotModel) -> Vec<String> {
    use wire::{NullSpaceMotion, NullSpaceVelocity};
    let (part, found) = match motion {
        Some(NullSpaceVelocity::Motion(NullSpaceMotion::Posture { joint_position, .. })) => {
            ("its target of ", joints_outside(robot, joint_position))
        }
        Some(NullSpaceVelocity::Constant(velocity)) => ("", fast_joints(robot, velocity)),
        _ => return Vec::new(),
    };
    found.into_iter().map(|joint| format!("null-space velocity: {part}{joint}")).collect()
}

/// Returns the warnings about a checked problem.
pub fn of_problem(request: &wire::ResolveRequest, robot: Option<&RobotModel>) -> Vec<String> {
    let mut warnings: Vec<String> = disturbed_order(request.method, request.tasks.len()).into_iter().collect();
    if let Some(robot) = robot {
        let outside = request.joint_position.as_ref().map(|position| joints_outside(robot, position));
        warnings.extend(outside.unwrap_or_default());
        warnings.extend(request.joint_velocity.iter().flat_map(|velocity| fast_joints(robot, velocity)));
        warnings.extend(of_null_space(request.null_space_velocity.as_ref(), robot));
    }
    for (k, task) in request.tasks.iter().enumerate() {
        let name = task.name.clone().unwrap_or_else(|| format!("task {}", k + 1));
        let (Some(axes), Some(velocity)) = (&task.axes, &task.velocity) else { continue };
        let fast = axes.iter().zip(velocity).filter_map(|(axis, velocity)| too_fast(*axis, *velocity));
        warnings.extend(fast.map(|fast| format!("task `{name}`: {fast}")));
    }
    warnings
}

/// Adds the warnings about the targets and the chunks of a state: for each, those about its first value that has some, and those about
/// its stated velocity.
pub fn of_targets(warnings: &mut Vec<String>, controller: &Controller, measurement: &Measurement) {
    let config = controller.config();
    let about = |task: &TaskConfig, values: &mut dyn Iterator<Item = &StreamedValue>| {
        let about = About { task: &task.name, robot: &config.robot };
        values.map(|value| about.streamed(task, value)).find(|found| !found.is_empty()).unwrap_or_default()
    };
    for target in &measurement.targets {
        let task = &config.tasks[target.task];
        let values = std::iter::once(&target.value).chain(target.ahead.iter().map(|later| &later.value));
        warnings.extend(about(task, &mut { values }));
        let stated = target.velocity.as_deref().unwrap_or_default();
        warnings.extend(About { task: &task.name, robot: &config.robot }.velocity(task, stated));
    }
    for chunk in &measurement.chunks {
        let values = &mut chunk.actions.iter().map(|action| &action.value);
        warnings.extend(about(&config.tasks[chunk.task], values));
    }
}

/// Reverse priority of the paper keeps the order of two tasks. From three on, a task that is added later disturbs those below it,
/// which are not corrected any more.
fn disturbed_order(method: wire::Method, tasks: usize) -> Option<String> {
    (method == wire::Method::ReversePriority && tasks > 2).then(|| {
        format!(
            "the method `{method}` does not keep the order of {tasks} tasks: from three tasks on, a lower one can disturb a \
             higher one; use `strict_reverse_priority` unless you reproduce the paper"
        )
    })
}

/// The task that a warning is about, and its robot.
#[derive(Clone, Copy)]
struct About<'a> {
    task: &'a str,
    robot: &'a RobotModel,
}

impl About<'_> {
    /// Returns the warnings about the target of a law.
    fn law(self, task: &wire::ControllerTask, law: &wire::Law) -> Vec<String> {
        let axes = task.axes.as_deref().unwrap_or_default();
        let mut warnings = self.target(task, axes, law);
        if let wire::Law::Contact { approach_speed, retreat_speed, .. } = law {
            let speeds = [("an approach", approach_speed), ("a retreat", retreat_speed)];
            warnings.extend(speeds.into_iter().flat_map(|(motion, speed)| {
                axes.iter().enumerate().filter_map(move |(row, &axis)| {
                    let fast = fast_approach(axis, speed.as_ref()?.at(row)?)?;
                    Some(format!("task `{}`: {motion} with {fast}", self.task))
                })
            }));
        }
        warnings
    }

    /// Returns the warnings about where a law leads.
    fn target(self, task: &wire::ControllerTask, axes: &[Axis], law: &wire::Law) -> Vec<String> {
        match law.target() {
            LawTarget::Velocity(velocity) => self.rows(axes, velocity, too_fast),
            LawTarget::Pose { pose, displacement } => {
                let pose = match pose {
                    wire::TargetPose::Fixed(pose) => self.position(stated_position(&task.frame, pose)),
                    wire::TargetPose::Initial => None,
                };
                let displaced = |profile| {
                    let mut far = self.rows(axes, profile, |axis, value| self.displacement(axis, value));
                    far.extend(axes.iter().enumerate().find_map(|(row, &axis)| self.swing(profile, (row, axis))));
                    far
                };
                pose.into_iter().chain(displacement.map(displaced).unwrap_or_default()).collect()
            }
            LawTarget::Joints { names, position } => {
                let worst = |(row, joint): (usize, &Joint)| {
                    values(position, row).into_iter().find_map(|q| self.joint(joint, q))
                };
                let joints = self.robot.joints();
                let named = |name: &String| joints.iter().find(|joint| joint.name == *name);
                match names {
                    Some(names) => names.iter().filter_map(named).enumerate().filter_map(worst).collect(),
                    None => joints.iter().enumerate().filter_map(worst).collect(),
                }
            }
            // A camera may look at what is far away.
            LawTarget::Point(_) | LawTarget::None => Vec::new(),
        }
    }

    /// Returns the warnings about a streamed value.
    fn streamed(self, task: &TaskConfig, value: &StreamedValue) -> Vec<String> {
        match value {
            StreamedValue::Pose { position: Some(position), .. } => {
                let frame = task.rows.fixed_frame();
                let in_base = frame.map_or(*position, |frame| frame.transform_point(&(*position).into()).coords);
                self.position(in_base).into_iter().collect()
            }
            StreamedValue::JointPosition(values) => {
                let joints = task.rows.joints().iter().map(|&joint| &self.robot.joints()[joint]);
                joints.zip(values).filter_map(|(joint, value)| self.joint(joint, *value)).collect()
            }
            StreamedValue::Velocity(values) => self.velocity(task, values),
            StreamedValue::Pose { position: None, .. } | StreamedValue::Force(_) => Vec::new(),
        }
    }

    /// Returns the warnings about a velocity along the rows of a task.
    fn velocity(self, task: &TaskConfig, velocity: &[f64]) -> Vec<String> {
        let joints = task.rows.joints();
        let fast = |(row, &v): (usize, &f64)| match joints.get(row) {
            Some(&joint) => fast_joint(&self.robot.joints()[joint], v),
            None => faster_than_arms(!task.rows.is_angular(row, self.robot)?, v, format_args!("in row {}", row + 1)),
        };
        let name = |text| format!("task `{}`: its target moves: {text}", self.task);
        velocity.iter().enumerate().filter_map(fast).map(name).collect()
    }

    /// Returns the first warning about each row of a profile.
    fn rows(self, axes: &[Axis], profile: &wire::Profile, check: impl Fn(Axis, f64) -> Option<String>) -> Vec<String> {
        let of_row =
            |(row, &axis): (usize, &Axis)| values(profile, row).into_iter().find_map(|value| check(axis, value));
        let name = |text| format!("task `{}`: {text}", self.task);
        axes.iter().enumerate().filter_map(of_row).map(name).collect()
    }

    /// Returns the warning about the largest velocity of a sine along an axis.
    fn swing(self, profile: &wire::Profile, (row, axis): (usize, Axis)) -> Option<String> {
        let wire::Profile::Sine { amplitude, angular_frequency_rad_s, .. } = profile else { return None };
        let fast = too_fast(axis, amplitude.at(row)? * angular_frequency_rad_s)?;
        Some(format!("task `{}`: {fast}", self.task))
    }

    /// Returns the distance that no target of the arm has, m; infinite if a sliding joint has no limits.
    fn far(self) -> f64 {
        FAR_REACHES * self.robot.reach().max(SMALLEST_REACH_M) + self.robot.travel()
    }

    /// Returns the warning about the position of a target, base frame, m.
    fn position(self, position: Vector3<f64>) -> Option<String> {
        let (distance, reach) = (position.norm(), self.robot.reach() + self.robot.travel());
        (distance > self.far()).then(|| {
            format!(
                "task `{}`: its target is {distance:.1} m from the base, and the arm reaches {reach:.2} m; positions are in \
                 m, not in mm",
                self.task
            )
        })
    }

    fn displacement(self, axis: Axis, value: f64) -> Option<String> {
        if is_linear(axis) {
            let far = value.abs() > self.far();
            far.then(|| format!("a displacement of {value} m along {axis}; lengths are in m, not in mm"))
        } else {
            let far = value.abs() > WHOLE_TURN;
            far.then(|| format!("a displacement of {value} rad about {axis}; angles are in rad, not in degrees"))
        }
    }

    fn joint(self, joint: &Joint, value: f64) -> Option<String> {
        outside(joint, value).map(|text| format!("task `{}`: its target of {text}", self.task))
    }
}

/// Describes a speed of an approach or a retreat that is too high.
fn fast_approach(axis: Axis, speed: f64) -> Option<String> {
    let (fastest, unit, other) =
        if is_linear(axis) { (FAST_APPROACH_M_S, "m/s", "mm/s") } else { (FAST_APPROACH_RAD_S, "rad/s", "°/s") };
    (speed > fastest).then(|| format!("{speed} {unit} hits hard; speeds are in {unit}, not in {other}"))
}

/// Returns the position of a stated pose in the base frame, m.
fn stated_position(frame: &wire::Frame, pose: &wire::Pose) -> Vector3<f64> {
    let position = Vector3::from(pose.position);
    match frame {
        wire::Frame::Base | wire::Frame::Tool => position,
        wire::Frame::Fixed(frame) => {
            let wire::Orientation { w, x, y, z } = frame.orientation;
            match revprio_robot::kinematics::pose(frame.position, [w, x, y, z]) {
                Ok(frame) => frame.transform_point(&position.into()).coords,
                Err(_) => position,
            }
        }
    }
}

fn is_linear(axis: Axis) -> bool {
    matches!(axis, Axis::X | Axis::Y | Axis::Z)
}

/// Describes a velocity along an axis that no arm has.
fn too_fast(axis: Axis, velocity: f64) -> Option<String> {
    let is_linear = is_linear(axis);
    faster_than_arms(is_linear, velocity, format_args!("{} {axis}", if is_linear { "along" } else { "about" }))
}

/// Describes a linear or an angular velocity that no arm has.
fn faster_than_arms(is_linear: bool, velocity: f64, place: fmt::Arguments) -> Option<String> {
    let (fastest, unit, other) = if is_linear { (FAST_M_S, "m/s", "mm/s") } else { (FAST_RAD_S, "rad/s", "°/s") };
    (velocity.abs() > fastest)
        .then(|| format!("{velocity} {unit} {place} is faster than arms are; velocities are in {unit}, not in {other}"))
}

/// Describes a position outside the range of a joint.
fn outside(joint: &Joint, position: f64) -> Option<String> {
    let (name, lower, upper) = (&joint.name, joint.limits.lower, joint.limits.upper);
    let is_outside = position < lower - OUTSIDE || position > upper + OUTSIDE;
    is_outside.then(|| {
        format!(
            "joint `{name}` at {position} is outside its range {lower} … {upper}; positions are in rad or m, not in degrees \
             or mm"
        )
    })
}

fn joints_outside(robot: &RobotModel, position: &wire::JointVector) -> Vec<String> {
    by_joint(robot, position).filter_map(|(joint, q)| outside(joint, q)).collect()
}

fn fast_joints(robot: &RobotModel, velocity: &wire::JointVector) -> Vec<String> {
    by_joint(robot, velocity).filter_map(|(joint, v)| fast_joint(joint, v)).collect()
}

/// Describes a velocity that a joint cannot have.
fn fast_joint(joint: &Joint, v: f64) -> Option<String> {
    let (name, limit, unit) = (&joint.name, joint.limits.velocity, joint.kind.unit());
    let text =
        || format!("joint `{name}` moves at {v} {unit}/s, and its speed limit is {limit} {unit}/s; check the unit");
    (v.abs() > FAST_JOINT * limit).then(text)
}

/// Returns each joint with its value.
fn by_joint<'a>(robot: &'a RobotModel, vector: &'a wire::JointVector) -> impl Iterator<Item = (&'a Joint, f64)> {
    let joints = robot.joints().iter().enumerate();
    joints.filter_map(move |(index, joint)| match vector {
        wire::JointVector::Ordered(values) => values.get(index).map(|value| (joint, *value)),
        wire::JointVector::Named(named) => {
            named.iter().find(|(name, _)| *name == joint.name).map(|(_, value)| (joint, *value))
        }
    })
}

/// Returns values that a row of a profile reaches, the largest among them.
fn values(profile: &wire::Profile, row: usize) -> Vec<f64> {
    let at = |values: &PerAxis<f64>| values.at(row);
    let found = match profile {
        wire::Profile::Constant { value } => vec![at(value)],
        wire::Profile::Sine { offset, amplitude, .. } => {
            let sum = |sign: f64| Some(at(offset)? + sign * at(amplitude)?);
            vec![sum(1.0), sum(-1.0)]
        }
        wire::Profile::Ramp { start, end, .. } => vec![at(start), at(end)],
        wire::Profile::Steps { points } | wire::Profile::Waypoints { points } => {
            points.iter().map(|point| at(&point.value)).collect()
        }
    };
    found.into_iter().flatten().collect()
}
