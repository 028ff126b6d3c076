//! The input of a report: recorded runs with their scenario and robot.

use revprio_api::wire;
use serde::{Deserialize, Serialize};

use super::requests::Requests;
use crate::simulator::Scenario;
use crate::simulator::recording::Recording;

/// One run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The scenario, with the method and solver of this run.
    pub scenario: Scenario,
    /// The robot.
    pub robot: wire::Robot,
    /// The recorded samples.
    pub recording: Recording,
    /// The HTTP requests; `None` if the service was called as a function.
    pub requests: Option<Requests>,
}

impl Run {
    /// Returns whether the run is that of a built-in scenario or of its beginning, with any method and solver. A changed
    /// copy often keeps the name, but not the results that are known of the scenario.
    #[must_use]
    pub fn is_built_in(&self) -> bool {
        let Some(Ok(mut built_in)) = Scenario::built_in(&self.scenario.name) else { return false };
        built_in.controller.method = self.scenario.controller.method;
        built_in.controller.solver = self.scenario.controller.solver;
        built_in.duration_s = built_in.duration_s.min(self.scenario.duration_s);
        built_in == self.scenario
    }
}

/// The program that made the runs.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Version.
    pub version: String,
    /// The commit, if the program ran inside a clone of its repository.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
}

#[cfg(test)]
impl Run {
    /// Wraps a recording for a test: its built-in scenario, or `stiff_wall` with its name, and a robot without joints.
    pub(crate) fn of(recording: Recording) -> Self {
        let robot = wire::Robot {
            shapes: None,
            name: "none".to_owned(),
            description: String::new(),
            source: wire::RobotSource::Urdf,
            joints: Vec::new(),
            tips: Vec::new(),
            links: Vec::new(),
            chain: None,
        };
        let name = recording.scenario.clone();
        let scenario =
            Scenario::find(&name).unwrap_or_else(|_| Scenario { name, ..Scenario::find("stiff_wall").unwrap() });
        Self { scenario, robot, recording, requests: None }
    }
}
