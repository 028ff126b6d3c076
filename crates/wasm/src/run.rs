//! One interactive run, which the host advances.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use revprio_api::clock::Instant;
use revprio_api::wire;
use revprio_api::wire::SimulationState;
use revprio_lab::metrics::Metrics;
use revprio_lab::simulator::{Ending, Influence, Observed, Operator, RunError, Scenario, SteppedRun};
use revprio_local::robots::Robots;
use revprio_local::simulation::{Camera, Finished, Pacer, Picture, ProgressPublisher, RunControl, Turn, status};
use revprio_local::stateless_service::StatelessService;
use revprio_local::{ApiError, convert};
use revprio_robot::RobotModel;
use serde::Serialize;

/// Longest computation of one call of the host. Commands and requests of the page wait as long.
const MAX_BURST: Duration = Duration::from_millis(20);

/// What happened in a run since the last call: the event of the live view, if there is a new one.
#[derive(Debug, Serialize)]
pub struct Advanced {
    /// `frame`, or `end` for the last one.
    pub name: &'static str,
    /// The frame; `None`: nothing new.
    pub frame: Option<wire::LiveFrame>,
}

/// An interactive run.
pub struct Run {
    id: String,
    scenario: Scenario,
    control: Arc<RunControl>,
    progress: ProgressPublisher,
    pacer: Pacer,
    camera: Option<Camera>,
    /// `None` after the end.
    stepped: Option<SteppedRun<'static>>,
    shown: Option<Arc<Picture>>,
    /// Number of samples that the host has.
    seen: usize,
}

impl Run {
    /// Begins a run.
    pub fn begin(
        id: String,
        scenario: Scenario,
        robot: &Arc<RobotModel>,
        control: RunControl,
    ) -> Result<Self, ApiError> {
        let robots = Robots::none().with(Arc::clone(robot)).map_err(|error| convert::robots_error(&error))?;
        let service = Box::new(StatelessService::new(robots));
        let stepped = SteppedRun::operated(robot, scenario.clone(), service);
        let stepped = stepped.map_err(|error| ApiError::invalid("/scenario", error))?;
        let (control, progress) = (Arc::new(control), ProgressPublisher::new(scenario.cycles()));
        progress.change(|progress| progress.state = SimulationState::Running);
        Ok(Self {
            id,
            progress,
            pacer: Pacer::new(scenario.period_s()),
            camera: Some(Camera::new(Arc::clone(&control))),
            stepped: Some(stepped),
            shown: None,
            seen: 0,
            scenario,
            control,
        })
    }

    /// Returns the answer about the run.
    pub fn status(&self) -> wire::Simulation {
        status(&self.id, &self.scenario, Some(&self.control), &self.progress.borrow())
    }

    /// Returns whether the run has ended.
    pub fn has_ended(&self) -> bool {
        self.progress.has_ended()
    }

    /// Ends the run at once.
    pub fn cancel(&mut self) {
        self.progress.change(|progress| progress.end(SimulationState::Cancelled));
        self.stepped = None;
    }

    /// Applies a command.
    pub fn command(&self, command: &wire::SimulationControl, robots: &Robots) -> Result<(), ApiError> {
        if self.has_ended() {
            return Err(ApiError::not_live("the simulation has ended; start another one"));
        }
        self.control.apply(command, robots)
    }

    /// Returns the last control period as a request.
    pub fn cycle(&self) -> Result<wire::StepRequest, ApiError> {
        self.control.cycle()
    }

    /// Computes the periods that are due, and returns the new frame, if there is one.
    pub fn advance(&mut self) -> Advanced {
        let begin = Instant::now();
        while begin.elapsed() < MAX_BURST && self.step_if_due().is_continue() {}
        let picture = self.control.live().picture();
        let name = if self.has_ended() { "end" } else { "frame" };
        let is_new = self.shown.as_ref().is_none_or(|shown| !Arc::ptr_eq(shown, &picture));
        if !is_new && !self.has_ended() {
            return Advanced { name, frame: None };
        }
        let frame = self.control.frame(&picture, self.status(), &mut self.seen);
        self.shown = Some(picture);
        Advanced { name, frame: Some(frame) }
    }

    /// Computes a period if it is due. Returns whether another one can follow in this call.
    fn step_if_due(&mut self) -> ControlFlow<()> {
        let Self { control, progress, pacer, camera, stepped, .. } = self;
        let (Some(run), Some(camera)) = (stepped, camera) else { return ControlFlow::Break(()) };
        let mut commands = control.lock();
        if !commands.finish {
            match pacer.turn(&mut commands, Instant::now()) {
                Turn::Period => (),
                Turn::Paused => {
                    drop(commands);
                    camera.publish();
                    return ControlFlow::Break(());
                }
                Turn::Wait(_) => return ControlFlow::Break(()),
            }
        }
        drop(commands);
        let mut operator = PageOperator { control, progress, camera, external_force: [0.0; 3] };
        match run.step(&mut operator) {
            Ok(ControlFlow::Continue(())) => ControlFlow::Continue(()),
            end => {
                camera.publish();
                self.end(end.map(|_| ()));
                ControlFlow::Break(())
            }
        }
    }

    /// Keeps the result of the run.
    fn end(&mut self, result: Result<(), RunError>) {
        let (run, progress) = (self.stepped.take(), &self.progress);
        match (result, run) {
            (Ok(()), Some(run)) => {
                let recording = Arc::new(run.finish());
                let metrics = convert::metrics_answer(&Metrics::of(&recording));
                progress.change(|progress| {
                    progress.result = Some(Finished { recording, metrics });
                    progress.end(SimulationState::Finished);
                });
            }
            (Err(error), _) => {
                progress.change(|progress| {
                    progress.error = Some(error.to_string());
                    progress.end(SimulationState::Failed);
                });
            }
            (Ok(()), None) => (),
        }
    }
}

/// Applies the commands of the page to one period.
struct PageOperator<'a> {
    control: &'a RunControl,
    progress: &'a ProgressPublisher,
    camera: &'a mut Camera,
    external_force: [f64; 3],
}

impl Operator for PageOperator<'_> {
    fn influence(&mut self, _period: u64) -> Influence {
        let mut commands = self.control.lock();
        let (controller, targets) = (commands.take_new_controller(), commands.take_targets());
        self.external_force = commands.external_force();
        Influence { external_force: self.external_force, controller, targets }
    }

    fn see(&mut self, done: u64, period: &Observed) {
        self.camera.record(done, period, self.external_force);
        self.progress.advance(done);
    }

    fn goes_on(&mut self) -> ControlFlow<Ending> {
        if self.control.lock().finish { ControlFlow::Break(Ending::Finish) } else { ControlFlow::Continue(()) }
    }
}
