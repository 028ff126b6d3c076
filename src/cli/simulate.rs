//! `revprio simulate`

use revprio_api::wire::{Method, Solver};
use revprio_lab::report::experiment::Experiment;
use revprio_lab::report::table::{self, side_by_side};
use revprio_lab::simulator::{CallMode, Scenario};

use super::error::CliError;
use super::experiment::{ExperimentRunner, program, write_results};
use super::known::ScenarioName;
use super::one_of::one_of;
use super::out_directory::OutDirectory;
use super::output::print_text;
use super::robot::RobotArgument;
use super::service_choice::ServiceChoice;
use super::text::quoted;
use super::traces;

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Name of a built-in scenario, or a file (.toml or .json)
    #[arg(value_parser = ScenarioName, hide_possible_values = true)]
    scenario: String,
    #[command(flatten)]
    service: ServiceChoice,
    /// Your own robot instead of the robot of the scenario
    #[arg(long, value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP)]
    robot: Option<RobotArgument>,
    /// Method, instead of the method of the scenario
    #[arg(long, value_parser = one_of(&Method::ALL))]
    method: Option<Method>,
    /// Solver, instead of the solver of the scenario
    #[arg(long, value_parser = one_of(&Solver::ALL))]
    solver: Option<Solver>,
    /// Send the controller's memory with every request instead of using a session
    #[arg(long)]
    stateless: bool,
    #[command(flatten)]
    out: OutDirectory,
    #[command(flatten)]
    traces: traces::Options,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    // Read the scenario first, so that an invalid one starts nothing.
    Scenario::find(&options.scenario)?;
    let mode = if options.stateless { CallMode::Stateless } else { CallMode::Session };
    let runner = ExperimentRunner::open(&options.service, options.robot.as_ref(), mode)?;
    let mut scenario = runner.scenario(&options.scenario)?;
    scenario.controller.method = options.method.unwrap_or(scenario.controller.method);
    scenario.controller.solver = options.solver.unwrap_or(scenario.controller.solver);
    runner.warn(&scenario, &options.scenario)?;
    // The service has answered. A wrong address or an invalid scenario leaves no directory.
    let command = command(options, &scenario);
    let out = options.out.create(&command)?;
    let experiment = Experiment {
        title: format!("{}: {}", scenario.name, scenario.description),
        question: Vec::new(),
        command,
        program: program(),
        runs: vec![runner.run(&scenario)?],
        failures: Vec::new(),
    };
    let page = write_results(out, &experiment, &options.traces)?;
    print_text(side_by_side::text(&table::rows(&experiment.runs)))?;
    Ok(print_text(format_args!("\nThe page with figure and recording: {}\n", page.display()))?)
}

/// Returns the command that repeats the run.
fn command(options: &Options, scenario: &Scenario) -> String {
    let (method, solver) = (scenario.controller.method, scenario.controller.solver);
    let stateless = if options.stateless { " --stateless" } else { "" };
    let robot = options.robot.as_ref().map(|robot| format!(" --robot {}", quoted(&robot.to_string())));
    let (scenario, robot) = (quoted(&options.scenario), robot.unwrap_or_default());
    let (service, traces) = (options.service.repeated(), options.traces.repeated());
    format!("revprio simulate {scenario}{robot} --method {method} --solver {solver}{stateless}{service}{traces}")
}
