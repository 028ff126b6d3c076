//! The configuration of a controller and its checks.

use std::sync::Arc;

use revprio_robot::RobotModel;

use super::{NullSpaceError, NullSpaceMotion, TaskConfig, TaskConfigError};
use crate::limits::{Barrier, Drive, JointMotion, LimitKind, LimitedBox, MAX_DRIVE_DELAY, VelocityBox, robot_box};
use crate::linalg::Damping;
use crate::resolution::{Method, Solver};

/// Which body exerts the measured wrench on which. The laws use the wrench on the environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WrenchConvention {
    /// The wrench of the tool on the environment: pressing on a wall at +x gives a positive x force.
    #[default]
    OnEnvironment,
    /// The wrench of the environment on the tool, with the opposite sign. Most wrist sensors measure it.
    OnTool,
}

impl WrenchConvention {
    /// Returns the factor that converts a measured wrench to the wrench on the environment.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::OnEnvironment => 1.0,
            Self::OnTool => -1.0,
        }
    }
}

/// The axes along which the wrench is measured, at the tool point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WrenchFrame {
    /// The axes of the base.
    #[default]
    Base,
    /// The axes of the tool, as of a wrist sensor.
    Tool,
}

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

/// The limits of the joint velocities.
#[derive(Debug, Clone, PartialEq)]
pub enum Limits {
    /// The robot's own limits at the measured state.
    Robot(LimitKind),
    /// A box that does not depend on the state, n, rad/s.
    Fixed(VelocityBox),
}

/// Default of [`ControllerConfig::valid_for_ms`].
const DEFAULT_VALID_FOR_MS: u64 = 100;

impl Limits {
    /// Returns whether the speed limits of the robot are among them.
    pub fn include_speeds(&self) -> bool {
        matches!(self, Self::Robot(kind) if *kind != LimitKind::None)
    }

    /// Returns whether the acceleration limits of the robot are among them.
    pub fn include_accelerations(&self) -> bool {
        matches!(self, Self::Robot(kind) if kind.includes_acceleration())
    }

    /// Returns the allowed velocities at a state; `period`: T, s.
    pub fn at(&self, robot: &RobotModel, motion: JointMotion, period: f64) -> LimitedBox {
        match self {
            Self::Robot(kind) => robot_box(robot, *kind, motion, period),
            Self::Fixed(velocity_box) => LimitedBox { velocity_box: velocity_box.clone(), conflicts: Vec::new() },
        }
    }

    /// Updates `limited`, a result of [`Self::at`], to another state.
    pub(super) fn update(&self, limited: &mut LimitedBox, robot: &RobotModel, motion: JointMotion, period: f64) {
        if let Self::Robot(kind) = self {
            limited.update(robot, *kind, motion, period);
        }
    }
}

/// Part of the lag and the dead time that may differ from what is stated.
const MISSTATED: f64 = 0.2;

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
    /// Inequalities besides the limits.
    pub barriers: Vec<Barrier>,
    /// Which body exerts the measured wrench on which.
    pub wrench_convention: WrenchConvention,
    /// The axes along which the wrench is measured.
    pub wrench_frame: WrenchFrame,
    /// Joint motion in the null space of the tasks; `None`: rest.
    pub null_space: Option<NullSpaceMotion>,
    /// Whether a redundant arm leaves postures in which limits hold a task.
    pub leave_local_minima: bool,
    /// When integrators follow the achieved velocity.
    pub anti_windup: AntiWindup,
    /// The tasks, highest priority first.
    pub tasks: Vec<TaskConfig>,
}

impl ControllerConfig {
    /// Returns the damping of this loop, whose reaction time is the period and a part of what the drive adds: the loop acts on
    /// the position of rest, but no drive is exactly as stated.
    pub(super) fn fading_damping(&self) -> Option<Damping> {
        let reaction = self.period_s + MISSTATED * self.drive.time_to_rest(self.period_s);
        self.damping.map(|damping| damping.for_reaction(reaction))
    }

