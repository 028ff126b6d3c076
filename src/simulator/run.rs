//! One run of a scenario against a service.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use super::arm::Arm;
use super::environment::Environment;
use super::recording::{Recording, Sample};
use super::scenario::Scenario;
use super::watchdog::{Obeyed, is_silence, pause};
use crate::client::{Client, ClientError};
use crate::kinematics::{Configuration, ConfigurationError, NotUnitLength, pose};
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
    let mut caller = Caller::open(scenario, client, mode)?;
    let start = Instant::now();
    let mut samples = Vec::new();
    let mut obeyed: Option<Obeyed> = None;
    for sequence in 0..scenario.cycles() {
        let time_s = sequence as f64 * scenario.period_s();
        let measured = plant.measure(time_s)?;
        let now = match (caller.call(measured.state(sequence, time_s)), obeyed) {
            (Ok(answer), _) => Obeyed::new(answer, time_s),
            (Err(error), Some(before)) if is_silence(&error) => {
                if pause(scenario.period_s(), || progress(sequence)).is_break() {
                    return Err(RunError::Stopped { time_s });
                }
                before.still(time_s, &robot, scenario.period_s())
            }
            (Err(source), _) => return Err(RunError::Service { time_s, source }),
        };
        let (expected, given) = (robot.joint_count(), now.answer.joint_velocity.len());
        if given != expected {
            return Err(RunError::AnswerSize { time_s, expected, given });
        }
        plant.arm.advance(&now.answer.joint_velocity, scenario.period_s());
        samples.push(measured.sample(time_s, &plant, scenario, &now));
        obeyed = Some(now);
        if progress(sequence + 1).is_break() {
            return Err(RunError::Stopped { time_s });
        }
    }
    let wall_time_s = start.elapsed().as_secs_f64();
    Ok(Recording {
        scenario: scenario.name.clone(),
        method: scenario.controller.method,
        solver: scenario.controller.solver,
        period_s: scenario.period_s(),
        wall_time_s,
        joint_names: robot.joints().iter().map(|joint| joint.name.clone()).collect(),
        samples,
    })
}

/// The arm with its tool point where the controller says.
fn with_tool(robot: &Arc<RobotModel>, controller: &wire::Controller) -> Result<Arc<RobotModel>, RunError> {
    let Some(wire::Pose { position, orientation: wire::Orientation { w, x, y, z } }) = controller.tool_offset else {
        return Ok(Arc::clone(robot));
    };
    Ok(Arc::new(robot.with_tool_offset(&pose(position, [w, x, y, z])?)?))
}

/// Arm and environment.
struct Plant {
    robot: Arc<RobotModel>,
    arm: Arm,
    environment: Environment,
    start: [f64; 3],
    period_s: f64,
    wrench_convention: wire::WrenchConvention,
    wrench_frame: wire::WrenchFrame,
}

impl Plant {
    fn new(scenario: &Scenario, robot: &Arc<RobotModel>) -> Result<Self, RunError> {
        let position = &scenario.start_joint_position;
        let start = tool_position(&Configuration::new(robot, position).map_err(RunError::Start)?);
        Ok(Self {
            robot: Arc::clone(robot),
            arm: Arm::at_rest(position.clone(), scenario.velocity_loop),
            environment: Environment::new(scenario.contacts.clone(), start),
            start,
            period_s: scenario.period_s(),
            wrench_convention: scenario.controller.wrench_convention,
            wrench_frame: scenario.controller.wrench_frame,
        })
    }

    fn measure(&mut self, time_s: f64) -> Result<Measured, RunError> {
        let configuration = Configuration::new(&self.robot, self.arm.position())
            .map_err(|source| RunError::Diverged { time_s, source })?;
        let position = tool_position(&configuration);
        let [x, y, z, ..] = configuration.twist(self.arm.velocity());
        let force = self.environment.force(position, [x, y, z], self.period_s);
        Ok(Measured {
            joint_position: self.arm.position().to_vec(),
            joint_velocity: self.arm.velocity().to_vec(),
            position,
            force,
            sensed_force: self.sensed(force, &configuration),
        })
    }

