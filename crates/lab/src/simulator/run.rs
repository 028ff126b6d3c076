//! Runs a scenario against a service.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use revprio_api::Service;
use revprio_api::clock::Instant;
use revprio_api::wire;
use revprio_robot::kinematics::pose;
use revprio_robot::{RobotModel, built_in};

use super::callee::Callee;
use super::caller::{CallMode, Caller};
use super::field_error::FieldError;
use super::lossy_channel::LossyChannel;
use super::operator::{Ending, Influence, Observed, Operator, ProgressObserver};
use super::plant::Plant;
use super::recording::{ClarabelLevels, Recording, Sample, Timing};
use super::run_error::RunError;
use super::scenario::Scenario;
use super::stateless::Cycle;
use super::target_program::TargetPrograms;
use super::watchdog::{HeldCommand, is_missing_answer, pause};

/// Runs the scenario with a robot that ships with the crate, with one call per control period. `progress` receives the
/// number of completed periods and may end the run.
pub fn run(
    scenario: &Scenario,
    service: &dyn Service,
    mode: CallMode,
    progress: impl FnMut(u64) -> ControlFlow<()>,
) -> Result<Recording, RunError> {
    run_robot(&built_in_robot(&scenario.controller.robot)?, scenario, service, mode, progress)
}

/// Returns a robot that ships with the crate.
pub fn built_in_robot(name: &str) -> Result<Arc<RobotModel>, RunError> {
    let robot = built_in().iter().find(|robot| robot.name() == name).cloned();
    robot.ok_or_else(|| {
        let known: Vec<&str> = built_in().iter().map(|robot| robot.name()).collect();
        RunError::UnknownRobot { name: name.to_owned(), known: known.join(", ") }
    })
}

/// Runs the scenario with any robot. The service must know the same robot by the name in the scenario's controller.
///
/// If the service stops answering, the run continues: the arm executes the last answer while it is valid, then ramps to
/// rest, and continues with the next answer. Without answers, the run proceeds in real time.
pub fn run_robot(
    robot: &Arc<RobotModel>,
    scenario: &Scenario,
    service: &dyn Service,
    mode: CallMode,
    progress: impl FnMut(u64) -> ControlFlow<()>,
) -> Result<Recording, RunError> {
    drive(robot, scenario, service, mode, &mut ProgressObserver::new(progress))
}

/// Runs the scenario under an operator.
///
/// The memory of the controller is sent with every request, so that a changed controller continues from the state of the
/// previous one.
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
    let mut run = SteppedRun::begin(robot, scenario.clone(), Callee::Borrowed(service), mode)?;
    for _ in 0..scenario.cycles() {
        if run.step(operator)?.is_break() {
            break;
        }
    }
    Ok(run.finish())
}

/// A run that its caller takes from period to period, for callers that cannot wait, such as the event loop of a browser.
pub struct SteppedRun<'a> {
    scenario: Scenario,
    /// The tasks of the controller, which an operator may have changed.
    tasks: Vec<wire::ControllerTask>,
    plant: Plant,
    streams: TargetPrograms,
    conversation: Conversation<'a>,
    start: Instant,
    clarabel: ClarabelLevels,
    samples: Vec<Sample>,
    timings: Vec<Timing>,
}

