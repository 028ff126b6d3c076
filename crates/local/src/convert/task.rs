//! Tasks of a controller.

use revprio_api::wire::{self, PerAxis};
use revprio_core::controller::TaskConfig;
use revprio_core::law::{
    Braking, ForceLaw, GainError, Gains, HybridLaw, ImpedanceLaw, Law, PositionLaw, PositionLawError, Profile,
};
use revprio_core::rows::{GazeRows, JointRows, JointTarget, RawRows, TargetPose, TaskRows, ToolRows};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::half_range;

use super::checks::{Inside, Missing, Refused, Result, check, each};
use super::contact::contact_law;
use super::numbers::{check_numbers, inertia, joint_index, velocity_bounds};
use super::pose::{pose, task_body, task_frame};
use super::profile::{PerRow, at_row};
use super::resolve_task::{axis_selection, check_no_link, own_jacobian, scaled_bounds};
use super::targets::streaming;
use super::terms;
use crate::error::ApiError;

/// Reads a task.
pub fn task_config(task: &wire::ControllerTask, robot: &RobotModel) -> Result<TaskConfig> {
    let (rows, law) = match &task.law {
        Some(wire::Law::Posture { joints, gain, max_acceleration, braking, path, target_position }) => {
            check_posture_fields(task)?;
            let joints = joint_indices(joints.as_deref(), target_position, robot);
            let law = |reader: &LawReader| reader.position(gain, max_acceleration.as_ref(), *braking, *path);
            joints.and_then(|joints| posture(joints, target_position, law)).inside("/law")?
        }
        Some(law @ wire::Law::LookAt { target_point, direction, .. }) => {
            check_no_rows("look_at", task)?;
            check(task.frame == wire::Frame::Base, "/frame", "the law `look_at` has no `frame`; give `link`")?;
            check(
                task.streaming.is_none(),
                "/streaming",
                "the law `look_at` follows no targets; change its `target_point`",
            )?;
            let rows = gaze_rows(task, target_point, *direction, robot)?;
            let rows = TaskRows::Gaze(rows);
            let law = LawReader(PerRow { rows: rows.len() }).law(law).inside("/law")?;
            (rows, law)
        }
        law => match (&task.axes, &task.jacobian) {
            (Some(axes), None) => tool_task(task, axes, law.as_ref(), robot)?,
            (None, Some(jacobian)) => raw_task(task, jacobian, law.as_ref(), robot)?,
            (None, None) => {
                return Err(ApiError::invalid("/axes", "this task needs `axes`, the controlled axes of the tool"));
            }
            (Some(_), Some(_)) => return Err(ApiError::invalid("", "give either `axes` or `jacobian`")),
        },
    };
    let streaming = streaming(task.streaming.as_ref(), rows.len()).inside("/streaming")?;
    Ok(TaskConfig { name: task.name.clone(), rows, law, scaled: task.scale, streaming })
}

fn tool_task(
    task: &wire::ControllerTask,
    axes: &[wire::Axis],
    law: Option<&wire::Law>,
    robot: &RobotModel,
) -> Result<(TaskRows, Law)> {
    let axes = axis_selection(axes, "/axes")?;
    let reader = LawReader(PerRow { rows: axes.len() });
    let body = task_body(robot, task.link.as_deref(), task.relative_to.as_deref())?;
    let rows = ToolRows { frame: task_frame(body, &task.frame, task.reference_point)?, ..ToolRows::new(axes) };
    let rows = match law {
        Some(law) => reader.with_target(rows, law).inside("/law")?,
        None => rows,
    };
    let contact = match law {
        Some(law) if task.lower.is_none() && task.upper.is_none() => contact_law(law, &rows.axes).inside("/law")?,
        _ => None,
    };
    let law = contact.map_or_else(|| reader.law_or_bounds(task, law), |law| Ok(Law::Contact(law)))?;
    Ok((TaskRows::Tool(rows), law))
}

/// Reads the line of sight of a task.
fn gaze_rows(
    task: &wire::ControllerTask,
    target: &wire::Profile,
    direction: [f64; 3],
    robot: &RobotModel,
) -> Result<GazeRows> {
    let body = task_body(robot, task.link.as_deref(), task.relative_to.as_deref())?;
    let frame = task_frame(body, &wire::Frame::Base, task.reference_point)?;
    check_numbers(&direction, "/law/direction")?;
    let target = LawReader(PerRow { rows: 3 }).profile(target, "/target_point").inside("/law")?;
    GazeRows::new(body, frame.reference_point, direction.into(), target).at("/law/direction")
}

