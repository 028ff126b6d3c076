//! The progress of a run, shared by the job, its operator and its watchers.

use std::sync::Arc;
use std::time::Duration;

use revprio_api::clock::Instant;
use revprio_api::wire::{SimulationMetrics, SimulationState};
use revprio_lab::simulator::recording::Recording;
use tokio::sync::watch;

/// Number of progress changes that watchers see in a whole run.
const VISIBLE_CHANGES: u64 = 500;

/// The progress of a run at one moment.
#[derive(Clone)]
pub struct Progress {
    /// State of the run.
    pub state: SimulationState,
    /// Completed control periods.
    pub done: u64,
    /// The reason of a failure.
    pub error: Option<String>,
    /// The result of a finished run.
    pub result: Option<Finished>,
    ended: Option<Instant>,
}

/// The result of a finished run.
#[derive(Clone)]
pub struct Finished {
    /// All control periods.
    pub recording: Arc<Recording>,
    /// Measures of the run.
    pub metrics: SimulationMetrics,
}

impl Progress {
    /// Returns whether the run has ended.
    pub fn has_ended(&self) -> bool {
        self.ended.is_some()
    }

    /// Ends the run.
    pub fn end(&mut self, state: SimulationState) {
        self.state = state;
        self.ended = Some(Instant::now());
    }
}

/// Publishes the progress of one run.
pub struct ProgressPublisher {
    progress: watch::Sender<Progress>,
    /// Control periods of the whole run.
    periods: u64,
}

impl ProgressPublisher {
    /// Creates the progress of a run of this many control periods that waits to begin.
    pub fn new(periods: u64) -> Self {
        let queued = Progress { state: SimulationState::Queued, done: 0, error: None, result: None, ended: None };
        Self { progress: watch::Sender::new(queued), periods }
    }

    /// Control periods of the whole run.
    pub fn periods(&self) -> u64 {
        self.periods
    }

    /// Returns the current progress.
    pub fn borrow(&self) -> watch::Ref<'_, Progress> {
        self.progress.borrow()
    }

    /// Subscribes to the visible changes.
    pub fn watch(&self) -> watch::Receiver<Progress> {
        self.progress.subscribe()
    }

    /// Returns whether the run has ended.
    pub fn has_ended(&self) -> bool {
        self.borrow().has_ended()
    }

    /// Returns the time since the end; `None` before the end.
    pub fn ended_for(&self) -> Option<Duration> {
        self.borrow().ended.map(|ended| ended.elapsed())
    }

    /// Changes the progress of a run. Returns false if the run has ended already.
    pub fn change(&self, change: impl FnOnce(&mut Progress)) -> bool {
        self.progress.send_if_modified(|progress| {
            let is_open = !progress.has_ended();
            if is_open {
                change(progress);
            }
            is_open
        })
    }

    /// Counts completed periods. Returns false if the run has ended already.
    pub fn advance(&self, done: u64) -> bool {
        let mut is_open = true;
        self.progress.send_if_modified(|progress| {
            is_open = !progress.has_ended();
            progress.done = if is_open { done } else { progress.done };
            is_open && done.is_multiple_of((self.periods / VISIBLE_CHANGES).max(1))
        });
        is_open
    }
}