impl<'a> SteppedRun<'a> {
    /// Begins a run under an operator, as [`run_operated`].
    pub fn operated(
        robot: &Arc<RobotModel>,
        scenario: Scenario,
        service: Box<dyn Service>,
    ) -> Result<SteppedRun<'static>, RunError> {
        SteppedRun::begin(robot, scenario, Callee::Owned(service), CallMode::Stateless)
    }

    fn begin(
        robot: &Arc<RobotModel>,
        scenario: Scenario,
        service: Callee<'a>,
        mode: CallMode,
    ) -> Result<Self, RunError> {
        let robot = with_tool(robot, &scenario.controller)?;
        let plant = Plant::new(&scenario, &robot)?;
        let streams = TargetPrograms::new(&scenario.target_programs, &scenario.controller)?;
        let caller = Caller::open(&scenario.controller, service, mode);
        let caller = caller.map_err(|source| RunError::Service { time_s: 0.0, source })?;
        let channel = LossyChannel::new(scenario.faults.clone(), scenario.seed);
        let conversation = Conversation { caller, channel, robot, period_s: scenario.period_s(), held: None };
        let (start, clarabel, tasks) = (Instant::now(), ClarabelLevels::default(), scenario.controller.tasks.clone());
        Ok(Self {
            scenario,
            tasks,
            plant,
            streams,
            conversation,
            start,
            clarabel,
            samples: Vec::new(),
            timings: Vec::new(),
        })
    }

    /// Runs the next period. Returns whether the run continues.
    pub fn step(&mut self, operator: &mut impl Operator) -> Result<ControlFlow<()>, RunError> {
        let Self { scenario, tasks, plant, streams, conversation, clarabel, samples, timings, .. } = self;
        let period = samples.len() as u64;
        let time_s = period as f64 * scenario.period_s();
        let Influence { external_force, controller, targets } = operator.influence(period);
        if let Some(controller) = controller {
            tasks.clone_from(&controller.tasks);
            conversation.caller.change(controller);
        }
        let measured = plant.measure(time_s, external_force);
        let mut streamed = streams.next(plant.tool_position(), samples.last().is_some_and(Sample::presses));
        // Those of the operator come first.
        streamed.extend(targets);
        let state = wire::State { targets: streamed, ..measured.state(period, time_s) };
        let obstacles = state.obstacles.clone();
        let (held, cycle, round_trip) = conversation.next(state, || unit(operator.goes_on()))?;
        if held.is_new {
            clarabel.add(&held.answer.solver.levels);
        }
        let sample = plant.sample(period, time_s, measured, held, tasks);
        plant.advance(&held.answer.joint_velocity, time_s)?;
        let observed = Observed { sample: &sample, obstacles: &obstacles, answer: &held.answer, round_trip, cycle };
        operator.see(period + 1, &observed);
        samples.push(sample);
        timings.push(Timing { round_trip_us: round_trip.as_secs_f64() * 1e6, elapsed_us: held.answer.elapsed_us });
        match operator.goes_on() {
            ControlFlow::Continue(()) if period + 1 < scenario.cycles() => Ok(ControlFlow::Continue(())),
            ControlFlow::Continue(()) | ControlFlow::Break(Ending::Finish) => Ok(ControlFlow::Break(())),
            ControlFlow::Break(Ending::Stop) => Err(RunError::Stopped { time_s }),
        }
    }

    /// Returns the recording of the periods so far.
    pub fn finish(self) -> Recording {
        let Self { scenario, plant, start, clarabel, samples, timings, .. } = self;
        Recording {
            scenario: scenario.name.clone(),
            method: scenario.controller.method,
            solver: scenario.controller.solver,
            period_s: scenario.period_s(),
            wall_time_s: start.elapsed().as_secs_f64(),
            joint_names: plant.joint_names().to_vec(),
            energy: plant.energy(),
            setup: Some(Box::new(scenario)),
            clarabel: (clarabel.count > 0).then_some(clarabel),
            samples,
            timings,
        }
    }
}

fn unit(goes_on: ControlFlow<Ending>) -> ControlFlow<()> {
    goes_on.map_break(|_| ())
}

/// The exchange with the service, and the command that the arm executes.
struct Conversation<'a> {
    caller: Caller<'a>,
    channel: LossyChannel,
    robot: Arc<RobotModel>,
    period_s: f64,
    held: Option<HeldCommand>,
}

impl Conversation<'_> {
    /// Sends a state. Returns the command for its period, the input of the call, and the round-trip time.
    fn next(
        &mut self,
        state: wire::State,
        goes_on: impl FnMut() -> ControlFlow<()>,
    ) -> Result<(&HeldCommand, Option<Cycle<'_>>, Duration), RunError> {
        let (period, time_s) = (state.sequence, state.time_s);
        let is_down = self.channel.is_down(time_s);
        let called = Instant::now();
        let answer = if is_down { Ok(None) } else { self.caller.call(state).map(Some) };
        let round_trip = if is_down { Duration::ZERO } else { called.elapsed() };
        let answer = match answer {
            Err(error) if is_missing_answer(&error) && self.held.is_some() => {
                if pause(self.period_s, goes_on).is_break() {
                    return Err(RunError::Stopped { time_s });
                }
                None
            }
            answer => answer.map_err(|source| RunError::Service { time_s, source })?,
        };
        let was_answered = answer.is_some();
        let arrived = self.channel.pass(period, answer);
        if was_answered && arrived.as_ref().is_none_or(|answer| answer.sequence < period) {
            self.caller.discard_answer();
        }
        let held = match (arrived, self.held.take()) {
            (Some(answer), before) => HeldCommand::new(answer, before.as_ref(), time_s, self.period_s),
            (None, Some(before)) => before.hold(time_s, self.period_s),
            (None, None) => return Err(FieldError::new("/faults", "must leave an answer to the first state").into()),
        };
        let (expected, given) = (self.robot.joint_count(), held.answer.joint_velocity.len());
        if given != expected {
            return Err(RunError::AnswerSize { time_s, expected, given });
        }
        Ok((self.held.insert(held), self.caller.cycle(), round_trip))
    }
}

/// Returns the robot with the tool offset of the controller.
fn with_tool(robot: &Arc<RobotModel>, controller: &wire::Controller) -> Result<Arc<RobotModel>, RunError> {
    let Some(wire::Pose { position, orientation: wire::Orientation { w, x, y, z } }) = controller.tool_offset else {
        return Ok(Arc::clone(robot));
    };
    Ok(Arc::new(robot.with_tool_offset(&pose(position, [w, x, y, z])?)?))
}
