//! The operator of an interactive run: it paces the simulation and applies the commands of clients.

use std::ops::ControlFlow;
use std::sync::{Arc, MutexGuard};
use std::time::{Duration, Instant};

use revprio_lab::simulator::{Ending, Influence, Observed, Operator};
use revprio_local::simulation::{Camera, Commands, Pacer, ProgressPublisher, RunControl, Turn};

use crate::service::background::Abandoned;

/// A run without watchers and commands finishes after this time.
const UNATTENDED_TIME: Duration = Duration::from_mins(1);

/// Maximum time between two checks whether the run continues.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// Runs a simulation according to a [`RunControl`].
pub struct ControlledOperator<'a> {
    run_control: &'a RunControl,
    progress: &'a ProgressPublisher,
    abandoned: &'a Abandoned,
    camera: Camera,
    pacer: Pacer,
    /// External force in the current period, N.
    external_force: [f64; 3],
}

impl<'a> ControlledOperator<'a> {
    /// Creates the operator of a run.
    pub fn new(run_control: &'a Arc<RunControl>, progress: &'a ProgressPublisher, abandoned: &'a Abandoned) -> Self {
        let camera = Camera::new(Arc::clone(run_control));
        let pacer = Pacer::new(run_control.config().period_s);
        Self { run_control, progress, abandoned, camera, pacer, external_force: [0.0; 3] }
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
            match self.pacer.turn(&mut commands, now) {
                Turn::Period => return commands,
                Turn::Paused => {
                    self.camera.publish();
                    commands = self.run_control.wait(commands, CHECK_INTERVAL);
                }
                Turn::Wait(left) => commands = self.run_control.wait(commands, left.min(CHECK_INTERVAL)),
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
