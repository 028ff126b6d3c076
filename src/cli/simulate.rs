//! `revprio simulate`

use std::io::{Write as _, stderr, stdout};
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::{CliError, Target, progress_bar};
use crate::report::{self, Report, table};
use crate::simulator::recording::Recording;
use crate::simulator::{CallMode, Scenario, run as run_scenario};
use crate::wire::{Method, Solver};

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Name of a built-in scenario, or a file (.toml or .json)
    scenario: String,
    /// Service to call, such as http://127.0.0.1:8080; one of its own if left out
    #[arg(long)]
    server: Option<String>,
    /// Method, instead of the scenario's
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// Solver, instead of the scenario's
    #[arg(long, value_enum)]
    solver: Option<Solver>,
    /// Let the controller's memory travel with every request instead of keeping a session
    #[arg(long)]
    stateless: bool,
    /// Directory for trace, figures and page
    #[arg(long, default_value = "revprio-out")]
    out: PathBuf,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let mut scenario = Scenario::find(&options.scenario)?;
    scenario.controller.method = options.method.unwrap_or(scenario.controller.method);
    scenario.controller.solver = options.solver.unwrap_or(scenario.controller.solver);
    make_directory(&options.out)?;
    let target = Target::open(options.server.as_deref())?;
    let mode = if options.stateless { CallMode::Stateless } else { CallMode::Session };
    let recordings = [record(&scenario, &target, mode)?];
    let rows = table::rows(&recordings);
    write!(stdout(), "{}", table::text(&rows))?;
    write_traces(&options.out, &recordings)?;
    let page = Report {
        title: format!("{}: {}", scenario.name, scenario.description),
        introduction: Vec::new(),
        rows,
        notes: Vec::new(),
        figures: recordings.iter().map(report::run_figure::of_run).collect(),
        traces: recordings.iter().map(Recording::trace_name).collect(),
        command: command(options, &scenario),
    };
    report::write(&options.out, &page)?;
    writeln!(stdout(), "\nfigure, trace and one page with both: {}", options.out.join("index.html").display())?;
    Ok(())
}

/// The command that repeats the run.
fn command(options: &Options, scenario: &Scenario) -> String {
    let (method, solver) = (scenario.controller.method, scenario.controller.solver);
    let stateless = if options.stateless { " --stateless" } else { "" };
    format!("revprio simulate {} --method {method} --solver {solver}{stateless}", options.scenario)
}

/// Runs a scenario and shows how far it is.
pub fn record(scenario: &Scenario, target: &Target, mode: CallMode) -> Result<Recording, CliError> {
    let label = format!("{}, {}, {}", scenario.name, scenario.controller.method, scenario.controller.solver);
    let bar = progress_bar(scenario.cycles(), &label);
    if bar.is_hidden() {
        // Nobody watches a bar, but a log may want to know.
        let _ = writeln!(stderr(), "running {label}");
    }
    let recording = run_scenario(scenario, &target.client, mode, |done| bar.set_position(done))?;
    bar.finish();
    let unanswered = recording.samples.iter().filter(|sample| !sample.answered).count();
    if unanswered > 0 {
        writeln!(
            stderr(),
            "{label}: no answer in {unanswered} periods; the arm came to rest when the last one was too old"
        )?;
    }
    Ok(recording)
}

/// Makes the output directory, before the work that would be in vain without it.
pub fn make_directory(out: &Path) -> Result<(), CliError> {
    std::fs::create_dir_all(out).map_err(|source| CliError::Directory { path: out.to_owned(), source })
}

/// Writes every recording as CSV into the directory.
pub fn write_traces(out: &Path, recordings: &[Recording]) -> Result<(), CliError> {
    for recording in recordings {
        let path = out.join(recording.trace_name());
        recording.write_csv(&path).map_err(|source| CliError::Trace { path, source })?;
    }
    Ok(())
}

/// The words of the interface as values of options.
macro_rules! value_enum {
    ($word:ty: $($variant:ident),+) => {
        impl ValueEnum for $word {
            fn value_variants<'a>() -> &'a [Self] {
                &[$(Self::$variant),+]
            }

            fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
                Some(clap::builder::PossibleValue::new(self.to_string()))
            }
        }
    };
}

value_enum!(Method: Pseudoinverse, DampedLeastSquares, TaskPriority, SingularityRobust, ReversePriority, StrictReversePriority);
value_enum!(Solver: ClosedForm, Qp, Auto);
