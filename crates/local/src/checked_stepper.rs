//! A stepper that checks the states, alone and with the memory of its last step.

use std::sync::Arc;

use crate::clock::Instant;
use revprio_api::wire;
use revprio_core::controller::{Command, Controller, ControllerConfig, Measurement, Memory, Stepper};
use revprio_core::law::ContactPhase;
use revprio_core::linalg::Vector;

use super::convert;
use super::error::ApiError;
use super::robots::Robots;
use super::solvers::stepper;
use super::state_rules::{LastState, StateRules, implausible_speeds};
use super::warnings::ProfileEnd;
use super::{request_warnings, warnings, why};

/// A controller with its workspace, and the rules for its states.
pub struct CheckedStepper {
    stepper: Stepper,
    rules: StateRules,
    /// Warnings about the controller in its first answer.
    first_warnings: Vec<String>,
    profile_ends: Vec<ProfileEnd>,
}

impl CheckedStepper {
    /// Creates the stepper of a controller.
    pub fn new(request: &wire::Controller, controller: Controller) -> Result<Self, ApiError> {
        let rules = convert::state_rules(request)?;
        let first_warnings = warnings::of_first_step(request, controller.config());
        let profile_ends = warnings::profile_ends(request);
        let stepper = stepper(controller).map_err(|error| convert::step_error(&error, None))?;
        Ok(Self { stepper, rules, first_warnings, profile_ends })
    }

    /// Returns the controller.
    pub fn controller(&self) -> &Arc<Controller> {
        self.stepper.controller()
    }

    /// Reads a state and refuses one beyond the bounds of the controller.
    pub fn measurement(&self, state: &wire::State) -> Result<Measurement, ApiError> {
        let measurement = convert::measurement(state, self.controller())?;
        self.rules.check(&measurement, self.controller())?;
        Ok(measurement)
    }

    /// Computes the answer to a measurement of [`Self::measurement`], without memory.
    pub fn step(
        &mut self,
        memory: &mut Option<Memory>,
        last: Option<&LastState>,
        sequence: u64,
        measurement: &Measurement,
        start: Instant,
    ) -> Result<wire::StepAnswer, ApiError> {
        let (controller, rules) = (self.stepper.controller().clone(), self.rules);
        let (command, Remarks { warnings, why }) = self.command(memory, last, sequence, measurement)?;
        let answer = convert::step_answer(&controller, &rules, sequence, command, start);
        Ok(wire::StepAnswer { warnings, why, ..answer })
    }

    /// Returns the warnings about the controller and the time of its first state, s.
    fn first_warnings(&self, time_s: f64) -> Vec<String> {
        let mut warnings = self.first_warnings.clone();
        warnings::warn_about_profiles(&mut warnings, &self.profile_ends, time_s);
        warnings
    }

    /// Computes the command of a step, and the remarks of its answer.
    fn command(
        &mut self,
        memory: &mut Option<Memory>,
        last: Option<&LastState>,
        sequence: u64,
        measurement: &Measurement,
    ) -> Result<(&Command, Remarks), ApiError> {
        let controller = self.stepper.controller().clone();
        let config = controller.config();
        let is_first = memory.is_none();
        let mut warnings = if is_first { self.first_warnings(measurement.time_s) } else { Vec::new() };
        let implausible = implausible_speeds(measurement, &config.robot, is_first);
        let is_at_rest = is_first && !implausible.is_empty();
        let resting = is_at_rest.then(|| Measurement { joint_velocity: None, ..measurement.clone() });
        let measurement = resting.as_ref().unwrap_or(measurement);
        warnings.extend(implausible);
        let command = self.stepper.step(memory, measurement);
        let command = command.map_err(|error| convert::step_error(&error, Some(measurement)))?;
        self.rules.warn(&mut warnings, measurement, &controller, command);
        warnings::warn_about_targets(&mut warnings, &controller, command);
        warnings::warn_about_weights(&mut warnings, &controller, command);
        warnings::warn_about_channels(&mut warnings, &controller, measurement);
        request_warnings::of_targets(&mut warnings, &controller, measurement);
        if let Some(last) = last {
            last.compare(&mut warnings, sequence, measurement, &controller);
            warnings::warn_about_clock(&mut warnings, &self.profile_ends, last.time_s, measurement.time_s);
        }
        let why = if self.rules.why { why::why_of_step(config, command, measurement) } else { Vec::new() };
        Ok((command, Remarks { warnings, why }))
    }
}

/// The texts of an answer.
struct Remarks {
    warnings: Vec<String>,
    /// What restricts the command and what its tasks give up; empty if the controller does not want it.
    why: Vec<String>,
}

/// A controller that is ready for a session, as it was requested and with the warnings about it.
pub struct PreparedController {
    /// The request.
    pub request: wire::Controller,
    /// The controller with its workspace.
    pub stepper: CheckedStepper,
    /// Warnings about unstable loops and gains that are too high.
    pub warnings: Vec<String>,
}

