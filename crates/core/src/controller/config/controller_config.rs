//! The configuration of a controller and its checks.

use std::sync::Arc;

use revprio_robot::RobotModel;

use super::config_error::ConfigError;
use super::null_space::NullSpaceMotion;
use super::task::TaskConfig;
use super::velocity_limits::Limits;
use crate::channel::ChannelConfig;
use crate::collision::CollisionAvoidanceError;
use crate::constraint::{self, Constraint, MAX_CONSTRAINT_ROWS};
use crate::limits::{Drive, LimitKind, MAX_DRIVE_DELAY};
use crate::linalg::Damping;
use crate::resolution::{Method, Solver};
use crate::wrench::{WrenchConvention, WrenchFrame, WrenchSensor, WrenchSensorError};

/// When the integrators of force, impedance and hybrid laws follow the achieved velocity instead of the requested one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AntiWindup {
    /// On every axis that does not follow its request, whatever holds it back: limits, other tasks or damping.
    #[default]
    Always,
    /// As `Always`, but not if damping alone holds the axis back, and requests have no bound. The laws of the paper behave
    /// so. Near a singularity a damped task then winds up. Do not use it on a real arm.
    ExceptDamping,
}

/// Default of [`ControllerConfig::valid_for_ms`]: some missed answers of a loop of 10 ms do not stop the arm, and an arm whose
/// controller is gone starts to brake before a person notices.
const DEFAULT_VALID_FOR_MS: u64 = 100;

/// The configuration of a controller: everything that is constant over its periods.
#[derive(Debug, Clone, PartialEq)]
pub struct ControllerConfig {
    /// The arm.
    pub robot: Arc<RobotModel>,
    /// T, control period, s.
    pub period_s: f64,
    /// The meaning of priorities.
    pub method: Method,
    /// The solver of each period's problem.
    pub solver: Solver,
    /// Damping near singularities; `None`: no damping.
    pub damping: Option<Damping>,
    /// L, m. Linear rows of the tool are divided by it, so 1 m/s counts as 1/L rad/s in singular values, in damping and where
    /// the rows of a task are weighed against each other.
    pub characteristic_length_m: f64,
    /// The limits of the joint velocities.
    pub limits: Limits,
    /// The drive of the joints. Limits of position and planes hold behind it.
    pub drive: Drive,
    /// Longest time from a state on for which its command may be held, ms.
    pub valid_for_ms: u64,
    /// Inequalities besides the limits, at most [`MAX_CONSTRAINT_ROWS`] rows in total.
    pub constraints: Vec<Constraint>,
    /// Which body exerts the measured wrench on which.
    pub wrench_convention: WrenchConvention,
    /// The axes along which the wrench is measured.
    pub wrench_frame: WrenchFrame,
    /// The sensors whose readings are corrected, at most one per tip. The wrench of another tip is taken as it is.
    pub wrench_sensors: Vec<WrenchSensor>,
    /// Joint motion in the null space of the tasks; `None`: rest.
    pub null_space: Option<NullSpaceMotion>,
    /// Whether a redundant arm leaves postures in which limits hold a task.
    pub leave_local_minima: bool,
    /// When integrators follow the achieved velocity.
    pub anti_windup: AntiWindup,
    /// The tasks, highest priority first.
    pub tasks: Vec<TaskConfig>,
    /// Channels besides the joints, such as a gripper.
    pub channels: Vec<ChannelConfig>,
}

impl ControllerConfig {
    /// Builds a configuration with the defaults, which are also those of a controller in JSON; `period_s`: T, s.
    ///
    /// The defaults: method `StrictReversePriority`, solver `Auto`, the damping [`Damping::ARM`], the position, velocity and
    /// acceleration limits of the robot, a characteristic length of 1 m, a slow drive, and [`NullSpaceMotion::default_for`] the tasks.
    pub fn new(robot: Arc<RobotModel>, period_s: f64, tasks: Vec<TaskConfig>) -> Self {
        Self {
            null_space: NullSpaceMotion::default_for(&robot, &tasks, Drive::CONSERVATIVE, period_s),
            leave_local_minima: true,
            robot,
            period_s,
            method: Method::StrictReversePriority,
            solver: Solver::Auto,
            damping: Some(Damping::ARM),
            characteristic_length_m: 1.0,
            limits: Limits::Robot(LimitKind::PositionVelocityAcceleration),
            drive: Drive::CONSERVATIVE,
            valid_for_ms: DEFAULT_VALID_FOR_MS,
            constraints: Vec::new(),
            wrench_convention: WrenchConvention::default(),
            wrench_frame: WrenchFrame::default(),
            wrench_sensors: Vec::new(),
            anti_windup: AntiWindup::default(),
            tasks,
            channels: Vec::new(),
        }
    }

