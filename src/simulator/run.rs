//! One run of a scenario against a service.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use super::caller::Caller;
use super::flaw::Flaw;
use super::line::Line;
use super::plant::Plant;
use super::recording::{Recording, Timing};
use super::scenario::Scenario;
use super::watchdog::{Obeyed, is_silence, pause};
use crate::client::{Client, ClientError};
use crate::kinematics::{ConfigurationError, NotUnitLength, pose};
use crate::robot::{ModelError, RobotModel, built_in};
use crate::wire;

/// Who keeps the controller's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CallMode {
    /// The service, in a session.
    #[default]
    Session,
    /// The caller: it travels with every request.
    Stateless,
}

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The simulator has no such arm.
    #[error("the simulator has no robot `{name}`; known: {known}; or give its file")]
    UnknownRobot {
        /// The name.
        name: String,
        /// Those that ship with the crate.
        known: String,
    },
    /// The tool offset has no orientation.
    #[error("controller.tool_offset: {0}")]
    ToolOrientation(#[from] NotUnitLength),
    /// The tool offset is not finite.
    #[error("controller.tool_offset: {0}")]
    Tool(#[from] ModelError),
    /// The start posture does not fit the robot.
    #[error("start_joint_position: {0}")]
    Start(ConfigurationError),
    /// A quantity of the scenario makes no sense.
    #[error("{0}")]
    Scenario(Flaw),
    /// The arm left the range of numbers, which no service should command.
    #[error("at t = {time_s} s: {source}")]
    Diverged {
        /// Simulated time, s.
        time_s: f64,
        /// What is wrong with the posture.
        source: ConfigurationError,
    },
    /// The service's robot of that name is another one.
    #[error(
        "at t = {time_s} s: {given} joint velocities for {expected} joints; the service knows another robot of that name"
    )]
    AnswerSize {
        /// Simulated time, s.
        time_s: f64,
        /// Joints of the simulated arm.
        expected: usize,
        /// Velocities in the answer.
        given: usize,
    },
    /// The caller asked for the end.
    #[error("stopped at t = {time_s} s")]
    Stopped {
        /// Simulated time, s.
        time_s: f64,
    },
    /// The service gave no answer.
    #[error("at t = {time_s} s: {source}")]
    Service {
        /// Simulated time, s.
        time_s: f64,
        /// Why.
        source: ClientError,
    },
}

impl From<Flaw> for RunError {
    fn from(flaw: Flaw) -> Self {
        Self::Scenario(flaw)
    }
}

/// Runs the scenario with a robot that ships with the crate, one call per control period; `progress` hears of every
/// period that is done and may end the run.
pub fn run(
    scenario: &Scenario,
    client: &Client,
    mode: CallMode,
    progress: impl FnMut(u64) -> ControlFlow<()>,
) -> Result<Recording, RunError> {
    run_robot(&built_in_robot(&scenario.controller.robot)?, scenario, client, mode, progress)
}

fn built_in_robot(name: &str) -> Result<Arc<RobotModel>, RunError> {
    let robot = built_in().iter().find(|robot| robot.name() == name).cloned();
    robot.ok_or_else(|| {
        let known: Vec<&str> = built_in().iter().map(|robot| robot.name()).collect();
        RunError::UnknownRobot { name: name.to_owned(), known: known.join(", ") }
    })
}

/// Runs the scenario with any robot; the service must know the same one by the name in the scenario's controller.
///
/// A service that falls silent in the middle does not end the run: the arm obeys the last answer for as long as that is
/// valid, slows down to rest, and goes on with the next answer. Meanwhile periods take as long as they really do.
pub fn run_robot(
    robot: &Arc<RobotModel>,
    scenario: &Scenario,
    client: &Client,
    mode: CallMode,
    mut progress: impl FnMut(u64) -> ControlFlow<()>,
) -> Result<Recording, RunError> {
    let robot = with_tool(robot, &scenario.controller)?;
    let mut plant = Plant::new(scenario, &robot)?;
    let mut line = Line::new(scenario.faults.clone(), scenario.seed);
    let mut caller =
        Caller::open(&scenario.controller, client, mode).map_err(|source| RunError::Service { time_s: 0.0, source })?;
    let start = Instant::now();
    let (mut samples, mut timings) = (Vec::new(), Vec::new());
    let mut obeyed: Option<Obeyed> = None;
    for period in 0..scenario.cycles() {
        let time_s = period as f64 * scenario.period_s();
        let measured = plant.measure(time_s);
        let called = Instant::now();
        let answer = (!line.is_dead(time_s)).then(|| caller.call(measured.state(period, time_s)));
        let round_trip_us = answer.as_ref().map_or(0.0, |_| called.elapsed().as_secs_f64() * 1e6);
        let answer = match answer.transpose() {
            Err(error) if is_silence(&error) && obeyed.is_some() => {
                if pause(scenario.period_s(), || progress(period)).is_break() {
                    return Err(RunError::Stopped { time_s });
                }
                None
            }
            answer => answer.map_err(|source| RunError::Service { time_s, source })?,
        };
        let now = match (line.pass(period, answer), obeyed) {
            (Some(mut answer), _) => {
                caller.keep_memory(&mut answer);
                Obeyed::new(answer, scenario.period_s())
            }
            (None, Some(before)) => before.still(time_s, &robot, scenario.period_s()),
            (None, None) => return Err(Flaw::new("/faults", "leave the first state without an answer").into()),
        };
        let (expected, given) = (robot.joint_count(), now.answer.joint_velocity.len());
        if given != expected {
            return Err(RunError::AnswerSize { time_s, expected, given });
        }
        timings.push(Timing { round_trip_us, elapsed_us: now.answer.elapsed_us });
        samples.push(plant.sample(period, time_s, measured, &now, &scenario.controller.tasks));
        plant.advance(&now.answer.joint_velocity, time_s)?;
        obeyed = Some(now);
        if progress(period + 1).is_break() {
            return Err(RunError::Stopped { time_s });
        }
    }
    Ok(Recording {
        scenario: scenario.name.clone(),
        method: scenario.controller.method,
        solver: scenario.controller.solver,
        period_s: scenario.period_s(),
        wall_time_s: start.elapsed().as_secs_f64(),
        joint_names: plant.joint_names().to_vec(),
        energy: plant.energy(),
        setup: Some(Box::new(scenario.clone())),
        samples,
        timings,
    })
}

/// The arm with its tool point where the controller says.
fn with_tool(robot: &Arc<RobotModel>, controller: &wire::Controller) -> Result<Arc<RobotModel>, RunError> {
    let Some(wire::Pose { position, orientation: wire::Orientation { w, x, y, z } }) = controller.tool_offset else {
        return Ok(Arc::clone(robot));
    };
    Ok(Arc::new(robot.with_tool_offset(&pose(position, [w, x, y, z])?)?))
}