impl PreparedController {
    /// Checks a controller. The warnings take longer than a step.
    pub fn new(request: wire::Controller, robots: &Robots) -> Result<Self, ApiError> {
        let controller = convert::controller(&request, robots)?;
        let warnings = warnings::of_controller(&request, controller.config())?;
        let stepper = CheckedStepper::new(&request, controller)?;
        Ok(Self { request, stepper, warnings })
    }
}

/// Why a session whose law presses is not tared.
const TARE_IN_CONTACT: &str = "the law `contact` of this session presses on a surface, or did so before the last `PUT`, so that would count as \
    bias; move the tool away from what it touches first";

/// A controller from state to state: the memory of its last step, and the state to compare the next one with.
pub struct ControlLoop {
    stepper: CheckedStepper,
    memory: Option<Memory>,
    last_state: Option<LastState>,
    answers: RecentAnswers,
    /// What a controller before this one pressed with; `None` once the surface is lost.
    pressed: Option<Pressed>,
    /// The wrenches of the last state.
    wrenches: Vec<f64>,
}

/// A tool that pressed before another controller came, of which the new controller may know nothing.
struct Pressed {
    /// The largest force, N or N·m.
    force: f64,
    /// The wrenches of the last state before that.
    wrenches: Vec<f64>,
}

impl Pressed {
    /// Returns whether wrenches are still those of the surface.
    fn lasts(&self, wrenches: &[f64]) -> bool {
        let changes = self.wrenches.iter().zip(wrenches).map(|(before, now)| before - now);
        changes.fold(0.0, f64::hypot) < LOST_SHARE * self.force
    }
}

/// Share of the force of a contact by which the wrench changes if the surface is lost.
const LOST_SHARE: f64 = 0.5;

impl ControlLoop {
    /// Starts without memory.
    pub fn new(stepper: CheckedStepper) -> Self {
        Self {
            stepper,
            memory: None,
            last_state: None,
            answers: RecentAnswers::default(),
            pressed: None,
            wrenches: Vec::new(),
        }
    }

    /// Returns the controller.
    pub fn controller(&self) -> &Arc<Controller> {
        self.stepper.controller()
    }

    /// Continues with another controller, whose first commands move to its motion at the acceleration limits; returns its
    /// warnings and those about the change. On an error nothing changes.
    pub fn replace(&mut self, stepper: CheckedStepper, mut warnings: Vec<String>) -> Result<Vec<String>, ApiError> {
        let (old, new) = (self.controller(), stepper.controller());
        let continued = match (&self.memory, &self.last_state) {
            (Some(memory), Some(last)) => new.continue_from(old, memory, &last.joint_position).map(Some),
            _ => new.check_transition(old).map(|()| None),
        };
        let continued = continued.map_err(|error| convert::transition_error(&error))?;
        if let (Some(memory), Some(last)) = (&self.memory, &self.last_state) {
            // Without Unix time, profiles count from zero.
            let profile_time_s = last.time_s - memory.start_time_s;
            let ends = [&self.stepper.profile_ends, &stepper.profile_ends].map(Vec::as_slice);
            warnings::warn_about_replaced(&mut warnings, ends, profile_time_s);
        }
        if let Some(memory) = self.memory.as_ref().filter(|_| self.pressed.is_none() && self.presses_surely()) {
            let force = memory.contacts.iter().map(|axis| axis.force.abs()).fold(0.0, f64::max);
            self.pressed = Some(Pressed { force, wrenches: self.wrenches.clone() });
        }
        (self.memory, self.stepper) = (continued, stepper);
        Ok(warnings)
    }

    /// Returns whether the law `contact` certainly presses: also one that knows nothing of its contact yet, because it has another name or
    /// frame than the one before.
    fn presses_surely(&self) -> bool {
        let config = self.controller().config();
        self.pressed.is_some() || self.memory.as_ref().is_some_and(|memory| config.presses_surely(&memory.contacts))
    }

    /// Tares a wrench sensor. The next state gets its bias; all else that the controller remembers stays. `controller`: that of the
    /// request. Returns the answer and the controller with the bias. On an error nothing changes.
    pub fn tare(
        &mut self,
        request: &wire::TareRequest,
        controller: &wire::Controller,
    ) -> Result<(wire::TareAnswer, wire::Controller), ApiError> {
        let config = self.controller().config();
        if self.presses_surely() {
            return Err(ApiError::invalid("/readings", TARE_IN_CONTACT));
        }
        for (number, reading) in request.readings.iter().enumerate() {
            let field = format!("/readings/{number}");
            self.stepper.rules.check_wrench(&reading.wrench, &format!("{field}/wrench"))?;
            if let Ok(position) = convert::joint_vector::<Vec<f64>>(&reading.joint_position, &config.robot, "") {
                self.stepper.rules.check_position(&position, config, &format!("{field}/joint_position"))?;
            }
        }
        let (mut answer, tared, sensors) = convert::tared(request, controller, config)?;
        let motion = self.memory.as_ref().map(|memory| memory.last_command.as_slice());
        let last = self.last_state.as_ref().map(|last| last.joint_position.as_slice());
        warnings::warn_about_tare(&mut answer.warnings, (request, config), (last, motion));
        let with_bias = ControllerConfig { wrench_sensors: sensors, ..config.clone() };
        let with_bias = Controller::new(with_bias).map_err(|error| ApiError::invalid("/readings", error))?;
        self.stepper = CheckedStepper::new(&tared, with_bias)?;
        if let Some(memory) = &mut self.memory {
            memory.wrench_sensors.clear();
        }
        Ok((answer, tared))
    }