    /// Checks that the parts fit each other.
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        if !(self.period_s.is_finite() && self.period_s > 0.0) {
            return Err(ConfigError::Period(self.period_s));
        }
        let length = self.characteristic_length_m;
        if !(length.is_finite() && length > 0.0) {
            return Err(ConfigError::CharacteristicLength(length));
        }
        if self.tasks.is_empty() {
            return Err(ConfigError::NoTasks);
        }
        if let Limits::Fixed(velocity_box) = &self.limits {
            let (expected, given) = (self.robot.joint_count(), velocity_box.joint_count());
            if expected != given {
                return Err(ConfigError::Limits { expected, given });
            }
        }
        let Drive { lag_s, delay_periods } = self.drive;
        if !(lag_s.is_finite() && lag_s >= 0.0 && delay_periods <= MAX_DRIVE_DELAY) {
            return Err(ConfigError::Drive);
        }
        ChannelConfig::check_all(&self.channels).map_err(|(index, source)| ConfigError::Channel { index, source })?;
        let joints = self.robot.joint_count();
        self.check_sensors()?;
        self.check_collisions()?;
        if let Some(index) = self.constraints.iter().position(|constraint| !constraint.fits(&self.robot)) {
            let name = self.constraints[index].name().to_owned();
            return Err(ConfigError::Constraint { index, name, expected: joints });
        }
        let given = self.constraints.iter().map(Constraint::row_count).sum();
        if given > MAX_CONSTRAINT_ROWS {
            return Err(ConfigError::ConstraintRows { given });
        }
        for (index, task) in self.tasks.iter().enumerate() {
            if self.tasks[..index].iter().any(|earlier| earlier.name == task.name) {
                return Err(ConfigError::DuplicateTask { task: index, name: task.name.clone() });
            }
            let misfit = |source| ConfigError::Task { task: index, source };
            task.check(&self.robot, self.period_s).map_err(misfit)?;
            if task.law.bounds().is_none() && task.path() != self.path() {
                return Err(ConfigError::Path { task: index });
            }
        }
        self.check_surfaces()?;
        if self.path().is_some() && !self.joint_capability().is_known() {
            return Err(ConfigError::Unplanned);
        }
        match &self.null_space {
            Some(motion) => Ok(motion.check(&self.robot, self.period_s)?),
            None => Ok(()),
        }
    }

    /// Checks that no frame follows two surfaces.
    fn check_surfaces(&self) -> Result<(), ConfigError> {
        let follows = |task: &TaskConfig| task.law.contact().is_some_and(|law| law.surface().is_some());
        for (task, of) in self.tasks.iter().enumerate().filter(|(_, task)| follows(task)) {
            let is_same = |earlier: &TaskConfig| follows(earlier) && earlier.rows.has_axes_of(&of.rows);
            if self.tasks[..task].iter().any(is_same) {
                return Err(ConfigError::Surfaces { task });
            }
        }
        Ok(())
    }

    /// Checks the sensors, and that no tip has two.
    fn check_sensors(&self) -> Result<(), ConfigError> {
        for (index, sensor) in self.wrench_sensors.iter().enumerate() {
            let is_taken = self.wrench_sensors[..index].iter().any(|earlier| earlier.tip == sensor.tip);
            let is_known = sensor.tip < self.robot.tips().len() && !is_taken;
            let checked = if is_known { sensor.check() } else { Err(WrenchSensorError::Tip) };
            checked.map_err(|source| ConfigError::WrenchSensor { index, source })?;
        }
        Ok(())
    }

    /// Checks that the controller can keep clear of obstacles, if it shall.
    fn check_collisions(&self) -> Result<(), ConfigError> {
        let Some((avoidance, _)) = constraint::distances(&self.constraints) else { return Ok(()) };
        if self.constraints.iter().filter_map(Constraint::distances).count() > 1 {
            return Err(ConfigError::CollisionsTwice);
        }
        if !self.keeps_positions() {
            return Err(CollisionAvoidanceError::Limits.into());
        }
        Ok(avoidance.check(&self.robot, self.period_s)?)
    }
}
