//! The command line.

mod check;
mod compare;
mod config;
mod demo;
mod experiment;
mod one_of;
mod openapi;
mod output;
mod parallel_runs;
mod replay;
mod report;
mod resolve;
mod robot;
mod scenarios;
mod serve;
mod service_choice;
mod settings;
mod simulate;
mod stability;
mod supervisor;
mod sweep;
mod text;
mod tool;
mod traces;

use std::ffi::OsString;
use std::fmt;
use std::path::{Path, PathBuf};

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use revprio_api::wire::read_error::in_plain_words;
use revprio_api::{Client, ClientError};
use revprio_lab::report::number::significant;
use revprio_lab::simulator::recording::{ReadError, WriteError};
use revprio_lab::simulator::replay::ReplayError;
use revprio_lab::simulator::{RunError, ScenarioError};
use revprio_robot::RobotFileError;

use self::check::CheckError;
use self::settings::SettingsError;
use crate::service::{
    AppState, Robots, RobotsError, RunningServer, ServeError, Token, asyncapi_document, openapi_document, router,
};

/// Velocity resolution of redundant robot arms by reverse task priority, as a service.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true, after_help = EXAMPLES)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// The arguments as they were given.
    #[arg(skip)]
    arguments: Vec<OsString>,
}

const EXAMPLES: &str = "Examples:
  revprio demo                                       run the paper's experiments over HTTP, figures in ./revprio-out
  revprio serve                                      serve on 127.0.0.1:8080
  revprio serve --listen 0.0.0.0:8443 --token-file token --tls-cert cert.pem --tls-key key.pem
  revprio config --config service.toml               print the settings in force and who set them
  revprio simulate stiff_wall --solver qp            run one experiment with its own service
  revprio simulate stiff_wall --server http://127.0.0.1:8080
  revprio compare stiff_wall_singular --methods damped_least_squares,reverse_priority --solvers closed_form,qp
  revprio simulate stiff_wall --traces csv,mcap      also record it as CSV and for Foxglove
  revprio replay revprio-out/stiff_wall-reverse_priority-auto.mcap
  revprio sweep stiff_wall --vary environment.stiffness=log:1e3..1e6:20 --vary loop.lag_s=lin:0..0.005:6
  revprio report revprio-out                         write the page again from stored recordings
  revprio serve --robot my_arm.urdf,tip=flange       serve your own robot
  revprio stability --inertia 15 --damping 150 --environment-stiffness 1e5 --lag-s 0.005
  revprio bench --only core,http                     measure speed next to other programs
  revprio resolve api/examples/resolve.json          resolve one problem and explain the answer
  revprio check request.json answer.json             check the certificate of an answer, with Python";

