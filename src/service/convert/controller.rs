//! Controllers.

use nalgebra::{IsometryMatrix3, Quaternion, Translation3, UnitQuaternion};

use super::environment;
use super::inequalities::InequalityReader;
use super::numbers::{damping, number, numbers, velocity_box};
use super::resolve::{axis_selection, known_robot, positive_period};
use super::terms;
use crate::controller::{ConfigError, Controller, ControllerConfig, Limits, TargetPose, TaskConfig};
use crate::law::{ForceLaw, GainError, Gains, HybridLaw, ImpedanceLaw, Law, Profile};
use crate::service::problem::Problem;
use crate::service::robots::Robots;
use crate::wire;

/// Most tasks of a controller.
const MOST_TASKS: usize = 64;

/// How far from 1 the length of a quaternion may be; more is no rounding but a mistake.
const UNIT_LENGTH: f64 = 1e-3;

/// Reads a controller.
pub fn controller(request: &wire::Controller, robots: &Robots) -> Result<Controller, Problem> {
    let robot = known_robot(&request.robot, robots)?;
    if request.tasks.len() > MOST_TASKS {
        return Err(Problem::invalid("/tasks", format!("at most {MOST_TASKS} tasks")));
    }
    let config = ControllerConfig {
        period_s: positive_period(request.period_s, "/period_s")?,
        method: terms::method(request.method),
        solver: terms::solver(request.solver),
        damping: damping(request.damping, "/damping")?,
        limits: match &request.limits {
            wire::Limits::Robot(kind) => Limits::Robot(terms::limit_kind(*kind)),
            wire::Limits::Box { lower, upper } => {
                Limits::Fixed(velocity_box(lower, upper, robot.joint_count(), "/limits")?)
            }
        },
        barriers: InequalityReader {
            robot: Some(&robot),
            joints: robot.joint_count(),
            period_s: Some(request.period_s),
        }
        .read(&request.inequalities)?,
        wrench_convention: terms::wrench_convention(request.wrench_convention),
        tasks: request.tasks.iter().enumerate().map(|(k, task)| task_config(k, task)).collect::<Result<_, _>>()?,
        robot,
    };
    environment::check(request)?;
    Controller::new(config).map_err(|error| Problem::invalid(config_pointer(&error), error))
}

fn config_pointer(error: &ConfigError) -> String {
    match error {
        ConfigError::Period(_) => "/period_s".to_owned(),
        ConfigError::NoTasks => "/tasks".to_owned(),
        ConfigError::DuplicateTask { task, .. } => format!("/tasks/{task}/name"),
        ConfigError::Rows { task, .. } => format!("/tasks/{task}/law"),
        ConfigError::Limits { .. } => "/limits".to_owned(),
        ConfigError::Barrier { index, .. } => format!("/inequalities/{index}"),
    }
}

fn task_config(k: usize, task: &wire::ControllerTask) -> Result<TaskConfig, Problem> {
    let axes = axis_selection(&task.axes, &format!("/tasks/{k}/axes"))?;
    let reader = LawReader { rows: axes.len(), pointer: format!("/tasks/{k}/law") };
    let (law, target_pose) = reader.law(&task.law)?;
    Ok(TaskConfig { name: task.name.clone(), axes, law, target_pose, scaled: task.scale })
}

/// Reads a law for a task of so many rows.
struct LawReader {
    rows: usize,
    pointer: String,
}