    /// The force as a sensor gives it whose sign and axes are those that the controller expects.
    fn sensed(&self, force: [f64; 3], configuration: &Configuration) -> [f64; 3] {
        let force = match self.wrench_convention {
            wire::WrenchConvention::OnEnvironment => force,
            wire::WrenchConvention::OnTool => force.map(|entry| -entry),
        };
        match self.wrench_frame {
            wire::WrenchFrame::Base => force,
            wire::WrenchFrame::Tool => {
                configuration.tool_pose().rotation.inverse_transform_vector(&force.into()).into()
            }
        }
    }
}

fn tool_position(configuration: &Configuration) -> [f64; 3] {
    configuration.tool_pose().translation.vector.into()
}

/// What a real arm would measure.
struct Measured {
    joint_position: Vec<f64>,
    joint_velocity: Vec<f64>,
    position: [f64; 3],
    /// On the environment, base axes.
    force: [f64; 3],
    sensed_force: [f64; 3],
}

impl Measured {
    fn state(&self, sequence: u64, time_s: f64) -> wire::State {
        wire::State {
            sequence,
            time_s,
            joint_position: self.joint_position.clone().into(),
            joint_velocity: Some(self.joint_velocity.clone().into()),
            wrench: Some(wire::Wrench { force: self.sensed_force, torque: [0.0; 3] }),
        }
    }

    fn sample(self, time_s: f64, plant: &Plant, scenario: &Scenario, obeyed: &Obeyed) -> Sample {
        let answer = &obeyed.answer;
        Sample {
            time_s,
            joint_position: self.joint_position,
            position: self.position,
            position_error: [0, 1, 2].map(|i| self.position[i] - plant.start[i]),
            force: self.force,
            target_force: target_force(scenario, answer),
            wall_distance: plant.environment.wall_distance(self.position),
            path: answer.solver.path,
            status: answer.solver.status,
            kkt_residual: answer.solver.kkt_residual,
            smallest_singular_value: answer.singularity.smallest_singular_value,
            residual_norms: answer.tasks.iter().map(|task| task.residual_norm).collect(),
            joint_velocity: answer.joint_velocity.clone(),
            answered: obeyed.is_new,
        }
    }
}

/// F_d on x, y and z, from the answers of the tasks that the axes belong to.
fn target_force(scenario: &Scenario, answer: &wire::StepAnswer) -> [Option<f64>; 3] {
    let mut target = [None; 3];
    for (task, outcome) in scenario.controller.tasks.iter().zip(&answer.tasks) {
        // Along other axes there is no force on x, y or z to tell.
        if task.frame != wire::Frame::Base {
            continue;
        }
        for (axis, &force) in task.axes.iter().flatten().zip(outcome.target_force.iter().flatten()) {
            if let Some(slot) = target.get_mut(*axis as usize) {
                *slot = force;
            }
        }
    }
    target
}

/// The service as one run sees it.
enum Caller<'a> {
    Session { client: &'a Client, id: String },
    Stateless { client: &'a Client, request: Box<wire::StepRequest> },
}

impl<'a> Caller<'a> {
    fn open(scenario: &Scenario, client: &'a Client, mode: CallMode) -> Result<Self, RunError> {
        let controller = &scenario.controller;
        match mode {
            CallMode::Session => {
                let created = client.create_controller(controller);
                let created = created.map_err(|source| RunError::Service { time_s: 0.0, source })?;
                Ok(Self::Session { client, id: created.id })
            }
            CallMode::Stateless => {
                let nothing = wire::State {
                    sequence: 0,
                    time_s: 0.0,
                    joint_position: Vec::new().into(),
                    joint_velocity: None,
                    wrench: None,
                };
                let request = wire::StepRequest { controller: controller.clone(), state: nothing, memory: None };
                Ok(Self::Stateless { client, request: Box::new(request) })
            }
        }
    }

    fn call(&mut self, state: wire::State) -> Result<wire::StepAnswer, ClientError> {
        match self {
            Self::Session { client, id } => client.step_controller(id, &state),
            Self::Stateless { client, request } => {
                request.state = state;
                let mut answer = client.step(request)?;
                request.memory = answer.memory.take();
                Ok(answer)
            }
        }
    }
}

impl Drop for Caller<'_> {
    /// Ends the session, after a failure too; if that fails, the service ends it by itself.
    fn drop(&mut self) {
        if let Self::Session { client, id } = self {
            let _ = client.delete_controller(id);
        }
    }
}
