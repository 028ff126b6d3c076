//! `revprio demo`

use std::io::{Write as _, stdout};
use std::path::PathBuf;

use revprio_api::wire::{Method, Solver};
use revprio_lab::report::Output;
use revprio_lab::report::checks::{agreement, solver_differences};
use revprio_lab::report::clarabel_checks::{self, clarabel_failures};
use revprio_lab::report::experiment::Experiment;
use revprio_lab::report::metrics::largest_difference;
use revprio_lab::report::run::Run;
use revprio_lab::report::table::summary;
use revprio_lab::simulator::recording::Format;
use revprio_lab::simulator::{PAPER_SCENARIOS, Scenario};

use super::experiment::{label, make_directory, program, write_report};
use super::parallel_runs::run_all;
use super::{CliError, traces};

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Directory for recordings, figures and page
    #[arg(long, default_value = "revprio-out")]
    out: PathBuf,
    /// Simulate only the first second of each experiment. The forces do not settle in it, but all checks apply
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    traces: traces::Options,
}

/// Methods and solvers that are compared in every scenario.
const VARIANTS: [(Method, Solver); 4] = [
    (Method::ReversePriority, Solver::ClosedForm),
    (Method::ReversePriority, Solver::Qp),
    (Method::ReversePriority, Solver::Auto),
    (Method::DampedLeastSquares, Solver::ClosedForm),
];

/// Difference of the joint velocities, rad/s, up to which two runs move alike, so that one recording serves both.
const ALIKE: f64 = 1e-9;

pub fn run(options: &Options) -> Result<(), CliError> {
    make_directory(&options.out)?;
    let scenarios = scenarios(options.quick)?;
    let (runs, mut failures) = finished(&scenarios, run_all(&scenarios, TITLE_OF_RUNS));
    failures.extend(solver_differences(&scenarios, &runs));
    failures.extend(clarabel_failures(&runs));
    write!(stdout(), "{}", summary::text(&runs))?;
    writeln!(stdout(), "{ROUND_TRIPS}")?;
    for line in [Solver::Qp, Solver::ClosedForm].into_iter().filter_map(|solver| agreement(&runs, solver)) {
        writeln!(stdout(), "{line}")?;
    }
    if let Some(levels) = clarabel_checks::of_all(&runs) {
        writeln!(stdout(), "{}", clarabel_checks::lines(&levels).join("\n  "))?;
    }
    let page = write_page(options, runs, &failures)?;
    writeln!(stdout(), "\nOpen in a browser (figures, results of all runs, recordings):\n{}", page.display())?;
    if failures.is_empty() { Ok(()) } else { Err(CliError::Demo(failures)) }
}

/// Duration of each scenario with `--quick`, s. The tool reaches the stiff wall after 0.35 s.
const QUICK_S: f64 = 1.0;

/// Returns each scenario of the paper with each method and solver; `quick`: only its first second.
fn scenarios(quick: bool) -> Result<Vec<Scenario>, CliError> {
    let mut scenarios = Vec::new();
    for name in PAPER_SCENARIOS {
        let mut scenario = Scenario::find(name)?;
        if quick {
            scenario.duration_s = scenario.duration_s.min(QUICK_S);
        }
        for (method, solver) in VARIANTS {
            (scenario.controller.method, scenario.controller.solver) = (method, solver);
            scenarios.push(scenario.clone());
        }
    }
    Ok(scenarios)
}

/// Separates the runs that finished from the errors of the others.
fn finished(scenarios: &[Scenario], runs: Vec<Result<Run, CliError>>) -> (Vec<Run>, Vec<String>) {
    let (mut finished, mut failures) = (Vec::new(), Vec::new());
    for (scenario, run) in scenarios.iter().zip(runs) {
        match run {
            Ok(run) => finished.push(run),
            Err(error) => failures.push(format!("{}: {error}", label(scenario))),
        }
    }
    (finished, failures)
}

/// Writes the page with the results of all runs, and the figures and recordings of those that differ.
fn write_page(options: &Options, runs: Vec<Run>, failures: &[String]) -> Result<PathBuf, CliError> {
    let mut experiment = Experiment {
        title: "Force control with reverse task priority: the paper's experiments".to_owned(),
        question: QUESTION.map(str::to_owned).to_vec(),
        command: format!("cargo run --release -- demo{}", if options.quick { " --quick" } else { "" }),
        program: program(),
        runs,
        failures: failures.to_vec(),
    };
    let report = experiment.report();
    keep_different_runs(&mut experiment.runs);
    let traces = options.traces.or(Format::Parquet);
    write_report(&options.out, report, &[Output::Page, Output::Svg], &experiment, &traces)
}

/// Removes the runs that move as an earlier run of their scenario does.
fn keep_different_runs(runs: &mut Vec<Run>) {
    let mut kept: Vec<Run> = Vec::new();
    for run in std::mem::take(runs) {
        let is_alike = |other: &Run| {
            other.scenario.name == run.scenario.name && largest_difference(&other.recording, &run.recording) <= ALIKE
        };
        if !kept.iter().any(is_alike) {
            kept.push(run);
        }
    }
    *runs = kept;
}

const TITLE_OF_RUNS: &str = "the paper's four experiments, two methods, three solvers";

const ROUND_TRIPS: &str =
    "requests over HTTP, with median and 99th percentile of their round trips, for all solvers of a row";

const QUESTION: [&str; 3] = [
    "Su et al. (Materials 2022, 15, 6611) claim that reverse priority controls a contact force better than the classical \
     control. This page shows in which situations this is the case.",
    "A simulated Sawyer pushes against springs and against a stiff wall. In every control period of 1 ms the simulator \
     sends the measured state to the service over HTTP and moves with the joint velocities in the answer. Each run calls a \
     server of its own.",
    "Reverse priority is computed in closed form and, within joint limits, by quadratic programs. The classical control is \
     damped least squares over all tasks at once. Both use the damping threshold 0.05 and the largest factor 0.1.",
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_scenario_of_the_paper_is_run_with_all_three_solvers_of_reverse_priority() {
        let controllers = scenarios(false).unwrap().into_iter().map(|scenario| (scenario.name, scenario.controller));
        let reverse = controllers.filter(|(_, controller)| controller.method == Method::ReversePriority);
        let solvers: BTreeSet<_> = reverse.map(|(name, controller)| (name, controller.solver.to_string())).collect();
        assert_eq!(solvers.len(), PAPER_SCENARIOS.len() * Solver::ALL.len());
    }

    #[test]
    fn a_quick_demo_has_the_first_second_of_each_scenario() {
        let (whole, quick) = (scenarios(false).unwrap(), scenarios(true).unwrap());
        assert_eq!(whole.len(), quick.len());
        for (whole, quick) in whole.into_iter().zip(quick) {
            assert!(whole.duration_s > quick.duration_s && quick.cycles() == 1000);
            assert_eq!(whole, Scenario { duration_s: whole.duration_s, ..quick });
        }
    }

    #[test]
    fn a_run_that_did_not_finish_is_a_failure_with_its_reason() {
        let scenarios = scenarios(false).unwrap();
        let lost = || Err(CliError::Requests { sent: 3, answered: 2 });
        let (runs, failures) = finished(&scenarios, scenarios.iter().map(|_| lost()).collect());
        assert!(runs.is_empty());
        assert_eq!(failures.len(), scenarios.len());
        let reason = "the client sent 3 requests, but its own service answered 2";
        assert_eq!(failures[0], format!("force_tracking, reverse_priority, closed_form: {reason}"));
        assert_eq!(solver_differences(&scenarios, &runs).len(), scenarios.len());
    }
}
