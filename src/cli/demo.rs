//! `revprio demo`

use std::io::{Write as _, stdout};
use std::path::PathBuf;

use revprio_api::wire::{Method, Solver};
use revprio_lab::report::Output;
use revprio_lab::report::experiment::Experiment;
use revprio_lab::report::metrics::largest_difference;
use revprio_lab::report::run::Run;
use revprio_lab::report::table::summary;
use revprio_lab::simulator::recording::Format;
use revprio_lab::simulator::{CallMode, PAPER_SCENARIOS};

use super::experiment::{ExperimentRunner, make_directory, program, write_report};
use super::{CliError, traces};

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Directory for recordings, figures and page
    #[arg(long, default_value = "revprio-out")]
    out: PathBuf,
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
    let runner = ExperimentRunner::open(None, None, CallMode::Session)?;
    let mut scenarios = Vec::new();
    for name in PAPER_SCENARIOS {
        let mut scenario = runner.scenario(name)?;
        for (method, solver) in VARIANTS {
            (scenario.controller.method, scenario.controller.solver) = (method, solver);
            scenarios.push(scenario.clone());
        }
    }
    let mut experiment = Experiment {
        title: "Force control with reverse task priority: the paper's experiments".to_owned(),
        question: QUESTION.map(str::to_owned).to_vec(),
        command: "cargo run --release -- demo".to_owned(),
        program: program(),
        runs: runner.run_all(&scenarios, "the paper's four experiments, two methods, three solvers")?,
        failures: Vec::new(),
    };
    let report = experiment.report();
    write!(stdout(), "{}", summary::text(&report.rows))?;
    keep_different_runs(&mut experiment.runs);
    let traces = options.traces.or(Format::Parquet);
    let page = write_report(&options.out, report, &[Output::Page, Output::Svg], &experiment, &traces)?;
    writeln!(stdout(), "\nOpen in a browser (figures, results of all runs, recordings):\n{}", page.display())?;
    Ok(())
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

const QUESTION: [&str; 3] = [
    "Su et al. (Materials 2022, 15, 6611) claim that reverse priority controls a contact force better than the classical \
     control. This page shows in which situations this is the case.",
    "A simulated Sawyer pushes against springs and against a stiff wall. In every control period of 1 ms the simulator \
     calls the service with the measured state and moves with the joint velocities in the answer. The calls stay in the \
     process; over HTTP, as in revprio simulate, the joint velocities are the same to the last bit.",
    "Reverse priority is computed in closed form and, within joint limits, by quadratic programs. The classical control is \
     damped least squares over all tasks at once. Both use the damping threshold 0.05 and the largest factor 0.1.",
];
