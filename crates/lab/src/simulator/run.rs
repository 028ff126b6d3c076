//! One run of a scenario against a service.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use revprio_api::wire;
use revprio_api::{ClientError, Service};
use revprio_robot::kinematics::{ConfigurationError, NotUnitLength, pose};
use revprio_robot::{ModelError, RobotModel, built_in};

use super::caller::Caller;
use super::field_error::FieldError;
use super::lossy_channel::LossyChannel;
use super::operator::{Cycle, Ending, Influence, Observed, Operator, ProgressObserver};
use super::plant::Plant;
use super::recording::{Recording, Timing};
use super::scenario::Scenario;
use super::watchdog::{HeldCommand, is_silence, pause};

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
    Scenario(FieldError),
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

impl From<FieldError> for RunError {
    fn from(flaw: FieldError) -> Self {
        Self::Scenario(flaw)
    }
}

/// Runs the scenario with a robot that ships with the crate, one call per control period; `progress` hears of every
/// period that is done and may end the run.
pub fn run(
    scenario: &Scenario,
    service: &dyn Service,
    mode: CallMode,
    progress: impl FnMut(u64) -> ControlFlow<()>,
) -> Result<Recording, RunError> {
    run_robot(&built_in_robot(&scenario.controller.robot)?, scenario, service, mode, progress)
}

/// A robot that ships with the crate.
pub fn built_in_robot(name: &str) -> Result<Arc<RobotModel>, RunError> {
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
    service: &dyn Service,
    mode: CallMode,
    progress: impl FnMut(u64) -> ControlFlow<()>,
) -> Result<Recording, RunError> {
    drive(robot, scenario, service, mode, &mut ProgressObserver::new(progress))
}

/// Runs the scenario as an operator wants it.
///
/// The controller's memory travels with every request, so that a changed controller continues where the one before stood.
pub fn run_operated(
    robot: &Arc<RobotModel>,
    scenario: &Scenario,
    service: &dyn Service,
    operator: &mut impl Operator,
) -> Result<Recording, RunError> {
    drive(robot, scenario, service, CallMode::Stateless, operator)
}

fn drive(
    robot: &Arc<RobotModel>,
    scenario: &Scenario,
    service: &dyn Service,
    mode: CallMode,
    operator: &mut impl Operator,
) -> Result<Recording, RunError> {
    let robot = with_tool(robot, &scenario.controller)?;
    let mut plant = Plant::new(scenario, &robot)?;
    let caller = Caller::open(&scenario.controller, service, mode);
    let caller = caller.map_err(|source| RunError::Service { time_s: 0.0, source })?;
    let line = LossyChannel::new(scenario.faults.clone(), scenario.seed);
    let mut conversation = Conversation { caller, line, robot, period_s: scenario.period_s(), obeyed: None };
    let start = Instant::now();
    let (mut samples, mut timings) = (Vec::new(), Vec::new());
    for period in 0..scenario.cycles() {
        let time_s = period as f64 * scenario.period_s();
        let Influence { external_force, controller } = operator.influence(period);
        if let Some(controller) = controller {
            conversation.caller.change(controller);
        }
        let measured = plant.measure(time_s, external_force);
        let (now, cycle, round_trip) =
            conversation.next(measured.state(period, time_s), || unit(operator.goes_on()))?;
        let sample = plant.sample(period, time_s, measured, now, &scenario.controller.tasks);
        plant.advance(&now.answer.joint_velocity, time_s)?;
        operator.see(period + 1, &Observed { sample: &sample, answer: &now.answer, round_trip, cycle });
        samples.push(sample);
        timings.push(Timing { round_trip_us: round_trip.as_secs_f64() * 1e6, elapsed_us: now.answer.elapsed_us });
        match operator.goes_on() {
            ControlFlow::Continue(()) => (),
            ControlFlow::Break(Ending::Finish) => break,
            ControlFlow::Break(Ending::Stop) => return Err(RunError::Stopped { time_s }),
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

fn unit(goes_on: ControlFlow<Ending>) -> ControlFlow<()> {
    goes_on.map_break(|_| ())
}

/// Caller and line, and the answer that the arm obeys.
struct Conversation<'a> {
    caller: Caller<'a>,
    line: LossyChannel,
    robot: Arc<RobotModel>,
    period_s: f64,
    obeyed: Option<HeldCommand>,
}

impl Conversation<'_> {
    /// What the arm obeys in the period of a state, what the service was asked, and how long it took to answer.
    fn next(
        &mut self,
        state: wire::State,
        goes_on: impl FnMut() -> ControlFlow<()>,
    ) -> Result<(&HeldCommand, Option<Cycle<'_>>, Duration), RunError> {
        let (period, time_s) = (state.sequence, state.time_s);
        let is_dead = self.line.is_dead(time_s);
        let called = Instant::now();
        let answer = if is_dead { Ok(None) } else { self.caller.call(state).map(Some) };
        let round_trip = if is_dead { Duration::ZERO } else { called.elapsed() };
        let answer = match answer {
            Err(error) if is_silence(&error) && self.obeyed.is_some() => {
                if pause(self.period_s, goes_on).is_break() {
                    return Err(RunError::Stopped { time_s });
                }
                None
            }
            answer => answer.map_err(|source| RunError::Service { time_s, source })?,
        };
        let was_answered = answer.is_some();
        let arrived = self.line.pass(period, answer);
        if was_answered && arrived.as_ref().is_none_or(|answer| answer.sequence < period) {
            self.caller.lose();
        }
        let now = match (arrived, self.obeyed.take()) {
            (Some(answer), _) => HeldCommand::new(answer, self.period_s),
            (None, Some(before)) => before.still(time_s, &self.robot, self.period_s),
            (None, None) => return Err(FieldError::new("/faults", "leaves the first state without an answer").into()),
        };
        let (expected, given) = (self.robot.joint_count(), now.answer.joint_velocity.len());
        if given != expected {
            return Err(RunError::AnswerSize { time_s, expected, given });
        }
        Ok((self.obeyed.insert(now), self.caller.cycle(), round_trip))
    }
}

/// The arm with its tool point where the controller says.
fn with_tool(robot: &Arc<RobotModel>, controller: &wire::Controller) -> Result<Arc<RobotModel>, RunError> {
    let Some(wire::Pose { position, orientation: wire::Orientation { w, x, y, z } }) = controller.tool_offset else {
        return Ok(Arc::clone(robot));
    };
    Ok(Arc::new(robot.with_tool_offset(&pose(position, [w, x, y, z])?)?))
}