impl LawReader {
    fn law(&self, law: &wire::Law) -> Result<(Law, TargetPose), Problem> {
        match law {
            wire::Law::Velocity { target_velocity } => {
                Ok((Law::Velocity(self.profile(target_velocity, "target_velocity")?), TargetPose::Initial))
            }
            wire::Law::Force { inertia, damping, target_force } => {
                let gains = self.gains(inertia, damping, &vec![0.0; self.rows])?;
                let law = ForceLaw::new(gains, self.profile(target_force, "target_force")?);
                Ok((Law::Force(law.ok_or_else(|| self.mismatch())?), TargetPose::Initial))
            }
            wire::Law::Impedance { inertia, damping, stiffness, target_pose } => {
                let law = ImpedanceLaw::new(self.gains(inertia, damping, stiffness)?);
                Ok((Law::Impedance(law), self.target_pose(target_pose)?))
            }
            wire::Law::Hybrid { inertia, damping, stiffness, position_controlled, target_force, target_pose } => {
                let gains = self.gains(inertia, damping, stiffness)?;
                let force = self.profile(target_force, "target_force")?;
                if position_controlled.len() != self.rows {
                    return Err(self.size("position_controlled", position_controlled.len()));
                }
                let law = HybridLaw::new(gains, force, position_controlled.clone());
                Ok((Law::Hybrid(law.ok_or_else(|| self.mismatch())?), self.target_pose(target_pose)?))
            }
        }
    }

    fn gains(&self, inertia: &[f64], damping: &[f64], stiffness: &[f64]) -> Result<Gains, Problem> {
        numbers(inertia, &self.at("inertia"))?;
        numbers(damping, &self.at("damping"))?;
        numbers(stiffness, &self.at("stiffness"))?;
        Gains::new(self.rows, inertia, damping, stiffness).map_err(|error| match error {
            GainError::Size { gain, .. } => Problem::invalid(self.at(gain), error),
            GainError::Range { gain, row, .. } => Problem::invalid(format!("{}/{row}", self.at(gain)), error),
        })
    }

    fn profile(&self, profile: &wire::Profile, field: &str) -> Result<Profile, Problem> {
        let pointer = self.at(field);
        let list = |values: &[f64], name: &str| {
            if values.len() == self.rows {
                numbers(values, &format!("{pointer}/{name}"))
            } else {
                Err(self.size(&format!("{field}/{name}"), values.len()))
            }
        };
        let profile = match profile {
            wire::Profile::Constant { value } => Profile::constant(list(value, "value")?),
            wire::Profile::Sine { offset, amplitude, angular_frequency_rad_s, phase_rad } => Profile::sine(
                list(offset, "offset")?,
                list(amplitude, "amplitude")?,
                number(*angular_frequency_rad_s, &format!("{pointer}/angular_frequency_rad_s"))?,
                number(*phase_rad, &format!("{pointer}/phase_rad"))?,
            ),
        };
        profile.map_err(|error| Problem::invalid(pointer.clone(), error))
    }

    fn target_pose(&self, pose: &wire::TargetPose) -> Result<TargetPose, Problem> {
        let wire::TargetPose::Fixed(wire::Pose { position, orientation }) = pose else {
            return Ok(TargetPose::Initial);
        };
        let pointer = self.at("target_pose");
        numbers(position, &format!("{pointer}/position"))?;
        let quaternion = Quaternion::new(orientation.w, orientation.x, orientation.y, orientation.z);
        let length = quaternion.norm();
        if !((length - 1.0).abs() <= UNIT_LENGTH) {
            let detail = format!("a quaternion of length {length}; orientations have length 1");
            return Err(Problem::invalid(format!("{pointer}/orientation"), detail));
        }
        let rotation = UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix();
        let [x, y, z] = *position;
        Ok(TargetPose::Fixed(IsometryMatrix3::from_parts(Translation3::new(x, y, z), rotation)))
    }

    fn at(&self, field: &str) -> String {
        format!("{}/{field}", self.pointer)
    }

    fn size(&self, field: &str, given: usize) -> Problem {
        Problem::invalid(self.at(field), format!("{given} values for {} axes; give one per axis", self.rows))
    }

    /// Sizes are checked field by field; this is what is left to say if the law refuses all the same.
    fn mismatch(&self) -> Problem {
        Problem::invalid(
            self.pointer.clone(),
            format!("the lists of a law have one value for each of {} axes", self.rows),
        )
    }
}
