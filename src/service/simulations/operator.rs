//! The operator of an interactive run: it paces the simulation and applies the commands of clients.

use std::ops::ControlFlow;
use std::sync::MutexGuard;
use std::time::{Duration, Instant};

use revprio_lab::simulator::{Ending, Influence, Observed, Operator};

use super::live::Camera;
use super::progress::ProgressPublisher;
use super::run_control::{Commands, RunControl};
use crate::service::background::Abandoned;

/// A run without watchers and commands finishes after this time.
const UNATTENDED_TIME: Duration = Duration::from_mins(1);

/// Maximum time between two checks whether the run continues.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// A run that is more than this behind the clock does not catch up.
const MAX_LAG: Duration = Duration::from_millis(100);

/// Runs a simulation according to a [`RunControl`].
pub struct ControlledOperator<'a> {
    run_control: &'a RunControl,
    progress: &'a ProgressPublisher,
    abandoned: &'a Abandoned,
    camera: Camera<'a>,
    period_s: f64,
    /// Start of the next period.
    due: Instant,
    /// External force in the current period, N.
    external_force: [f64; 3],
}

impl<'a> ControlledOperator<'a> {
    /// Creates the operator of a run.
    pub fn new(run_control: &'a RunControl, progress: &'a ProgressPublisher, abandoned: &'a Abandoned) -> Self {
        let config = run_control.config();
        let camera = Camera::new(run_control.live(), config);
        let period_s = config.period_s;
        Self { run_control, progress, abandoned, camera, period_s, due: Instant::now(), external_force: [0.0; 3] }
    }

    /// Waits until the next period is due. During a pause, waits for the next command.
    fn wait(&mut self) -> MutexGuard<'_, Commands> {
        let mut commands = self.run_control.lock();
        loop {
            if self.run_control.live().watchers() > 0 {
                commands.last_attention = Instant::now();
            }
            commands.finish |= commands.last_attention.elapsed() > UNATTENDED_TIME;
            let now = Instant::now();
            if commands.finish || self.abandoned.is_set() || self.progress.has_ended() {
                return commands;
            }
            if commands.pace.paused {
                self.due = now;
                if commands.steps > 0 {
                    commands.steps -= 1;
                    return commands;
                }
                self.camera.publish();
                commands = self.run_control.wait(commands, CHECK_INTERVAL);
                continue;
            }
            match self.due.checked_duration_since(now) {
                Some(left) if !left.is_zero() => {
                    commands = self.run_control.wait(commands, left.min(CHECK_INTERVAL));
                }
                _ => {
                    let start = if now.duration_since(self.due) > MAX_LAG { now } else { self.due };
                    self.due = start + Duration::from_secs_f64(self.period_s / commands.pace.speed);
                    return commands;
                }
            }
        }
    }
}

impl Operator for ControlledOperator<'_> {
    fn influence(&mut self, _period: u64) -> Influence {
        let mut commands = self.wait();
        let controller = commands.take_new_controller();
        let targets = commands.take_targets();
        let external_force = commands.external_force();
        drop(commands);
        self.external_force = external_force;
        Influence { external_force, controller, targets }
    }

    fn see(&mut self, done: u64, period: &Observed) {
        self.camera.record(done, period, self.external_force);
        self.progress.advance(done);
    }

    fn goes_on(&mut self) -> ControlFlow<Ending> {
        if self.abandoned.is_set() || self.progress.has_ended() {
            return ControlFlow::Break(Ending::Stop);
        }
        if self.run_control.lock().finish { ControlFlow::Break(Ending::Finish) } else { ControlFlow::Continue(()) }
    }
}

impl Drop for ControlledOperator<'_> {
    fn drop(&mut self) {
        self.camera.publish();
    }
}
