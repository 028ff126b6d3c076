//! `revprio demo`

use std::path::{Path, PathBuf};

use revprio_api::wire::{Law, Method, PerAxis, Profile, Solver};
use revprio_lab::report::Output;
use revprio_lab::report::checks::{agreement, solver_differences};
use revprio_lab::report::clarabel_checks::{self, clarabel_failures};
use revprio_lab::report::experiment::Experiment;
use revprio_lab::report::metrics::largest_difference;
use revprio_lab::report::run::Run;
use revprio_lab::report::story::CONTACT_LAW;
use revprio_lab::report::table::summary;
use revprio_lab::simulator::{PAPER_SCENARIOS, Scenario};

use super::error::CliError;
use super::experiment::{label, program, write_report};
use super::out_directory::OutDirectory;
use super::output::print_text;
use super::parallel_runs::run_all;
use super::traces;

#[derive(Debug, clap::Args)]
#[command(after_help = SERVERS, mut_arg("traces", |traces| traces.default_value("parquet")))]
pub struct Options {
    #[command(flatten)]
    out: OutDirectory,
    /// Simulate only the first second of each experiment. The forces do not settle in it, so the claims of the paper are not
    /// judged. All checks of the solvers apply
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    traces: traces::Options,
}

const SERVERS: &str =
    "Each run starts a server of its own on a free port and calls it over HTTP. There is no --server and no \
     --in-process.

In the experiments of the paper no limit acts. The solvers with limits, `auto` and `qp`, are also compared in \
     `stiff_wall_limits`, where limits act.";

/// Methods and solvers that are compared in every scenario of the paper.
const VARIANTS: [(Method, Solver); 4] = [
    (Method::ReversePriority, Solver::ClosedForm),
    (Method::ReversePriority, Solver::Qp),
    (Method::ReversePriority, Solver::Auto),
    (Method::DampedLeastSquares, Solver::ClosedForm),
];

/// The scenario in which limits act.
const AT_LIMITS: &str = "stiff_wall_limits";

/// Force with which the tool presses on the stiff wall in the paper, N.
const TARGET_N: f64 = 30.0;

/// The solvers that know limits.
const SOLVERS_AT_LIMITS: [Solver; 2] = [Solver::Auto, Solver::Qp];

/// Duration of the scenario in which limits act, s. They act in more than half of its periods, and a longer run costs time.
const AT_LIMITS_S: f64 = 2.0;

/// Difference of the joint velocities, rad/s, up to which two runs move alike, so that one recording serves both.
const ALIKE: f64 = 1e-9;

/// Runs the demo; `command`: the command line that started it.
pub fn run(options: &Options, command: &str) -> Result<(), CliError> {
    let out = options.out.create(command)?;
    let scenarios = scenarios(options.quick)?;
    let (runs, mut failures) = finished(&scenarios, run_all(&scenarios, TITLE_OF_RUNS));
    failures.extend(solver_differences(&scenarios, &runs));
    failures.extend(clarabel_failures(&runs));
    let table = table(&runs);
    let (runs, contact_failures) = with_contact_law(runs, options.quick)?;
    failures.extend(contact_failures);
    // The files first: they are there even if the table cannot be printed.
    let page = write_page((options, out), command, runs, &failures);
    let printed = print_text(table);
    let page = page?;
    let named =
        print_text(format_args!("Open in a browser (figures, results of all runs, recordings):\n{}\n", page.display()));
    if !failures.is_empty() {
        return Err(CliError::Demo(failures));
    }
    Ok(printed.and(named)?)
}

/// Returns the results for the terminal.
fn table(runs: &[Run]) -> String {
    let mut lines = vec![ROUND_TRIPS.to_owned()];
    lines.extend([Solver::Qp, Solver::ClosedForm].into_iter().filter_map(|solver| agreement(runs, solver)));
    if let Some(levels) = clarabel_checks::of_all(runs) {
        lines.push(clarabel_checks::lines(&levels).join("\n  "));
    }
    summary::text(runs) + &lines.join("\n") + "\n"
}

/// Adds the run of the law `contact` in the plant of `stiff_wall`, which explains the peak of the paper's law on the page. It
/// is no experiment of the paper, so the table does not have it. Returns the runs and the failures.
fn with_contact_law(mut runs: Vec<Run>, quick: bool) -> Result<(Vec<Run>, Vec<String>), CliError> {
    if quick {
        return Ok((runs, Vec::new()));
    }
    let scenarios = [contact_scenario()?];
    let (mut finished, failures) = finished(&scenarios, run_all(&scenarios, "the law `contact` at the stiff wall"));
    runs.append(&mut finished);
    Ok((runs, failures))
}

