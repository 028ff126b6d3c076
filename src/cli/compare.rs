//! `revprio compare`

use clap::ValueEnum;
use revprio_api::wire::{Method, Solver};
use revprio_lab::report::experiment::Experiment;
use revprio_lab::report::run::Run;
use revprio_lab::report::table::{Row, side_by_side};
use revprio_lab::report::{self, Output, Report};
use revprio_lab::simulator::{CallMode, Scenario};

use super::error::CliError;
use super::experiment::{ExperimentRunner, program, store, with_traces};
use super::known::ScenarioName;
use super::one_of::one_of;
use super::out_directory::OutDirectory;
use super::output::{print_remark, print_text};
use super::robot::RobotArgument;
use super::service_choice::ServiceChoice;
use super::text::quoted;
use super::traces;

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Names of built-in scenarios, or files (.toml or .json)
    #[arg(required = true, value_name = "SCENARIO", value_parser = ScenarioName, hide_possible_values = true)]
    scenarios: Vec<String>,
    /// Methods to compare, separated by commas
    #[arg(long, value_parser = one_of(&Method::ALL), value_delimiter = ',', default_values_t = DEFAULT_METHODS)]
    methods: Vec<Method>,
    /// Solvers to compare, separated by commas
    #[arg(long, value_parser = one_of(&Solver::ALL), value_delimiter = ',', default_values_t = [Solver::Auto])]
    solvers: Vec<Solver>,
    /// Format of the printed result
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    #[command(flatten)]
    service: ServiceChoice,
    /// Your own robot instead of the robots of the scenarios
    #[arg(long, value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP)]
    robot: Option<RobotArgument>,
    #[command(flatten)]
    out: OutDirectory,
    /// Kinds of files to write, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = Kind::ALL)]
    write: Vec<Kind>,
    #[command(flatten)]
    traces: traces::Options,
}

const DEFAULT_METHODS: [Method; 2] = [Method::DampedLeastSquares, Method::ReversePriority];

/// Format of the printed comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// A table per scenario, with one column per run
    Table,
    /// The metrics of every run
    Json,
    /// Tables and remarks in Markdown, without times that depend on the machine
    Markdown,
}

/// A kind of file that a comparison writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// The page, index.html
    Page,
    /// Figures as SVG
    Svg,
    /// Figures as PNG
    Png,
    /// Recordings, and experiment.json for `revprio report`
    Traces,
}

impl Kind {
    const ALL: [Self; 4] = [Self::Page, Self::Svg, Self::Png, Self::Traces];

    const fn output(self) -> Option<Output> {
        match self {
            Self::Page => Some(Output::Page),
            Self::Svg => Some(Output::Svg),
            Self::Png => Some(Output::Png),
            Self::Traces => None,
        }
    }
}

pub fn run(options: &Options) -> Result<(), CliError> {
    if let Some(option) = options.traces.given().filter(|_| !options.write.contains(&Kind::Traces)) {
        let detail = "it is about recordings; add `traces` to --write".to_owned();
        return Err(CliError::Option { option: option.to_owned(), detail });
    }
    let scenarios = options.scenarios.iter().map(|name| Scenario::find(name)).collect::<Result<Vec<_>, _>>()?;
    check_names(&options.scenarios, &scenarios)?;
    let runner = ExperimentRunner::open(&options.service, options.robot.as_ref(), CallMode::Session)?;
    let own = options.scenarios.iter().map(|name| runner.scenario(name)).collect::<Result<Vec<_>, _>>()?;
    for (scenario, name) in own.iter().zip(&options.scenarios) {
        runner.warn(scenario, name)?;
    }
    // The service has answered. A wrong address or an invalid scenario leaves no directory.
    let out = options.out.create(&command(options))?;
    let (mut runs, mut failures) = (Vec::new(), Vec::new());
    for scenario in &own {
        for variant in variants(scenario, options) {
            match runner.run(&variant) {
                Ok(run) => runs.push(run),
                // A method that fails in this scenario is a result. The other methods are still compared.
                Err(CliError::Run(error)) => failures.push(failure(&variant, &error.to_string())),
                Err(error) => return Err(error),
            }
        }
    }
    if runs.is_empty() {
        return Err(CliError::NothingToCompare(failures.join("; ")));
    }
    let experiment = experiment(options, &scenarios, runs, failures);
    let mut report = experiment.report();
    if options.write.contains(&Kind::Traces) {
        store(out, &experiment, &options.traces)?;
        report = with_traces(report, &experiment, &options.traces);
    }
    let outputs: Vec<Output> = options.write.iter().filter_map(|kind| kind.output()).collect();
    report::write(out, &report, &outputs)?;
    print(options.format, &report)?;
    let page = out.join("index.html");
    let written = if outputs.contains(&Output::Page) { &page } else { out };
    print_remark(format_args!("\nwritten: {}", written.display()));
    Ok(())
}

