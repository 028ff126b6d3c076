//! Why a command failed.

use std::path::PathBuf;

use revprio_api::ClientError;
use revprio_api::wire::read_error::in_plain_words;
use revprio_lab::simulator::recording::{ReadError, WriteError};
use revprio_lab::simulator::replay::ReplayError;
use revprio_lab::simulator::{RunError, ScenarioError};
use revprio_robot::RobotFileError;

use super::check::CheckError;
use super::robot::RobotArgumentError;
use super::settings::SettingsError;
use super::tool::ToolError;
use crate::service::{RobotsError, ServeError};

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The service cannot start.
    #[error(transparent)]
    Serve(#[from] ServeError),
    /// The settings are not valid.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The benchmark program cannot be run.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// An answer is not checked, or its certificate does not hold.
    #[error(transparent)]
    Check(#[from] CheckError),
    /// A preset gives no tasks.
    #[error(transparent)]
    Preset(#[from] revprio_api::presets::PresetError),
    /// The service refuses what an option says.
    #[error("{option}: {detail}")]
    Option {
        /// The option that is wrong.
        option: String,
        /// What is wrong with it.
        detail: String,
    },
    /// A robot file is not valid.
    #[error(transparent)]
    RobotFile(#[from] RobotFileError),
    /// The value of `--robot` cannot be used.
    #[error(transparent)]
    RobotArgument(#[from] RobotArgumentError),
    /// The name of a robot is not valid or already in use.
    #[error("--robot: {0}; write `FILE,name=NAME`")]
    Robots(#[from] RobotsError),
    /// The name of a file of `--robots-dir` is not valid or already in use.
    #[error("--robots-dir: {path}: {source}; rename the file")]
    RobotsDirectory {
        /// The file.
        path: PathBuf,
        /// What is wrong with its name.
        source: RobotsError,
    },
    /// The scenario cannot be read.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The service refuses the controller of a scenario file.
    #[error("{place}: {refusal}")]
    RefusedScenario {
        /// The file and the line of the field.
        place: String,
        /// What the service says.
        refusal: ClientError,
    },
    /// The run ended early.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The service did not answer.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The report cannot be written.
    #[error(transparent)]
    Report(#[from] revprio_lab::report::Error),
    /// Requests of a run were lost, or its service had another client.
    #[error("the client sent {sent} requests, but its own service answered {answered}")]
    Requests {
        /// Requests of the client.
        sent: u64,
        /// Answers of the service.
        answered: u64,
    },
    /// The demonstration is not valid.
    #[error("the demonstration failed: {}", .0.join("; "))]
    Demo(Vec<String>),
    /// Two scenarios of a comparison have the same name.
    #[error(
        "{first} and {second} have the same name, `{name}`, and their recordings would have the same file names; change \
         `name` in one of the files, or leave one out"
    )]
    SameName {
        /// The name.
        name: String,
        /// The first scenario, as given.
        first: String,
        /// The second scenario, as given.
        second: String,
    },
    /// No run finished.
    #[error("no run finished, so there is nothing to compare: {0}")]
    NothingToCompare(String),
    /// A recording cannot be written.
    #[error("cannot write {path}: {source}")]
    Trace {
        /// The file.
        path: PathBuf,
        /// The error.
        source: WriteError,
    },
    /// The file is not a recording.
    #[error("cannot read {path}: {source}")]
    ReadRecording {
        /// The file.
        path: PathBuf,
        /// The error.
        source: Box<ReadError>,
    },
    /// The sweep cannot be run, or its files cannot be used.
    #[error("{0}")]
    Sweep(String),
    /// The recording cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// A recording has no answer to compare with.
    #[error("{path}: no state of this recording has an answer, so that nothing is compared")]
    NothingRecorded {
        /// The recording.
        path: PathBuf,
    },
    /// The replayed answers differ from the recorded ones.
    #[error("{answers} answers differ from the recording")]
    Differs {
        /// Number of answers.
        answers: usize,
    },
    /// The output directory cannot be created.
    #[error("cannot create {path}: {source}")]
    Directory {
        /// The directory.
        path: PathBuf,
        /// The error.
        source: std::io::Error,
    },
    /// The problem file cannot be read.
    #[error("cannot read {path}: {source}")]
    ReadProblem {
        /// The file.
        path: PathBuf,
        /// The error.
        source: std::io::Error,
    },
    /// The problem file is not a valid request.
    #[error("{path}: {}", in_plain_words(&source.to_string()))]
    ParseProblem {
        /// The file.
        path: PathBuf,
        /// The error.
        source: serde_json::Error,
    },
    /// The table with the readings of a sensor cannot be read.
    #[error("{}: {message}", path.display())]
    PayloadTable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// Standard output cannot be written.
    #[error("cannot print: {0}")]
    Print(#[from] std::io::Error),
}

impl CliError {
    /// Returns how to give the program the token of a service that refused a request without it.
    pub fn advice(&self) -> Option<&'static str> {
        let (Self::Client(refusal)
        | Self::RefusedScenario { refusal, .. }
        | Self::RobotArgument(RobotArgumentError::Client(refusal))
        | Self::Run(RunError::Service { source: refusal, .. })
        | Self::Replay(ReplayError::Run(RunError::Service { source: refusal, .. }))) = self
        else {
            return None;
        };
        match refusal {
            ClientError::Refused { problem, .. } if problem.status == UNAUTHORIZED => Some(TOKEN),
            _ => None,
        }
    }
}

/// Status of an answer to a request without the right token.
const UNAUTHORIZED: u16 = 401;

const TOKEN: &str =
    "set the environment variable REVPRIO_TOKEN_FILE to the path of a file with the token of the service";