#[derive(Debug, Subcommand)]
enum Command {
    /// Reproduce the experiments of the paper over HTTP: table, figures, recordings and an HTML page.
    Demo(demo::Options),
    /// Serve HTTP/JSON.
    Serve(settings::Options),
    /// Print the settings that `serve` would use, and the source of each.
    Config(settings::Options),
    /// Print a completion script for a shell.
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// List the scenarios that ship with the program.
    Scenarios,
    /// Run one scenario with the built-in simulator against a service.
    Simulate(simulate::Options),
    /// Run scenarios with several methods and solvers and compare them side by side.
    Compare(compare::Options),
    /// Send the states of a recording to a service again and compare the answers.
    Replay(replay::Options),
    /// Run one scenario with many values of its parameters, on all cores.
    Sweep(sweep::Options),
    /// Write the page again from the output directory of `simulate`, `demo` or `compare`.
    Report(report::Options),
    /// Compute the stability margins of one axis in contact: maximum lag, maximum delay, minimum damping.
    Stability(stability::Options),
    /// Resolve one problem and print the answer as a table.
    Resolve(resolve::Options),
    /// Check the certificate of an answer with a program that shares no code with revprio.
    Check(check::Options),
    /// Measure speed next to other programs (`cargo run --release -p revprio-bench -- bench --help`).
    #[command(disable_help_flag = true)]
    Bench(tool::Arguments),
    /// Print the OpenAPI document of the HTTP interface.
    Openapi,
    /// Print the AsyncAPI document of the WebSocket stream.
    Asyncapi,
    /// Test a server under 1, 2 and 10 times its capacity, and with slow clients.
    #[command(hide = true, disable_help_flag = true)]
    Load(tool::Arguments),
}

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
    Tool(#[from] tool::ToolError),
    /// An answer is not checked, or its certificate does not hold.
    #[error(transparent)]
    Check(#[from] CheckError),
    /// A robot file is not valid.
    #[error(transparent)]
    RobotFile(#[from] RobotFileError),
    /// The file with the overrides of a robot is not valid.
    #[error("--robot FILE,overrides={path}: {message}")]
    Overrides {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// The name of a robot is not valid or already in use.
    #[error("--robot: {0}; choose another name: `FILE,name=NAME`")]
    Robots(#[from] RobotsError),
    /// The name of a file of `--robots-dir` is not valid or already in use.
    #[error("--robots-dir: {path}: {source}; rename the file")]
    RobotsDirectory {
        /// The file.
        path: PathBuf,
        /// What is wrong with its name.
        source: RobotsError,
    },
    /// The server has another robot of that name.
    #[error("{server} has another robot `{name}`; choose another name: `FILE,name=NAME`")]
    OtherRobot {
        /// The service.
        server: String,
        /// The name.
        name: String,
    },
    /// Only URDF robots can be registered at a server.
    #[error(
        "only URDF robots can be registered at a running server; start it with `revprio serve --robot {0}`, or leave out \
         --server"
    )]
    NotSent(String),
    /// The scenario cannot be read.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
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
    /// Standard output cannot be written.
    #[error("cannot print: {0}")]
    Print(#[from] std::io::Error),
}

/// Runs the program with these arguments, the first of which is its name. Returns its exit status.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => Cli { arguments: arguments.into_iter().skip(1).collect(), ..cli },
        Err(error) => {
            // The output may be full or closed.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(FAILURE);
        }
    };
    match cli.run() {
        Ok(()) => 0,
        // The program that checks has printed why.
        Err(CliError::Check(CheckError::Ended(status))) => status,
        Err(error) => {
            output::print_remark(format_args!("error: {error}"));
            FAILURE
        }
    }
}

/// Exit status of a command that failed.
const FAILURE: u8 = 1;

impl Cli {
    /// Runs the command.
    pub fn run(self) -> Result<(), CliError> {
        match self.command {
            Command::Demo(options) => demo::run(&options, &text::command_line(&self.arguments)),
            Command::Serve(options) => serve::run(&options),
            Command::Config(options) => config::run(&options),
            Command::Completions { shell } => config::completions(shell),
            Command::Load(arguments) => Ok(tool::run("load", &arguments)?),
            Command::Scenarios => scenarios::run(),
            Command::Simulate(options) => simulate::run(&options),
            Command::Compare(options) => compare::run(&options),
            Command::Replay(options) => replay::run(&options),
            Command::Sweep(options) => sweep::run(&options),
            Command::Report(options) => report::run(&options),
            Command::Stability(options) => stability::run(&options),
            Command::Resolve(options) => resolve::run(&options),
            Command::Check(options) => check::run(&options),
            Command::Bench(arguments) => Ok(tool::run("bench", &arguments)?),
            Command::Openapi => openapi::run(&openapi_document()),
            Command::Asyncapi => openapi::run(&asyncapi_document()),
        }
    }
}

/// The service that a command calls: a given one, or its own service that runs as long as this value exists.
struct Target {
    client: Client,
    own: Option<RunningServer>,
}

impl Target {
    /// Opens a given service, with the token in the file `REVPRIO_TOKEN_FILE` if it is set, or starts an own service.
    fn open(url: Option<&str>) -> Result<Self, CliError> {
        if let Some(url) = url {
            let file = std::env::var_os("REVPRIO_TOKEN_FILE").filter(|file| !file.is_empty());
            let token = file.map(|file| Token::read(Path::new(&file))).transpose().map_err(SettingsError::from)?;
            let client = Client::new(url);
            let with_token = token.and_then(|token| client.clone().with_token(token.secret()));
            return Ok(Self { client: with_token.unwrap_or(client), own: None });
        }
        Ok(Self::own(Robots::built_in())?)
    }

    /// Starts an own service with these robots.
    fn own(robots: Robots) -> Result<Self, ServeError> {
        let own = RunningServer::start(router(AppState::new(robots)))?;
        Ok(Self { client: Client::new(&own.url()), own: Some(own) })
    }

    /// Returns the number of requests that the own service has answered, or that this client has sent to a given one.
    fn requests(&self) -> u64 {
        self.own.as_ref().map_or_else(|| self.client.requests(), RunningServer::answered)
    }
}

/// Returns a progress bar; it is hidden without a terminal.
fn progress_bar(periods: u64, label: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix:<60} {bar:30} {pos:>6}/{len} {rate:>8}, {eta} left");
    let rate = |state: &ProgressState, text: &mut dyn fmt::Write| {
        let _ = write!(text, "{}/s", significant(state.per_sec(), 3));
    };
    let style = style.map(|style| style.with_key("rate", rate));
    let bar = ProgressBar::new(periods).with_prefix(label.to_owned());
    style.map_or(bar.clone(), |style| bar.with_style(style))
}
