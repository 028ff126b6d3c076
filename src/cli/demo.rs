//! `revprio demo`

use std::io::{Write as _, stdout};
use std::path::PathBuf;

use super::simulate::{make_directory, record, write_traces};
use super::{CliError, Target};
use crate::report::paper_figures::{Posture, of_posture};
use crate::report::{self, Report, table};
use crate::simulator::recording::Recording;
use crate::simulator::{BUILT_IN_SCENARIOS, CallMode, Scenario};
use crate::wire::{Method, Solver};

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Directory for traces, figures and page
    #[arg(long, default_value = "revprio-out")]
    out: PathBuf,
}

/// What is compared in every scenario.
const VARIANTS: [(Method, Solver); 4] = [
    (Method::ReversePriority, Solver::ClosedForm),
    (Method::ReversePriority, Solver::Qp),
    (Method::ReversePriority, Solver::Auto),
    (Method::DampedLeastSquares, Solver::ClosedForm),
];

pub fn run(options: &Options) -> Result<(), CliError> {
    make_directory(&options.out)?;
    let target = Target::open(None)?;
    let mut recordings = Vec::new();
    for (name, _) in BUILT_IN_SCENARIOS {
        let mut scenario = Scenario::find(name)?;
        for (method, solver) in VARIANTS {
            (scenario.controller.method, scenario.controller.solver) = (method, solver);
            recordings.push(record(&scenario, None, &target, CallMode::Session)?);
        }
    }
    let page = report(&recordings);
    write!(stdout(), "{}", table::text(&page.rows))?;
    for note in &page.notes {
        writeln!(stdout(), "\n{}: {}", note.scenario, note.text)?;
    }
    write_traces(&options.out, &recordings)?;
    report::write(&options.out, &page)?;
    writeln!(stdout(), "\nfigures, traces and one page with all of it: {}", options.out.join("index.html").display())?;
    Ok(())
}

fn report(recordings: &[Recording]) -> Report {
    Report {
        title: "Force control with reverse task priority: the paper's experiments".to_owned(),
        introduction: INTRODUCTION.map(str::to_owned).to_vec(),
        rows: table::rows(recordings),
        notes: report::notes::of_recordings(recordings),
        figures: [Posture::Nominal, Posture::Singular].iter().flat_map(|&p| of_posture(p, recordings)).collect(),
        traces: recordings.iter().map(Recording::trace_name).collect(),
        command: "cargo run --release -- demo".to_owned(),
    }
}

const INTRODUCTION: [&str; 2] = [
    "A simulated Sawyer pushes against springs and against a stiff wall. In every control period of 1 ms the simulator \
     sends the measured state to the service over HTTP and moves with the joint velocities that it gets back.",
    "Reverse priority (Su et al., Materials 2022, 15, 6611), in closed form and as a cascade of quadratic programs with \
     joint limits, beside the classical control, damped least squares over all tasks at once. Both use the damping \
     threshold 0.05 and the largest factor 0.1.",
];
