//! Who stands beside a run: lets time pass, pushes the arm, changes the controller, ends it.

use std::ops::ControlFlow;
use std::time::Duration;

use revprio_api::wire;

use super::recording::Sample;

/// What happens to a run in one period, besides what the scenario says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Influence {
    /// Pushes the tool, N, base axes.
    pub external_force: [f64; 3],
    /// The controller from this period on. It continues from the memory of the one before, so it must have the same rows.
    pub controller: Option<wire::Controller>,
}

/// How a run ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// What was recorded is of no use.
    Stop,
    /// What was recorded is the run.
    Finish,
}

/// A period that is done.
#[derive(Debug)]
pub struct Observed<'a> {
    /// What is recorded of it.
    pub sample: &'a Sample,
    /// The answer that the arm obeyed.
    pub answer: &'a wire::StepAnswer,
    /// Time between state and answer.
    pub round_trip: Duration,
    /// What was asked, where no session keeps the memory.
    pub cycle: Option<Cycle<'a>>,
}

/// The parts of a stateless step.
#[derive(Debug, Clone, Copy)]
pub struct Cycle<'a> {
    /// The controller.
    pub controller: &'a wire::Controller,
    /// The measured state.
    pub state: &'a wire::State,
    /// The memory of the period before.
    pub memory: Option<&'a wire::Memory>,
}

impl Cycle<'_> {
    /// The step as a request of its own.
    pub fn request(&self) -> wire::StepRequest {
        wire::StepRequest {
            controller: self.controller.clone(),
            state: self.state.clone(),
            memory: self.memory.cloned(),
        }
    }
}

/// The run's view of who stands beside it.
pub trait Operator {
    /// What happens in the next period; simulated time stands still until this returns.
    fn influence(&mut self, _period: u64) -> Influence {
        Influence::default()
    }

    /// Sees a period; `done` counts them, this one included.
    fn see(&mut self, done: u64, period: &Observed);

    /// Whether the run goes on: asked after each period, and again and again while the service is silent.
    fn goes_on(&mut self) -> ControlFlow<Ending>;
}

/// Looks at the progress alone.
pub struct ProgressObserver<F> {
    progress: F,
    done: u64,
}

impl<F: FnMut(u64) -> ControlFlow<()>> ProgressObserver<F> {
    /// `progress` hears how many periods are done and may end the run.
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