    /// Builds a configuration with the defaults, which are also those of a controller in JSON; `period_s`: T, s.
    ///
    /// The defaults: method `ReversePriority`, solver `Auto`, the damping [`Damping::ARM`], the position, velocity and
    /// acceleration limits of the robot, a characteristic length of 1 m, a slow drive, and [`NullSpaceMotion::default_for`] the tasks.
    pub fn new(robot: Arc<RobotModel>, period_s: f64, tasks: Vec<TaskConfig>) -> Self {
        Self {
            null_space: NullSpaceMotion::default_for(&robot, &tasks, Drive::CONSERVATIVE, period_s),
            leave_local_minima: true,
            robot,
            period_s,
            method: Method::ReversePriority,
            solver: Solver::Auto,
            damping: Some(Damping::ARM),
            characteristic_length_m: 1.0,
            limits: Limits::Robot(LimitKind::PositionVelocityAcceleration),
            drive: Drive::CONSERVATIVE,
            valid_for_ms: DEFAULT_VALID_FOR_MS,
            barriers: Vec::new(),
            wrench_convention: WrenchConvention::default(),
            wrench_frame: WrenchFrame::default(),
            anti_windup: AntiWindup::default(),
            tasks,
        }
    }
}

/// Why the configuration of a controller is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// T is not positive or not finite.
    #[error("the period must be a positive number of seconds, not {0}")]
    Period(f64),
    /// L is not positive or not finite.
    #[error("the characteristic length must be a positive number of metres, not {0}")]
    CharacteristicLength(f64),
    /// The list of tasks is empty.
    #[error("give at least one task")]
    NoTasks,
    /// Two tasks share a name.
    #[error("two tasks are named `{name}`; give each its own name")]
    DuplicateTask {
        /// Index of the second of the two tasks, from 0.
        task: usize,
        /// The repeated name.
        name: String,
    },
    /// The parts of a task do not fit each other or the robot.
    #[error("{source}")]
    Task {
        /// Index of the task, from 0.
        task: usize,
        /// What is wrong with it.
        source: TaskConfigError,
    },
    /// A barrier has the wrong number of coefficients, or names a joint that the robot does not have.
    #[error("inequality `{name}` does not fit a robot of {expected} joints")]
    Barrier {
        /// Index in the list, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// Joints of the robot.
        expected: usize,
    },
    /// The box has another number of joints than the robot.
    #[error("limits for {given} joints, but the robot has {expected}")]
    Limits {
        /// Joints of the robot.
        expected: usize,
        /// Joints of the box.
        given: usize,
    },
    /// The lag is negative or not finite, or the dead time is too long.
    #[error("the lag of the drive must be 0 s or more, its delay at most {MAX_DRIVE_DELAY} periods")]
    Drive,
    /// The null-space motion does not fit the robot or the period.
    #[error(transparent)]
    NullSpace(#[from] NullSpaceError),
}

impl ControllerConfig {
    /// Returns the limits of the robot that every command keeps; `None` for a fixed box, and for the solver `ClosedForm`,
    /// which ignores limits.
    pub fn kept_limits(&self) -> Option<LimitKind> {
        match self.limits {
            Limits::Robot(kind) if self.solver != Solver::ClosedForm => Some(kind),
            Limits::Robot(_) | Limits::Fixed(_) => None,
        }
    }

    /// Returns whether every command keeps the position limits of the robot.
    pub fn keeps_positions(&self) -> bool {
        self.kept_limits().is_some_and(LimitKind::includes_position)
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
        let joints = self.robot.joint_count();
        if let Some(index) = self.barriers.iter().position(|barrier| !barrier.fits(joints)) {
            let name = self.barriers[index].name().to_owned();
            return Err(ConfigError::Barrier { index, name, expected: joints });
        }
        for (index, task) in self.tasks.iter().enumerate() {
            if self.tasks[..index].iter().any(|earlier| earlier.name == task.name) {
                return Err(ConfigError::DuplicateTask { task: index, name: task.name.clone() });
            }
            let misfit = |source| ConfigError::Task { task: index, source };
            task.check(&self.robot, self.period_s).map_err(misfit)?;
        }
        match &self.null_space {
            Some(motion) => Ok(motion.check(&self.robot, self.period_s)?),
            None => Ok(()),
        }
    }
}
