//! The interactive simulations of the page.

use std::collections::BTreeMap;
use std::sync::Arc;

use revprio_api::wire;
use revprio_lab::simulator::SimulationRequest;
use revprio_local::robots::Robots;
use revprio_local::simulation::{RunControl, check_size};
use revprio_local::{ApiError, convert};

use crate::run::{Advanced, Run};

/// Maximum number of runs that have not ended.
const MAX_RUNNING: usize = 4;

/// Maximum number of runs, with those that have ended.
const MAX_KEPT: usize = 16;

/// The runs by their number.
pub struct Simulations {
    robots: Arc<Robots>,
    runs: BTreeMap<u64, Run>,
    count: u64,
}

impl Simulations {
    /// Creates the list. Runs know these robots.
    pub fn new(robots: Arc<Robots>) -> Self {
        Self { robots, runs: BTreeMap::new(), count: 0 }
    }

    /// Begins a run.
    pub fn create(&mut self, request: SimulationRequest) -> Result<wire::Simulation, ApiError> {
        let interactive = request.interactive;
        convert::check_interactive(interactive.as_ref())?;
        let (scenario, robot) = convert::scenario(request, &self.robots)?;
        let needs_service = "a run without `interactive` needs a service; start one with `revprio serve`";
        let pace = interactive.ok_or_else(|| ApiError::invalid("/interactive", needs_service))?;
        check_size(&scenario)?;
        if self.runs.values().filter(|run| !run.has_ended()).count() >= MAX_RUNNING {
            return Err(ApiError::busy(format!("{MAX_RUNNING} simulations are running; end one, or try again later")));
        }
        let controller = convert::controller(&scenario.controller, &self.robots)?;
        let request = scenario.controller.clone();
        let control = RunControl::new(pace, request, controller, &scenario.start_joint_position)?;
        self.forget_ended();
        let id = self.count + 1;
        let run = Run::begin(id.to_string(), scenario, &robot, control)?;
        let status = run.status();
        self.count = id;
        self.runs.insert(id, run);
        Ok(status)
    }

    /// Returns the answer about a run.
    pub fn status(&mut self, id: &str) -> Result<wire::Simulation, ApiError> {
        self.get(id).map(|run| run.status())
    }

    /// Applies a command.
    pub fn control(&mut self, id: &str, command: &wire::SimulationControl) -> Result<wire::Simulation, ApiError> {
        let robots = Arc::clone(&self.robots);
        let run = self.get(id)?;
        run.command(command, &robots)?;
        Ok(run.status())
    }

    /// Returns the last control period of a run.
    pub fn cycle(&mut self, id: &str) -> Result<wire::StepRequest, ApiError> {
        self.get(id)?.cycle()
    }

    /// Computes the periods of a run that are due.
    pub fn advance(&mut self, id: &str) -> Result<Advanced, ApiError> {
        self.get(id).map(Run::advance)
    }

    /// Cancels a run that has not ended. Deletes one that has ended.
    pub fn delete(&mut self, id: &str) -> Result<(), ApiError> {
        let run = self.get(id)?;
        if run.has_ended() {
            self.runs.retain(|key, _| key.to_string() != id);
        } else {
            run.cancel();
        }
        Ok(())
    }

    /// Deletes the oldest ended runs if there are too many.
    fn forget_ended(&mut self) {
        while self.runs.len() >= MAX_KEPT {
            let Some(oldest) = self.runs.iter().find(|(_, run)| run.has_ended()).map(|(key, _)| *key) else { return };
            self.runs.remove(&oldest);
        }
    }

    fn get(&mut self, id: &str) -> Result<&mut Run, ApiError> {
        let run = id.parse().ok().and_then(|key: u64| self.runs.get_mut(&key));
        run.ok_or_else(|| ApiError::not_found(format!("there is no simulation `{id}`; it may have been deleted")))
    }
}
