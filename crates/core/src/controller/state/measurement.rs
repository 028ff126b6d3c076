//! What the arm measures.

use super::step_error::StepError;
use crate::channel::ChannelInput;
use crate::collision::ObstacleState;
use crate::constraint;
use crate::controller::config::ControllerConfig;
use crate::streaming::{StreamedChunk, StreamedTarget};

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
    /// The wrenches of other tips that are measured, at most one per tip; usually none. A tip that is not named measures zero.
    pub wrenches: Vec<TipWrench>,
    /// Streamed targets that arrived since the last measurement, at most one per task and quantity; usually none.
    pub targets: Vec<StreamedTarget>,
    /// Chunks of actions that arrived since the last measurement; usually none.
    pub chunks: Vec<StreamedChunk>,
    /// What arrived for the channels; usually nothing.
    pub channels: Vec<ChannelInput>,
    /// Where the moving obstacles of the controller are; each must be named.
    pub obstacles: Vec<ObstacleState>,
}

/// A wrench at a tip that is not the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipWrench {
    /// Index of the tip in [`RobotModel::tips`](revprio_robot::RobotModel::tips), from 1.
    pub tip: usize,
    /// Force (N), then torque (N·m), at the tip, in the controller's wrench convention and frame.
    pub wrench: [f64; 6],
}

impl Measurement {
    /// Checks that the sizes fit the robot, that the numbers are finite, and that the targets fit their tasks.
    pub(in crate::controller) fn check(&self, config: &ControllerConfig) -> Result<(), StepError> {
        let expected = config.robot.joint_count();
        let fits = |v: &Vec<f64>| v.len() == expected && v.iter().all(|entry| entry.is_finite());
        if !self.joint_velocity.as_ref().is_none_or(fits) {
            return Err(StepError::JointVelocity { expected });
        }
        let wrenches = self.wrenches.iter().map(|measured| &measured.wrench).chain([&self.wrench]);
        if !(self.time_s.is_finite() && wrenches.flatten().all(|entry| entry.is_finite())) {
            return Err(StepError::NotFinite);
        }
        let numbers = |input: &ChannelInput| input.measured.into_iter().chain(input.target).all(f64::is_finite);
        if !self.channels.iter().all(|input| input.channel < config.channels.len() && numbers(input)) {
            return Err(StepError::Channel);
        }
        self.check_tips(config.robot.tips().len())?;
        self.check_obstacles(config)?;
        for (index, target) in self.targets.iter().enumerate() {
            target.check(config, self.time_s).map_err(|source| StepError::Target { index, source })?;
        }
        for (index, chunk) in self.chunks.iter().enumerate() {
            chunk.check(config, self.time_s).map_err(|source| StepError::Chunk { index, source })?;
        }
        Ok(())
    }

    /// Returns the wrench that is measured at a tip; `None`: it has none.
    pub(in crate::controller) fn wrench_at(&self, tip: usize) -> Option<&[f64; 6]> {
        let other = || self.wrenches.iter().find(|measured| measured.tip == tip).map(|measured| &measured.wrench);
        if tip == 0 { Some(&self.wrench) } else { other() }
    }

    /// Checks that each wrench is that of another tip than the tool.
    fn check_tips(&self, tips: usize) -> Result<(), StepError> {
        for (index, measured) in self.wrenches.iter().enumerate() {
            let is_known = (1..tips).contains(&measured.tip);
            if !is_known || self.wrenches[..index].iter().any(|earlier| earlier.tip == measured.tip) {
                return Err(StepError::WrenchTip { tip: measured.tip, tips });
            }
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
