//! One run of a scenario, from the queue to its result.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use revprio_api::wire::{Simulation, SimulationState};
use revprio_lab::metrics::Metrics;
use revprio_lab::simulator::recording::Recording;
use revprio_lab::simulator::{CallMode, Scenario, run_operated, run_robot};
use revprio_local::simulation::{Finished, Progress, ProgressPublisher, RunControl, status};
use revprio_robot::RobotModel;
use tokio::sync::{Semaphore, watch};
use uuid::Uuid;

use super::operator::ControlledOperator;
use crate::service::background::{Abandoned, background};
use crate::service::convert;
use crate::service::error::ApiError;
use crate::service::in_process::InProcess;
use crate::service::robots::Robots;

/// One run of a scenario.
pub struct Job {
    id: String,
    scenario: Scenario,
    progress: ProgressPublisher,
    run_control: Option<Arc<RunControl>>,
}

impl Job {
    /// Creates a run that waits to begin. A run with a `run_control` is interactive.
    pub fn new(scenario: Scenario, run_control: Option<RunControl>) -> Self {
        Self {
            id: Uuid::new_v4().to_string(),
            progress: ProgressPublisher::new(scenario.cycles()),
            scenario,
            run_control: run_control.map(Arc::new),
        }
    }

    /// ID of the run.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Control periods of the whole run.
    pub fn periods(&self) -> u64 {
        self.progress.periods()
    }

    /// Returns the time since the end; `None` before the end.
    pub fn ended_for(&self) -> Option<Duration> {
        self.progress.ended_for()
    }

    /// Returns whether the run has ended.
    pub fn has_ended(&self) -> bool {
        self.progress.has_ended()
    }

    /// Returns whether the run is interactive.
    pub fn is_interactive(&self) -> bool {
        self.run_control.is_some()
    }

    /// Returns the time since a client last watched or commanded an interactive run that goes on; `None` for other runs.
    pub fn unattended_for(&self) -> Option<Duration> {
        self.run_control.as_ref().filter(|_| !self.has_ended())?.unattended_for()
    }

    /// Finishes an interactive run after its current period.
    pub fn finish(&self) {
        if let Some(run_control) = &self.run_control {
            run_control.finish();
        }
    }

    /// Returns the control of an interactive run.
    pub fn run_control(&self) -> Result<&Arc<RunControl>, ApiError> {
        let not_live = || ApiError::not_live("the simulation was not started as `interactive`");
        self.run_control.as_ref().ok_or_else(not_live)
    }

    /// Returns the control of an interactive run that has not ended.
    pub fn live_run_control(&self) -> Result<&Arc<RunControl>, ApiError> {
        let run_control = self.run_control()?;
        if self.has_ended() {
            return Err(ApiError::not_live("the simulation has ended; start another one"));
        }
        Ok(run_control)
    }

    /// Subscribes to the progress.
    pub fn watch(&self) -> watch::Receiver<Progress> {
        self.progress.watch()
    }

    /// Returns the answer to `GET` now.
    pub fn status(&self) -> Simulation {
        self.status_at(&self.progress.borrow())
    }

    /// Returns the answer to `GET` for this progress.
    pub fn status_at(&self, progress: &Progress) -> Simulation {
        status(&self.id, &self.scenario, self.run_control.as_deref(), progress)
    }

    /// Returns the trace of a finished run.
    pub fn recording(&self) -> Result<Arc<Recording>, ApiError> {
        let progress = self.progress.borrow();
        let recording = progress.result.as_ref().map(|result| Arc::clone(&result.recording));
        recording.ok_or_else(|| {
            let state = match progress.state {
                SimulationState::Queued | SimulationState::Running => "has not finished yet",
                SimulationState::Failed => "failed",
                SimulationState::Cancelled | SimulationState::Finished => "was cancelled",
            };
            ApiError::no_trace(format!("the simulation {state}; only a finished one has a trace"))
        })
    }

    /// Ends the run at the next period. Returns false if the run has ended already.
    pub fn cancel(&self) -> bool {
        self.change(|progress| progress.end(SimulationState::Cancelled))
    }

    /// Changes the progress of a run. Returns false if the run has ended already.
    fn change(&self, change: impl FnOnce(&mut Progress)) -> bool {
        let is_changed = self.progress.change(change);
        if let Some(run_control) = &self.run_control {
            run_control.wake();
        }
        is_changed
    }

    /// Waits for a permit, unless the run is interactive, and simulates the run to its end.
    pub async fn run(self: Arc<Self>, robot: Arc<RobotModel>, permits: Arc<Semaphore>) {
        let mut progress = self.watch();
        let _permit = tokio::select! {
            permit = permits.acquire(), if !self.is_interactive() => Some(permit),
            () = std::future::ready(()), if self.is_interactive() => None,
            _ = progress.wait_for(Progress::has_ended) => return,
        };
        let job = Arc::clone(&self);
        let outcome = background(move |abandoned| job.simulate(&robot, abandoned)).await;
        let outcome = outcome.unwrap_or_else(|_| Err("a defect of the service; the log has the details".to_owned()));
        if let Err(error) = outcome {
            self.change(|progress| {
                progress.error = Some(error);
                progress.end(SimulationState::Failed);
            });
        }
    }

    fn simulate(&self, robot: &Arc<RobotModel>, abandoned: &Abandoned) -> Result<(), String> {
        if !self.change(|progress| progress.state = SimulationState::Running) {
            return Ok(());
        }
        let robots = Robots::none().with(Arc::clone(robot)).map_err(|error| error.to_string())?;
        let service = InProcess::new(robots);
        let recording = match &self.run_control {
            None => {
                let step = |done| {
                    let continues = !abandoned.is_set() && self.progress.advance(done);
                    if continues { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
                };
                run_robot(robot, &self.scenario, &service, CallMode::Session, step)
            }
            Some(run_control) => {
                let mut operator = ControlledOperator::new(run_control, &self.progress, abandoned);
                run_operated(robot, &self.scenario, &service, &mut operator)
            }
        };
        let recording = recording.map_err(|error| error.to_string())?;
        let metrics = convert::metrics_answer(&Metrics::of(&recording));
        self.change(|progress| {
            progress.result = Some(Finished { recording: Arc::new(recording), metrics });
            progress.end(SimulationState::Finished);
        });
        Ok(())
    }
}
