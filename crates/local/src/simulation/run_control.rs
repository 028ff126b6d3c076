//! The commands of clients to an interactive run, and the live view of the run.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use revprio_api::clock::Instant;
use revprio_api::wire;
use revprio_core::controller::{Controller, ControllerConfig};
use tokio::sync::watch;

use super::controller_change::changed_controller;
use super::live::{LiveView, Picture};
use crate::convert;
use crate::error::ApiError;
use crate::robots::Robots;

/// A push ends this long after the last command that set it, because the page that sent it may be gone.
const PUSH_TIME: Duration = Duration::from_secs(1);

/// The commands to one interactive run, and its live view.
pub struct RunControl {
    commands: Mutex<Commands>,
    changed: Condvar,
    /// Robot, limits and period. No command changes them.
    controller: Controller,
    live: LiveView,
}

/// The commands that the run has not applied yet.
pub struct Commands {
    /// Speed, and whether the run is paused.
    pub pace: wire::Interactive,
    /// Periods to run although the run is paused.
    pub steps: u64,
    /// External force on the tool, N, base frame.
    force: [f64; 3],
    force_set: Instant,
    controller: Arc<wire::Controller>,
    is_controller_new: bool,
    /// Targets that no state contains yet.
    targets: BTreeMap<String, wire::StreamedTarget>,
    /// Whether the run is to finish.
    pub finish: bool,
    /// Time of the last command or of the last check that found a watcher.
    pub last_attention: Instant,
}

impl Commands {
    /// Returns the external force that acts now, N.
    pub fn external_force(&self) -> [f64; 3] {
        if self.force_set.elapsed() < PUSH_TIME { self.force } else { [0.0; 3] }
    }

    /// Returns the changed controller, once after each change.
    pub fn take_new_controller(&mut self) -> Option<wire::Controller> {
        std::mem::take(&mut self.is_controller_new).then(|| wire::Controller::clone(&self.controller))
    }

    /// Returns the new targets, each once.
    pub fn take_targets(&mut self) -> BTreeMap<String, wire::StreamedTarget> {
        std::mem::take(&mut self.targets)
    }
}

impl RunControl {
    /// Creates the control of a run that has not begun. `request` and `controller` are the same controller, as received
    /// and as read; `start`: joint positions, n.
    pub fn new(
        pace: wire::Interactive,
        request: wire::Controller,
        controller: Controller,
        start: &[f64],
    ) -> Result<Self, ApiError> {
        let at_rest = vec![0.0; start.len()];
        let arm = convert::arm_view(controller.config(), start, &at_rest).ok_or_else(|| {
            ApiError::invalid("/scenario/start_joint_position", "not a posture of the robot; give one number per joint")
        })?;
        let commands = Commands {
            pace,
            steps: 0,
            force: [0.0; 3],
            force_set: Instant::now(),
            controller: Arc::new(request),
            is_controller_new: false,
            targets: BTreeMap::new(),
            finish: false,
            last_attention: Instant::now(),
        };
        Ok(Self { commands: Mutex::new(commands), changed: Condvar::new(), controller, live: LiveView::new(arm) })
    }

    /// Applies a whole command, or refuses it without any change.
    pub fn apply(&self, command: &wire::SimulationControl, robots: &Robots) -> Result<(), ApiError> {
        convert::check_control(command, &self.controller)?;
        let mut commands = self.with_changed_controller(command, robots)?;
        let Commands { pace, steps, force, force_set, targets, finish, last_attention, .. } = &mut *commands;
        pace.paused = command.paused.unwrap_or(pace.paused || command.step.is_some());
        pace.speed = command.speed.unwrap_or(pace.speed);
        *steps = if pace.paused { *steps + command.step.unwrap_or(0) } else { 0 };
        if let Some(external_force) = command.external_force {
            (*force, *force_set) = (external_force, Instant::now());
        }
        targets.extend(command.targets.clone());
        *finish |= command.end;
        *last_attention = Instant::now();
        drop(commands);
        self.wake();
        Ok(())
    }

    /// Returns the commands with the controller that a command selects. It is read and checked without the lock, for which other threads
    /// would wait.
    fn with_changed_controller(
        &self,
        command: &wire::SimulationControl,
        robots: &Robots,
    ) -> Result<MutexGuard<'_, Commands>, ApiError> {
        loop {
            let current = Arc::clone(&self.lock().controller);
            let changed = changed_controller(command, &current, robots)?;
            let mut commands = self.lock();
            let Some(controller) = changed else { return Ok(commands) };
            if Arc::ptr_eq(&commands.controller, &current) {
                commands.controller = Arc::new(controller);
                commands.is_controller_new = true;
                return Ok(commands);
            }
        }
    }

    /// Time since a client last watched or commanded the run; `None` if it is to finish.
    pub fn unattended_for(&self) -> Option<Duration> {
        let is_watched = self.live.watchers() > 0;
        let commands = self.lock();
        let time = if is_watched { Duration::ZERO } else { commands.last_attention.elapsed() };
        (!commands.finish).then_some(time)
    }

    /// Finishes the run after the current period.
    pub fn finish(&self) {
        self.lock().finish = true;
        self.wake();
    }

    /// Wakes a waiting run and its watchers after a change.
    pub fn wake(&self) {
        self.changed.notify_all();
        self.live.notify_watchers();
    }

    /// Subscribes to the pictures.
    pub fn watch(&self) -> watch::Receiver<Arc<Picture>> {
        self.live.watch()
    }

    /// Returns a picture with the samples after the first `seen` samples, and updates `seen`.
    pub fn frame(&self, picture: &Picture, run: wire::Simulation, seen: &mut usize) -> wire::LiveFrame {
        self.live.frame(picture, run, seen)
    }

    /// Returns the last shown period as a request.
    pub fn cycle(&self) -> Result<wire::StepRequest, ApiError> {
        self.live.cycle().ok_or_else(|| ApiError::not_live("no control period is done yet; try again later"))
    }

    /// Returns the speed, and whether the run is paused.
    pub fn pace(&self) -> wire::Interactive {
        self.lock().pace
    }

    /// Returns method and solver of the current controller.
    pub fn method_and_solver(&self) -> (wire::Method, wire::Solver) {
        let commands = self.lock();
        (commands.controller.method, commands.controller.solver)
    }

    /// The live view of the run.
    pub fn live(&self) -> &LiveView {
        &self.live
    }

    /// Robot, limits and period of the run.
    pub fn config(&self) -> &ControllerConfig {
        self.controller.config()
    }

    /// Returns the commands, for the run.
    pub fn lock(&self) -> MutexGuard<'_, Commands> {
        self.commands.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a command, at most for `timeout`.
    pub fn wait<'a>(&self, commands: MutexGuard<'a, Commands>, timeout: Duration) -> MutexGuard<'a, Commands> {
        let (commands, _) = self.changed.wait_timeout(commands, timeout).unwrap_or_else(PoisonError::into_inner);
        commands
    }
}
