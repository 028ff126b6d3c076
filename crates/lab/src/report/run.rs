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
    /// Wraps a recording for a test: the scenario `stiff_wall` and a robot without joints.
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
        Self { scenario: Scenario::find("stiff_wall").unwrap(), robot, recording, requests: None }
    }
}
