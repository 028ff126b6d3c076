//! `revprio simulate`

use std::io::{Write as _, stdout};
use std::path::PathBuf;

use revprio_api::wire::{Method, Solver};
use revprio_lab::report::experiment::Experiment;
use revprio_lab::report::table;
use revprio_lab::simulator::{CallMode, Scenario};

use super::experiment::{ExperimentRunner, leave, make_directory, program};
use super::one_of::one_of;
use super::robot::RobotArgument;
use super::{CliError, traces};

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Name of a built-in scenario, or a file (.toml or .json)
    scenario: String,
    /// Service to call, such as http://127.0.0.1:8080; one of its own if left out
    #[arg(long)]
    server: Option<String>,
    /// An arm of your own instead of the scenario's
    #[arg(long, value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP)]
    robot: Option<RobotArgument>,
    /// Method, instead of the scenario's
    #[arg(long, value_parser = one_of(&Method::ALL))]
    method: Option<Method>,
    /// Solver, instead of the scenario's
    #[arg(long, value_parser = one_of(&Solver::ALL))]
    solver: Option<Solver>,
    /// Let the controller's memory travel with every request instead of keeping a session
    #[arg(long)]
    stateless: bool,
    /// Directory for trace, figures and page
    #[arg(long, default_value = "revprio-out")]
    out: PathBuf,
    #[command(flatten)]
    traces: traces::Options,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    // A scenario that cannot be read is told before a directory is made.
    Scenario::find(&options.scenario)?;
    make_directory(&options.out)?;
    let mode = if options.stateless { CallMode::Stateless } else { CallMode::Session };
    let runner = ExperimentRunner::open(options.server.as_deref(), options.robot.as_ref(), mode)?;
    let mut scenario = runner.scenario(&options.scenario)?;
    scenario.controller.method = options.method.unwrap_or(scenario.controller.method);
    scenario.controller.solver = options.solver.unwrap_or(scenario.controller.solver);
    runner.warn(&scenario)?;
    let experiment = Experiment {
        title: format!("{}: {}", scenario.name, scenario.description),
        question: Vec::new(),
        command: command(options, &scenario),
        program: program(),
        runs: vec![runner.run(&scenario)?],
        failures: Vec::new(),
    };
    write!(stdout(), "{}", table::text(&table::rows(&experiment.runs)))?;
    let page = leave(&options.out, &experiment, &options.traces)?;
    writeln!(stdout(), "\nfigure, trace and one page with both: {}", page.display())?;
    Ok(())
}

/// The command that repeats the run.
fn command(options: &Options, scenario: &Scenario) -> String {
    let (method, solver) = (scenario.controller.method, scenario.controller.solver);
    let stateless = if options.stateless { " --stateless" } else { "" };
    let robot = options.robot.as_ref().map(|robot| format!(" --robot {robot}")).unwrap_or_default();
    format!("revprio simulate {}{robot} --method {method} --solver {solver}{stateless}", options.scenario)
}