/// Reads a task of constant rows over the joints.
fn raw_task(
    task: &wire::ControllerTask,
    jacobian: &[Vec<f64>],
    law: Option<&wire::Law>,
    robot: &RobotModel,
) -> Result<(TaskRows, Law)> {
    check_no_link(task.link.as_deref(), task.relative_to.as_deref())?;
    let jacobian = own_jacobian(jacobian, &task.frame, task.reference_point)?;
    let (given, expected, name) = (jacobian.ncols(), robot.joint_count(), robot.name());
    check(given == expected, "/jacobian", format_args!("{given} columns, but `{name}` has {expected} joints"))?;
    let detail = "`jacobian` rows have no position and no force; use the law `velocity`, or `lower` and `upper`";
    check(matches!(law, None | Some(wire::Law::Velocity { .. })), "/law/kind", detail)?;
    let reader = LawReader(PerRow { rows: jacobian.nrows() });
    Ok((TaskRows::Raw(RawRows { jacobian }), reader.law_or_bounds(task, law)?))
}

fn posture(
    joints: Vec<usize>,
    target: &wire::PostureTarget,
    law: impl Fn(&LawReader) -> Result<Law, ApiError>,
) -> Result<(TaskRows, Law)> {
    let reader = LawReader(PerRow { rows: joints.len() });
    let target = match target {
        wire::PostureTarget::MidRange => JointTarget::MidRange,
        wire::PostureTarget::Profile(profile) => JointTarget::Position(reader.profile(profile, "/target_position")?),
    };
    Ok((TaskRows::Joints(JointRows { joints, target }), law(&reader)?))
}

/// Refuses the fields that a posture does not have.
fn check_posture_fields(task: &wire::ControllerTask) -> Result<()> {
    check_no_rows("posture", task)?;
    let given = [
        ("frame", task.frame != wire::Frame::Base),
        ("reference_point", task.reference_point.is_some()),
        ("link", task.link.is_some()),
        ("relative_to", task.relative_to.is_some()),
    ];
    let Some((field, _)) = given.iter().find(|(_, given)| *given) else { return Ok(()) };
    let detail = format!("the law `posture` controls joints and has no `{field}`; select joints with `joints`");
    Err(ApiError::invalid(format!("/{field}"), detail))
}

/// Refuses the fields that state rows, for a law that has its own.
fn check_no_rows(law: &str, task: &wire::ControllerTask) -> Result<()> {
    let given = [
        ("axes", task.axes.is_some()),
        ("jacobian", task.jacobian.is_some()),
        ("lower", task.lower.is_some()),
        ("upper", task.upper.is_some()),
    ];
    let Some((field, _)) = given.iter().find(|(_, given)| *given) else { return Ok(()) };
    let detail = format!("the law `{law}` has rows of its own and no `{field}`");
    Err(ApiError::invalid(format!("/{field}"), detail))
}

/// Returns the indices of the joints of a posture. The default is all joints; for `mid_range`, all joints with a range.
fn joint_indices(names: Option<&[String]>, target: &wire::PostureTarget, robot: &RobotModel) -> Result<Vec<usize>> {
    let counts = |joint: &usize| {
        *target != wire::PostureTarget::MidRange || half_range(&robot.joints()[*joint].limits).is_some()
    };
    let Some(names) = names else { return Ok((0..robot.joint_count()).filter(counts).collect()) };
    each("/joints", names, |_, name| {
        let known = robot.name();
        let detail = format_args!("`{known}` has no joint `{name}`; see GET /v1/robots/{known}");
        joint_index(robot, name).or_invalid("", detail)
    })
}

/// Reads a law.
struct LawReader(PerRow);

impl LawReader {
    /// Reads the law of a task, or the bounds in its place.
    fn law_or_bounds(&self, task: &wire::ControllerTask, law: Option<&wire::Law>) -> Result<Law> {
        let bounds = velocity_bounds(task.lower.as_deref(), task.upper.as_deref(), self.0.rows)?;
        match (law, bounds) {
            (Some(law), None) => self.law(law).inside("/law"),
            (None, Some(_)) if task.scale => Err(scaled_bounds()),
            (None, Some(bounds)) => Ok(Law::Bounds(bounds)),
            _ => Err(ApiError::invalid("", "give either `law`, or `lower` and `upper` (or one of them)")),
        }
    }