/// Checks that no two scenarios have the same name. Recordings are named after it, so one would replace the other.
fn check_names(given: &[String], scenarios: &[Scenario]) -> Result<(), CliError> {
    for (i, scenario) in scenarios.iter().enumerate() {
        if let Some(earlier) = scenarios[..i].iter().position(|other| other.name == scenario.name) {
            let [first, second] = [&given[earlier], &given[i]].map(String::clone);
            return Err(CliError::SameName { name: scenario.name.clone(), first, second });
        }
    }
    Ok(())
}

/// Returns the scenario with every method and solver, without duplicates.
fn variants(scenario: &Scenario, options: &Options) -> Vec<Scenario> {
    let mut variants: Vec<Scenario> = Vec::new();
    for method in &options.methods {
        for solver in &options.solvers {
            let mut variant = scenario.clone();
            (variant.controller.method, variant.controller.solver) = (*method, *solver);
            if !variants.contains(&variant) {
                variants.push(variant);
            }
        }
    }
    variants
}

fn failure(variant: &Scenario, error: &str) -> String {
    let wire = &variant.controller;
    let text = format!("{}, {}, {} did not finish: {error}", variant.name, wire.method, wire.solver);
    print_remark(format_args!("warning: {text}"));
    text + "."
}

fn experiment(options: &Options, scenarios: &[Scenario], runs: Vec<Run>, failures: Vec<String>) -> Experiment {
    let names: Vec<&str> = scenarios.iter().map(|scenario| scenario.name.as_str()).collect();
    let described = scenarios.iter().map(|scenario| format!("{}: {}.", scenario.name, scenario.description));
    Experiment {
        title: format!("{}: {} runs compared", names.join(", ").replace('_', " "), runs.len()),
        question: [QUESTION.to_owned()].into_iter().chain(described).collect(),
        command: command(options),
        program: program(),
        runs,
        failures,
    }
}

const QUESTION: &str = "This page compares different methods or solvers with the same robot, tasks and contacts: which of them \
     keep the first task and the limits, and how large are the residuals of the other tasks?";

/// Returns the command that repeats the comparison.
fn command(options: &Options) -> String {
    let list = |words: Vec<String>| words.join(",");
    let methods = list(options.methods.iter().map(ToString::to_string).collect());
    let solvers = list(options.solvers.iter().map(ToString::to_string).collect());
    let scenarios: Vec<_> = options.scenarios.iter().map(|scenario| quoted(scenario)).collect();
    let robot = options.robot.as_ref().map(|robot| format!(" --robot {}", quoted(&robot.to_string())));
    let kinds: Vec<_> =
        options.write.iter().filter_map(|kind| Some(kind.to_possible_value()?.get_name().to_owned())).collect();
    let write = if options.write == Kind::ALL { String::new() } else { format!(" --write {}", list(kinds)) };
    let (scenarios, robot) = (scenarios.join(" "), robot.unwrap_or_default());
    let (service, traces) = (options.service.repeated(), options.traces.repeated());
    format!("revprio compare {scenarios}{robot} --methods {methods} --solvers {solvers}{service}{write}{traces}")
}

/// Prints the report.
pub fn print(format: Format, report: &Report) -> Result<(), CliError> {
    match format {
        Format::Table => print_text(side_by_side::text(&report.rows)),
        Format::Json => print_text(json(&report.rows) + "\n"),
        Format::Markdown => print_text(report::markdown::document(report)),
    }?;
    Ok(())
}

/// Serializes the rows; values that are not finite are `null`.
fn json(rows: &[Row]) -> String {
    serde_json::to_string_pretty(&serde_json::json!({ "runs": rows })).unwrap_or_default()
}
