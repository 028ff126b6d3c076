//! The command line.

mod check;
mod compare;
mod config;
mod demo;
mod error;
mod experiment;
mod finite;
mod known;
mod log_filter;
mod one_of;
mod openapi;
mod out_directory;
mod output;
mod parallel_runs;
mod payload;
mod press;
mod progress_bar;
mod range;
mod replay;
mod report;
mod resolve;
mod robot;
mod robots;
mod scenarios;
mod serve;
mod service_choice;
mod settings;
mod simulate;
mod stability;
mod supervisor;
mod sweep;
mod target;
mod text;
mod tool;
mod traces;

use std::ffi::OsString;

use clap::{CommandFactory, Parser, Subcommand};

use self::check::CheckError;
pub use self::error::CliError;
use crate::service::{asyncapi_document, openapi_document};

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
  revprio scenarios show press > mine.toml           print the file of a scenario, for `revprio simulate mine.toml`
  revprio compare stiff_wall_singular --methods damped_least_squares,reverse_priority --solvers closed_form,qp
  revprio simulate stiff_wall --traces csv,mcap      also record it as CSV and for Foxglove
  revprio replay revprio-out/stiff_wall-reverse_priority-auto.mcap
  revprio sweep stiff_wall --vary environment.stiffness=log:1e3..1e6:20 --vary loop.lag_s=lin:0..0.005:6
  revprio report revprio-out                         write the page again from stored recordings
  revprio robots check my_arm.urdf,tip=flange        show what is read from a robot file
  revprio serve --robot my_arm.urdf,tip=flange       serve your own robot
  revprio stability --inertia 15 --damping 150 --environment-stiffness 1e5 --lag-s 0.005
  revprio push --robot panda --axis z --newtons -15 > push.json   a controller that presses, for POST /v1/controllers
  revprio payload readings.csv --robot sawyer --on-tool   bias and payload of a wrist sensor
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
    /// List the scenarios that ship with the program, and print their files.
    Scenarios(scenarios::Options),
    /// List and show the built-in robots, and check a robot file.
    Robots(robots::Options),
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
    /// Print the controller that presses with a force along one axis and holds the others, for POST /v1/controllers.
    Push(press::PushOptions),
    /// Print the controller that presses along one axis and moves back and forth along another one, for POST /v1/controllers.
    Wipe(press::SweepOptions),
    /// Identify bias and payload of a wrist sensor from readings in six postures or more.
    Payload(payload::Options),
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
        Err(CliError::Check(CheckError::Ended(status))) => {
            status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(FAILURE)
        }
        Err(error) => {
            let advice = error.advice().map(|advice| format!("; {advice}")).unwrap_or_default();
            output::print_remark(format_args!("error: {error}{advice}"));
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
            Command::Completions { shell } => completions(shell),
            Command::Load(arguments) => Ok(tool::run("load", &arguments)?),
            Command::Scenarios(options) => scenarios::run(&options),
            Command::Robots(options) => robots::run(&options),
            Command::Simulate(options) => simulate::run(&options),
            Command::Compare(options) => compare::run(&options),
            Command::Replay(options) => replay::run(&options),
            Command::Sweep(options) => sweep::run(&options),
            Command::Report(options) => report::run(&options),
            Command::Stability(options) => stability::run(&options),
            Command::Push(options) => press::run_push(&options),
            Command::Wipe(options) => press::run_wipe(&options),
            Command::Payload(options) => payload::run(&options),
            Command::Resolve(options) => resolve::run(&options),
            Command::Check(options) => Ok(check::run(&options)?),
            Command::Bench(arguments) => Ok(tool::run("bench", &arguments)?),
            Command::Openapi => openapi::run(&openapi_document()),
            Command::Asyncapi => openapi::run(&asyncapi_document()),
        }
    }
}

/// Prints a script with which a shell completes commands and options.
fn completions(shell: clap_complete::Shell) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "revprio", &mut script);
    Ok(output::print_text(String::from_utf8_lossy(&script))?)
}