    /// Reads a law for axes of the tool.
    fn law(&self, law: &wire::Law) -> Result<Law> {
        // The size of each field was checked, so no law is refused for it.
        let rows = self.0.rows;
        let mismatch =
            || ApiError::invalid("", format!("give one value for each of {rows} rows in all lists of the law"));
        Ok(match law {
            wire::Law::Velocity { target_velocity } => {
                Law::Velocity(self.profile(target_velocity, "/target_velocity")?)
            }
            wire::Law::Pose { gain, max_acceleration, braking, path, .. }
            | wire::Law::Posture { gain, max_acceleration, braking, path, .. } => {
                self.position(gain, max_acceleration.as_ref(), *braking, *path)?
            }
            wire::Law::LookAt { gain, max_acceleration, braking, .. } => {
                let max_acceleration = max_acceleration.map(PerAxis::All);
                self.position(&PerAxis::All(*gain), max_acceleration.as_ref(), *braking, None)?
            }
            wire::Law::Contact { .. } => {
                return Err(ApiError::invalid("/kind", "the law `contact` presses along `axes` of the tool"));
            }
            wire::Law::Force { inertia, damping, target_force } => {
                let gains = self.gains(inertia, damping, &PerAxis::All(0.0))?;
                ForceLaw::new(gains, self.profile(target_force, "/target_force")?)
                    .map(Law::Force)
                    .ok_or_else(mismatch)?
            }
            wire::Law::Impedance { inertia, damping, stiffness, .. } => {
                Law::Impedance(ImpedanceLaw::new(self.gains(inertia, damping, stiffness)?))
            }
            wire::Law::Hybrid { inertia, damping, stiffness, position_controlled, target_force, .. } => {
                let gains = self.gains(inertia, damping, stiffness)?;
                let force = self.profile(target_force, "/target_force")?;
                let law = HybridLaw::new(gains, force, self.0.each(position_controlled, "/position_controlled")?);
                law.map(Law::Hybrid).ok_or_else(mismatch)?
            }
        })
    }

    /// Adds the target of the law to the rows.
    fn with_target(&self, rows: ToolRows, law: &wire::Law) -> Result<ToolRows> {
        let (wire::Law::Pose { target_pose, target_displacement, .. }
        | wire::Law::Impedance { target_pose, target_displacement, .. }
        | wire::Law::Hybrid { target_pose, target_displacement, .. }) = law
        else {
            return Ok(rows);
        };
        let target_pose = match target_pose {
            wire::TargetPose::Initial => TargetPose::Initial,
            wire::TargetPose::Fixed(fixed) => TargetPose::Fixed(pose(fixed).inside("/target_pose")?),
        };
        let profile = |profile| self.profile(profile, "/target_displacement");
        let target_displacement = target_displacement.as_ref().map(profile).transpose()?;
        Ok(ToolRows { target_pose, target_displacement, ..rows })
    }

    fn position(
        &self,
        gain: &PerAxis<f64>,
        max_acceleration: Option<&PerAxis<f64>>,
        braking: bool,
        path: Option<wire::MotionPath>,
    ) -> Result<Law> {
        let gains = self.0.numbers(gain, "/gain")?;
        let (field, default) = ("/max_acceleration", PerAxis::All(0.0));
        let braking = match max_acceleration {
            Some(_) if !braking => {
                let detail = "a law with `braking` false has the bare gain; omit `max_acceleration` or `braking`";
                return Err(ApiError::invalid(field, detail));
            }
            Some(values) => Braking::AtMost(self.0.numbers(values, field)?.into()),
            None if braking => Braking::Joints,
            None => Braking::None,
        };
        let along = |law: PositionLaw| path.map_or(law.clone(), |path| law.along(terms::motion_path(path)));
        let law = PositionLaw::with_braking(gains, braking).map(along);
        law.map(Law::Position).map_err(|error| {
            let pointer = match error {
                PositionLawError::Gain { row, .. } => at_row(gain, "/gain", row),
                PositionLawError::Acceleration { row, .. } => at_row(max_acceleration.unwrap_or(&default), field, row),
                PositionLawError::Size { .. } => field.to_owned(),
            };
            ApiError::invalid(pointer, error)
        })
    }

    fn gains(&self, masses: &PerAxis<f64>, damping: &PerAxis<f64>, stiffness: &PerAxis<f64>) -> Result<Gains> {
        let list = |values: &PerAxis<f64>, field: &str| self.0.numbers(values, field);
        let (m, b, k) = (list(masses, "/inertia")?, list(damping, "/damping")?, list(stiffness, "/stiffness")?);
        for (row, value) in m.iter().enumerate() {
            inertia(*value, "").map_err(|error| error.inside(&at_row(masses, "/inertia", row)))?;
        }
        Gains::new(self.0.rows, &m, &b, &k).map_err(|error| match error {
            GainError::Size { gain, .. } => ApiError::invalid(format!("/{gain}"), error),
            GainError::Range { gain, row, .. } => {
                let values = match gain {
                    "inertia" => masses,
                    "damping" => damping,
                    _ => stiffness,
                };
                ApiError::invalid(at_row(values, &format!("/{gain}"), row), error)
            }
        })
    }

    fn profile(&self, profile: &wire::Profile, field: &str) -> Result<Profile> {
        self.0.profile(profile).inside(field)
    }
}
