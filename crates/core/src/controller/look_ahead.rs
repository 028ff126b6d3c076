//! Postures that the arm will have: the position of rest behind the drive, and that of the next period.

use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Configuration, ConfigurationError};

use super::ControllerConfig;
use crate::law::Law;
use crate::limits::{Ahead, Inequality, JointBraking};

/// The workspace of a controller that acts at the position of rest p.
///
/// Where a command depends on the posture, it must be the posture that the arm will have. That of a stretched arm changes so
/// steeply with the posture that lag and dead time would make the arm swing. Laws that follow no position, without planes
/// and null-space motions, act on the measured posture: their equations then are those of the literature.
pub(super) struct ArmAtRest {
    configuration: Configuration,
    /// p, n.
    position: Vec<f64>,
}

impl ArmAtRest {
    /// Returns the workspace of a controller; `None` if its drive follows at once, or if nothing follows positions.
    /// `configuration`: of its robot, at any posture.
    pub fn new(config: &ControllerConfig, configuration: &Configuration) -> Option<Self> {
        let position = vec![0.0; config.robot.joint_count()];
        let is_late = config.drive.time_to_rest(config.period_s) > 0.0;
        let follows = config.tasks.iter().any(|task| matches!(task.law, Law::Position(_)));
        (is_late && (follows || config.null_space.is_some() || has_planes(config)))
            .then(|| Self { configuration: configuration.clone(), position })
    }

    /// Updates to a measured position (q, n) and the distance to rest from there (p − q, n).
    pub fn update(
        &mut self,
        robot: &RobotModel,
        position: &[f64],
        distance_to_rest: &[f64],
    ) -> Result<&Configuration, ConfigurationError> {
        for (rest, (position, distance)) in self.position.iter_mut().zip(position.iter().zip(distance_to_rest)) {
            *rest = position + distance;
        }
        self.configuration.update(robot, &self.position)?;
        Ok(&self.configuration)
    }
}

/// The workspace of a controller with planes: the arm at m = p + ½ T q̇⁻; see
/// [`Ahead`].
pub(super) struct LookAhead {
    configuration: Configuration,
    /// m, n.
    position: Vec<f64>,
}

impl LookAhead {
    /// Returns the workspace of a controller; `None` if it has no plane. `configuration`: of its robot, at any posture.
    pub fn new(config: &ControllerConfig, configuration: &Configuration) -> Option<Self> {
        let position = vec![0.0; config.robot.joint_count()];
        has_planes(config).then(|| Self { configuration: configuration.clone(), position })
    }

    /// Updates to the arm at p and the last command (q̇⁻, n).
    pub fn update<'a>(
        &'a mut self,
        config: &ControllerConfig,
        rest: &'a Configuration,
        last_command: &'a [f64],
    ) -> Result<Ahead<'a>, ConfigurationError> {
        for (half_way, (p, speed)) in self.position.iter_mut().zip(rest.joint_position().iter().zip(last_command)) {
            *half_way = p + 0.5 * config.period_s * speed;
        }
        self.configuration.update(&config.robot, &self.position)?;
        Ok(Ahead { rest, half_way: &self.configuration, last_command })
    }
}

impl ControllerConfig {
    /// Overwrites the inequalities of the barriers with those of this period, see [`Barrier::write`](crate::limits::Barrier::write).
    pub(super) fn write_barriers(
        &self,
        configuration: &Configuration,
        ahead: Option<Ahead>,
        braking: Option<JointBraking>,
        inequalities: &mut [Inequality],
    ) {
        for (barrier, inequality) in self.barriers.iter().zip(inequalities) {
            barrier.write(configuration, ahead, braking, inequality);
        }
    }
}

fn has_planes(config: &ControllerConfig) -> bool {
    config.barriers.iter().any(|barrier| barrier.constant().is_none())
}