/// Returns `stiff_wall` with the law `contact` in place of the law of the paper.
fn contact_scenario() -> Result<Scenario, CliError> {
    let mut scenario = Scenario::find("stiff_wall")?;
    CONTACT_LAW.clone_into(&mut scenario.name);
    "The wall of `stiff_wall`, with the law `contact` for the task that presses".clone_into(&mut scenario.description);
    if let Some(task) = scenario.controller.tasks.first_mut() {
        task.law = Some(Law::Contact {
            target_force: Profile::Constant { value: PerAxis::All(TARGET_N) },
            approach_speed: None,
            stiffest: None,
            noise: None,
            bias: None,
            sensor_lag_s: None,
            max_force: None,
            retreat_speed: None,
            max_acceleration: None,
            surface: None,
        });
    }
    Ok(scenario)
}

/// Duration of each scenario with `--quick`, s. The tool reaches the stiff wall after 0.35 s, and limits act from 0.05 s on.
const QUICK_S: f64 = 1.0;

/// Returns each scenario with each method and solver; `quick`: only its first second.
fn scenarios(quick: bool) -> Result<Vec<Scenario>, CliError> {
    let mut scenarios = Vec::new();
    for name in PAPER_SCENARIOS {
        scenarios.extend(variants(&Scenario::find(name)?, VARIANTS));
    }
    let at_limits = Scenario { duration_s: AT_LIMITS_S, ..Scenario::find(AT_LIMITS)? };
    scenarios.extend(variants(&at_limits, SOLVERS_AT_LIMITS.map(|solver| (Method::ReversePriority, solver))));
    if quick {
        for scenario in &mut scenarios {
            scenario.duration_s = scenario.duration_s.min(QUICK_S);
        }
    }
    Ok(scenarios)
}

/// Returns a scenario with each of these methods and solvers.
fn variants(scenario: &Scenario, controllers: impl IntoIterator<Item = (Method, Solver)>) -> Vec<Scenario> {
    let variant = |(method, solver)| {
        let mut variant = scenario.clone();
        (variant.controller.method, variant.controller.solver) = (method, solver);
        variant
    };
    controllers.into_iter().map(variant).collect()
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
fn write_page(
    (options, out): (&Options, &Path),
    command: &str,
    runs: Vec<Run>,
    failures: &[String],
) -> Result<PathBuf, CliError> {
    let quick = options.quick.then_some(QUICK_QUESTION);
    let mut experiment = Experiment {
        title: "Force control with reverse task priority: the paper's experiments".to_owned(),
        question: QUESTION.into_iter().chain(quick).map(str::to_owned).collect(),
        command: command.to_owned(),
        program: program(),
        runs,
        failures: failures.to_vec(),
    };
    let report = experiment.report();
    keep_different_runs(&mut experiment.runs);
    write_report(out, report, &[Output::Page, Output::Svg], &experiment, &options.traces)
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

const TITLE_OF_RUNS: &str = "the paper's four experiments, and one at joint limits";

const ROUND_TRIPS: &str =
    "requests over HTTP, with median and 99th percentile of their round trips, for all solvers of a row";

const QUICK_QUESTION: &str =
    "Only the first second of each experiment was simulated (`--quick`), so the claims of the paper are not judged.";

const QUESTION: [&str; 4] = [
    "Su et al. (Materials 2022, 15, 6611) claim that reverse priority controls a contact force better than the classical \
     control. This page shows in which situations this is the case.",
    "A simulated Sawyer pushes against springs and against a stiff wall. In every control period of 1 ms the simulator \
     sends the measured state to the service over HTTP and moves with the joint velocities in the answer. Each run calls a \
     server of its own.",
    "Three solvers compute reverse priority. `auto` is the default one. `qp` solves a quadratic program at every level. \
     `closed_form` uses formulas without limits. `auto` and `qp` keep all limits. In the experiments of the paper no limit \
     acts; in `stiff_wall_limits`, limits act in more than half of the control periods.",
    "The classical control is damped least squares over all tasks at once. Both methods use the damping threshold 0.05 and \
     the largest factor 0.1.",
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_scenario_of_the_paper_is_run_with_all_three_solvers_of_reverse_priority() {
        let controllers = scenarios(false).unwrap().into_iter().map(|scenario| (scenario.name, scenario.controller));
        let reverse = controllers.filter(|(name, controller)| {
            PAPER_SCENARIOS.contains(&name.as_str()) && controller.method == Method::ReversePriority
        });
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
