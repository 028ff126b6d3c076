//! Control of a run while it is in progress: pace, pushes, changes of the controller, early end.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Duration;

use revprio_api::wire;

use super::recording::Sample;
use super::stateless::Cycle;

/// Influence on one period of a run, in addition to the scenario.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Influence {
    /// Force that pushes the tool, N, base axes.
    pub external_force: [f64; 3],
    /// The controller from this period on. It continues with the memory of the previous one, so it must have the same rows.
    pub controller: Option<wire::Controller>,
    /// New targets by task name; part of the state of this period.
    pub targets: BTreeMap<String, wire::StreamedTarget>,
}

/// How a run ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The run fails; its samples are discarded.
    Stop,
    /// The run succeeds with the samples recorded so far.
    Finish,
}

/// A completed period.
#[derive(Debug)]
pub struct Observed<'a> {
    /// The recorded sample.
    pub sample: &'a Sample,
    /// Where the moving obstacles are.
    pub obstacles: &'a [wire::ObstacleState],
    /// The answer that the arm executed.
    pub answer: &'a wire::StepAnswer,
    /// Real time between state and answer.
    pub round_trip: Duration,
    /// Input of the step; `None` in a session.
    pub cycle: Option<Cycle<'a>>,
}

/// Observes and controls a run.
pub trait Operator {
    /// Returns the influence on the next period. Simulated time does not advance until this returns.
    fn influence(&mut self, _period: u64) -> Influence {
        Influence::default()
    }

    /// Receives a completed period; `done` is the number of completed periods.
    fn see(&mut self, done: u64, period: &Observed);

    /// Returns whether the run continues. Called after each period, and repeatedly while the service does not answer.
    fn goes_on(&mut self) -> ControlFlow<Ending>;
}

/// An operator that only reports progress.
pub struct ProgressObserver<F> {
    progress: F,
    done: u64,
}

impl<F: FnMut(u64) -> ControlFlow<()>> ProgressObserver<F> {
    /// `progress` receives the number of completed periods and may end the run.
    pub fn new(progress: F) -> Self {
        Self { progress, done: 0 }
    }
}

impl<F: FnMut(u64) -> ControlFlow<()>> Operator for ProgressObserver<F> {
    fn see(&mut self, done: u64, _period: &Observed) {
        self.done = done;
    }

    fn goes_on(&mut self) -> ControlFlow<Ending> {
        match (self.progress)(self.done) {
            ControlFlow::Continue(()) => ControlFlow::Continue(()),
            ControlFlow::Break(()) => ControlFlow::Break(Ending::Stop),
        }
    }
}