    /// Reads a state and refuses one beyond the bounds of the controller.
    pub fn measurement(&self, state: &wire::State) -> Result<Measurement, ApiError> {
        self.stepper.measurement(state)
    }

    /// Sequence number of the last state.
    pub fn last_sequence(&self) -> Option<u64> {
        self.last_state.as_ref().map(|last| last.sequence)
    }

    /// Joint velocities q̇ of the last command, n.
    pub fn last_command(&self) -> Option<&Vector> {
        self.memory.as_ref().map(|memory| &memory.last_command)
    }

    /// Computes the answer to a measurement of [`Self::measurement`]. The caller checks the sequence number.
    pub fn step(
        &mut self,
        sequence: u64,
        measurement: Measurement,
        start: Instant,
    ) -> Result<wire::StepAnswer, ApiError> {
        let answer = self.stepper.step(&mut self.memory, self.last_state.as_ref(), sequence, &measurement, start)?;
        self.remember(sequence, measurement);
        Ok(answer)
    }

    /// Computes the command for a measurement of [`Self::measurement`], as [`Self::step`], without its explanation.
    pub fn command(
        &mut self,
        sequence: u64,
        measurement: Measurement,
        start: Instant,
    ) -> Result<ComputedStep, ApiError> {
        let (controller, rules) = (Arc::clone(self.stepper.controller()), self.stepper.rules);
        let last = self.last_state.as_ref();
        let (_, remarks) = self.stepper.command(&mut self.memory, last, sequence, &measurement)?;
        let command = self.answers.take(&mut self.stepper.stepper);
        self.remember(sequence, measurement);
        let elapsed_us = start.elapsed().as_secs_f64() * 1e6;
        Ok(ComputedStep { controller, rules, sequence, command, remarks, elapsed_us })
    }

    fn remember(&mut self, sequence: u64, measurement: Measurement) {
        let touches = |memory: &Memory| memory.contacts.iter().any(|axis| axis.phase == ContactPhase::Contact);
        let touches = self.memory.as_ref().is_some_and(touches);
        self.wrenches.clear();
        let others = measurement.wrenches.iter().flat_map(|measured| measured.wrench);
        self.wrenches.extend(measurement.wrench.into_iter().chain(others));
        self.pressed.take_if(|pressed| !pressed.lasts(&self.wrenches) && !touches);
        let Measurement { time_s, joint_position, .. } = measurement;
        self.last_state = Some(LastState { sequence, time_s, joint_position });
    }
}

/// The commands of the last two answers. A loop keeps the last answer until it has the next one, so the command before it is
/// mostly unused, and the next answer takes its memory.
#[derive(Default)]
struct RecentAnswers {
    last: Arc<Command>,
    before: Arc<Command>,
}

impl RecentAnswers {
    /// Takes the command of the last step.
    fn take(&mut self, stepper: &mut Stepper) -> Arc<Command> {
        std::mem::swap(&mut self.last, &mut self.before);
        if Arc::get_mut(&mut self.last).is_none() {
            self.last = Arc::default();
        }
        if let Some(unused) = Arc::get_mut(&mut self.last) {
            stepper.exchange_command(unused);
        }
        Arc::clone(&self.last)
    }
}

/// A step whose answer is written only when it is read: that takes about as long as the step.
pub struct ComputedStep {
    controller: Arc<Controller>,
    rules: StateRules,
    sequence: u64,
    command: Arc<Command>,
    remarks: Remarks,
    elapsed_us: f64,
}

impl ComputedStep {
    /// Joint velocities q̇, n, rad/s or m/s.
    pub fn joint_velocity(&self) -> &[f64] {
        self.command.resolution.joint_velocity.as_slice()
    }

    /// Validity of the command, ms.
    pub fn valid_for_ms(&self) -> u64 {
        convert::valid_for_ms(&self.command.hold, &self.rules)
    }

    /// Time in which all joints come to rest together after that, s.
    pub fn stop_time_s(&self) -> Option<f64> {
        self.command.hold.stop_time_s
    }

    /// Returns the whole answer.
    pub fn answer(&self) -> wire::StepAnswer {
        let start = Instant::now();
        wire::StepAnswer {
            warnings: self.remarks.warnings.clone(),
            why: self.remarks.why.clone(),
            elapsed_us: self.elapsed_us,
            ..convert::step_answer(&self.controller, &self.rules, self.sequence, &self.command, start)
        }
    }
}
