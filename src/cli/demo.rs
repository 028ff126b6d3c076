//! `revprio demo`

use std::io::{Write as _, stdout};
use std::path::PathBuf;

use revprio_api::wire::{Method, Solver};
use revprio_lab::report::experiment::Experiment;
use revprio_lab::report::table;
use revprio_lab::simulator::{CallMode, PAPER_SCENARIOS};

use super::experiment::{ExperimentRunner, make_directory, program, write_results};
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

pub fn run(options: &Options) -> Result<(), CliError> {
    make_directory(&options.out)?;
    let runner = ExperimentRunner::open(None, None, CallMode::Session)?;
    let mut runs = Vec::new();
    for name in PAPER_SCENARIOS {
        let mut scenario = runner.scenario(name)?;
        for (method, solver) in VARIANTS {
            (scenario.controller.method, scenario.controller.solver) = (method, solver);
            runs.push(runner.run(&scenario)?);
        }
    }
    let experiment = Experiment {
        title: "Force control with reverse task priority: the paper's experiments".to_owned(),
        question: QUESTION.map(str::to_owned).to_vec(),
        command: "cargo run --release -- demo".to_owned(),
        program: program(),
        runs,
        failures: Vec::new(),
    };
    let report = experiment.report();
    write!(stdout(), "{}", table::text(&report.rows))?;
    for section in &report.sections {
        writeln!(stdout(), "\n{}: {}", section.name, section.notes.join(" "))?;
    }
    let page = write_results(&options.out, &experiment, &options.traces)?;
    writeln!(stdout(), "\nThe page with all figures and recordings: {}", page.display())?;
    Ok(())
}

const QUESTION: [&str; 3] = [
    "Su et al. (Materials 2022, 15, 6611) claim that reverse priority controls a contact force better than the classical \
     control. This page shows in which situations this is the case.",
    "A simulated Sawyer pushes against springs and against a stiff wall. In every control period of 1 ms the simulator \
     sends the measured state to the service over HTTP and moves with the joint velocities in the answer.",
    "Reverse priority is computed in closed form and, within joint limits, by quadratic programs. The classical control is \
     damped least squares over all tasks at once. Both use the damping threshold 0.05 and the largest factor 0.1.",
];
