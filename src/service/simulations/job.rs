//! One run.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use revprio_api::wire::{Simulation, SimulationMetrics, SimulationState};
use revprio_lab::report::metrics::Metrics;
use revprio_lab::simulator::recording::Recording;
use revprio_lab::simulator::{CallMode, Scenario, run_operated, run_robot};
use revprio_robot::RobotModel;
use tokio::sync::{Semaphore, watch};
use uuid::Uuid;

use super::run_control::RunControl;
use crate::service::background::{Abandoned, background};
use crate::service::convert;
use crate::service::error::ApiError;
use crate::service::in_process::InProcess;
use crate::service::robots::Robots;

/// Steps in which watchers see the run go on.
const VISIBLE_STEPS: u64 = 500;

/// One run of a scenario.
pub struct Job {
    id: String,
    scenario: Scenario,
    progress: watch::Sender<Progress>,
    run_control: Option<Arc<RunControl>>,
}

/// How far a run is.
#[derive(Clone)]
pub struct Progress {
    state: SimulationState,
    done: u64,
    error: Option<String>,
    result: Option<Finished>,
    ended: Option<Instant>,
}

/// What a run leaves behind.
#[derive(Clone)]
struct Finished {
    recording: Arc<Recording>,
    metrics: SimulationMetrics,
}

impl Progress {
    /// Whether nothing more will happen.
    pub fn has_ended(&self) -> bool {
        self.ended.is_some()
    }

    fn end(&mut self, state: SimulationState) {
        self.state = state;
        self.ended = Some(Instant::now());
    }
}

impl Job {
    /// A run that waits for its turn; one with a run_control is interactive.
    pub fn new(scenario: Scenario, run_control: Option<RunControl>) -> Self {
        let waiting = Progress { state: SimulationState::Queued, done: 0, error: None, result: None, ended: None };
        Self {
            id: Uuid::new_v4().to_string(),
            scenario,
            progress: watch::channel(waiting).0,
            run_control: run_control.map(Arc::new),
        }
    }

    /// Name of the run.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Control periods of the whole run.
    pub fn periods(&self) -> u64 {
        self.scenario.cycles()
    }

    /// Time since the end; `None` before it.
    pub fn ended_for(&self) -> Option<Duration> {
        self.progress.borrow().ended.map(|ended| ended.elapsed())
    }

    /// Whether nothing more will happen.
    pub fn has_ended(&self) -> bool {
        self.progress.borrow().has_ended()
    }

    /// Where it takes orders, if it is interactive.
    pub fn run_control(&self) -> Option<&Arc<RunControl>> {
        self.run_control.as_ref()
    }

    /// Hears of every visible step.
    pub fn watch(&self) -> watch::Receiver<Progress> {
        self.progress.subscribe()
    }

    /// What `GET` shows now.
    pub fn status(&self) -> Simulation {
        self.status_at(&self.progress.borrow())
    }

    /// What `GET` shows at that point of the run.
    pub fn status_at(&self, progress: &Progress) -> Simulation {
        let stated = (self.scenario.controller.method, self.scenario.controller.solver);
        let (method, solver) = self.run_control.as_ref().map_or(stated, |run_control| run_control.method_and_solver());
        Simulation {
            id: self.id.clone(),
            scenario: self.scenario.name.clone(),
            method,
            solver,
            interactive: self.run_control.as_ref().map(|run_control| run_control.pace()),
            periods: self.periods(),
            state: progress.state,
            progress: progress.done as f64 / self.periods() as f64,
            error: progress.error.clone(),
            metrics: progress.result.as_ref().map(|result| result.metrics),
        }
    }

    /// The trace of a finished run.
    pub fn recording(&self) -> Result<Arc<Recording>, ApiError> {
        let progress = self.progress.borrow();
        let finished = progress.result.as_ref().map(|result| Arc::clone(&result.recording));
        finished.ok_or_else(|| {
            let what = match progress.state {
                SimulationState::Queued | SimulationState::Running => "has not finished yet",
                SimulationState::Failed => "failed",
                SimulationState::Cancelled | SimulationState::Finished => "was cancelled",
            };
            ApiError::no_trace(format!("the simulation {what}; only a finished one has a trace"))
        })
    }

    /// Ends the run at the next period; false if it had ended already.
    pub fn cancel(&self) -> bool {
        self.change(|progress| progress.end(SimulationState::Cancelled))
    }

    /// Changes a run that has not ended; false if it has.
    fn change(&self, change: impl FnOnce(&mut Progress)) -> bool {
        let changed = self.progress.send_if_modified(|progress| {
            let goes_on = !progress.has_ended();
            if goes_on {
                change(progress);
            }
            goes_on
        });
        if let Some(run_control) = &self.run_control {
            run_control.wake();
        }
        changed
    }

    /// Waits for its turn, unless it is interactive, and runs to the end.
    pub async fn run(self: Arc<Self>, robot: Arc<RobotModel>, turns: Arc<Semaphore>) {
        let mut progress = self.watch();
        let _turn = tokio::select! {
            turn = turns.acquire(), if self.run_control.is_none() => Some(turn),
            () = std::future::ready(()), if self.run_control.is_some() => None,
            _ = progress.wait_for(Progress::has_ended) => return,
        };
        let job = Arc::clone(&self);
        let outcome = background(move |abandoned| job.simulate(&robot, abandoned)).await;
        if let Err(error) =
            outcome.unwrap_or_else(|_| Err("a defect of the service; the log has the details".to_owned()))
        {
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
        let step = |done| {
            if !abandoned.is_set() && self.advance(done) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        let recording = match &self.run_control {
            None => run_robot(robot, &self.scenario, &service, CallMode::Session, step),
            Some(run_control) => {
                run_operated(robot, &self.scenario, &service, &mut run_control.operator(self, abandoned))
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

    /// Notes a period that is done; false if the run is to end.
    pub fn advance(&self, done: u64) -> bool {
        let mut goes_on = true;
        self.progress.send_if_modified(|progress| {
            goes_on = !progress.has_ended();
            progress.done = if goes_on { done } else { progress.done };
            goes_on && done.is_multiple_of((self.periods() / VISIBLE_STEPS).max(1))
        });
        goes_on
    }
}
