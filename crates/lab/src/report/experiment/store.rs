//! Stores an experiment in a directory: `experiment.json` and the recordings.

use std::fs;
use std::path::Path;

use revprio_api::wire;
use serde::{Deserialize, Serialize};

use super::Experiment;
use crate::report::Error;
use crate::report::requests::Requests;
use crate::report::run::{Program, Run};
use crate::simulator::Scenario;
use crate::simulator::recording::{self, Recording};

/// Name of the file that describes the recordings in its directory.
pub const FILE: &str = "experiment.json";

/// Content of the file.
#[derive(Serialize, Deserialize)]
struct Stored {
    title: String,
    question: Vec<String>,
    command: String,
    program: Program,
    runs: Vec<StoredRun>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    failures: Vec<String>,
}

/// One run, without its samples.
#[derive(Serialize, Deserialize)]
struct StoredRun {
    /// File names of the same recording in several formats; the first is read.
    traces: Vec<String>,
    wall_time_s: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    requests: Option<Requests>,
    scenario: Scenario,
    robot: wire::Robot,
}

/// Writes `experiment.json`, without the recordings.
///
/// # Errors
///
/// [`Error::Write`] if the file cannot be written.
pub fn write(
    directory: &Path,
    experiment: &Experiment,
    trace_names: impl Fn(&Recording) -> Vec<String>,
) -> Result<(), Error> {
    let run = |run: &Run| StoredRun {
        traces: trace_names(&run.recording),
        wall_time_s: run.recording.wall_time_s,
        requests: run.requests,
        scenario: run.scenario.clone(),
        robot: run.robot.clone(),
    };
    let stored = Stored {
        title: experiment.title.clone(),
        question: experiment.question.clone(),
        command: experiment.command.clone(),
        program: experiment.program.clone(),
        runs: experiment.runs.iter().map(run).collect(),
        failures: experiment.failures.clone(),
    };
    let path = directory.join(FILE);
    let write = serde_json::to_string_pretty(&stored).map_err(Into::into).and_then(|text| fs::write(&path, text));
    write.map_err(|source| Error::Write { path, source })
}

/// Reads an experiment and the names of its recordings from a directory.
///
/// # Errors
///
/// [`Error::Read`] if `experiment.json` cannot be read, [`Error::Parse`] if it is not valid, [`Error::Trace`] if a
/// recording cannot be read.
pub fn read(directory: &Path) -> Result<(Experiment, Vec<String>), Error> {
    let path = directory.join(FILE);
    let text = fs::read_to_string(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
    let stored: Stored = serde_json::from_str(&text).map_err(|source| Error::Parse { path, source })?;
    let traces = stored.runs.iter().flat_map(|run| run.traces.clone()).collect();
    let run = |StoredRun { traces, wall_time_s, requests, scenario, robot }: StoredRun| {
        let path = directory.join(traces.first().map_or("", String::as_str));
        let recording = recording::read(&path).map_err(|source| Error::Trace { path, source: Box::new(source) })?;
        let recording = Recording { wall_time_s, ..recording };
        Ok(Run { scenario, robot, recording, requests })
    };
    let Stored { title, question, command, program, runs, failures } = stored;
    let runs = runs.into_iter().map(run).collect::<Result<Vec<_>, Error>>()?;
    Ok((Experiment { title, question, command, program, runs, failures }, traces))
}
