//! What the arm measures.

use super::step_error::StepError;
use crate::collision::ObstacleState;
use crate::constraint;
use crate::controller::config::ControllerConfig;
use crate::streaming::StreamedTarget;

/// The measured state of one period.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// t, time of the caller, s.
    pub time_s: f64,
    /// q, joint position, n, rad or m.
    pub joint_position: Vec<f64>,
    /// q̇, joint velocity, n; `None` if it is not measured: the last command replaces it, at the first step zero.
    pub joint_velocity: Option<Vec<f64>>,
    /// Force (N), then torque (N·m), at the tool point, in the controller's wrench convention and frame.
    pub wrench: [f64; 6],
    /// Streamed targets that arrived since the last measurement, at most one per task and quantity; usually none.
    pub targets: Vec<StreamedTarget>,
    /// Where the moving obstacles of the controller are; each must be named.
    pub obstacles: Vec<ObstacleState>,
}

impl Measurement {
    /// Checks that the sizes fit the robot, that the numbers are finite, and that the targets fit their tasks.
    pub(in crate::controller) fn check(&self, config: &ControllerConfig) -> Result<(), StepError> {
        let expected = config.robot.joint_count();
        let fits = |v: &Vec<f64>| v.len() == expected && v.iter().all(|entry| entry.is_finite());
        if !self.joint_velocity.as_ref().is_none_or(fits) {
            return Err(StepError::JointVelocity { expected });
        }
        let finite = self.time_s.is_finite() && self.wrench.iter().all(|entry| entry.is_finite());
        if !finite {
            return Err(StepError::NotFinite);
        }
        self.check_obstacles(config)?;
        for (index, target) in self.targets.iter().enumerate() {
            target.check(config, self.time_s).map_err(|source| StepError::Target { index, source })?;
        }
        Ok(())
    }

    /// Checks that each moving obstacle has a finite position and velocity, and that no other one is named.
    fn check_obstacles(&self, config: &ControllerConfig) -> Result<(), StepError> {
        let known = constraint::distances(&config.constraints).map_or(&[][..], |(avoidance, _)| &avoidance.obstacles);
        for (index, state) in self.obstacles.iter().enumerate() {
            let name = || state.name.to_string();
            if !known.iter().any(|obstacle| obstacle.moves && obstacle.name == state.name) {
                return Err(StepError::UnknownObstacle { index, name: name() });
            }
            if self.obstacles[..index].iter().any(|earlier| earlier.name == state.name) {
                return Err(StepError::ObstacleTwice { index, name: name() });
            }
            state.check().map_err(|source| StepError::Obstacle { index, name: name(), source })?;
        }
        let is_named = |name: &str| self.obstacles.iter().any(|state| &*state.name == name);
        match known.iter().find(|obstacle| obstacle.moves && !is_named(&obstacle.name)) {
            Some(missing) => Err(StepError::MissingObstacle { name: missing.name.to_string() }),
            None => Ok(()),
        }
    }
}
