//! `revprio simulate`

use std::io::{Write as _, stderr, stdout};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::ValueEnum;

use super::robot::{Registration, RobotArgument};
use super::{CliError, Target, progress_bar};
use crate::client::ClientError;
use crate::report::{self, Report, table};
use crate::robot::RobotModel;
use crate::service::Robots;
use crate::simulator::recording::Recording;
use crate::simulator::{CallMode, Scenario, run as run_scenario, run_robot};
use crate::wire::{Method, Problem, Solver};

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
    let robot = options.robot.as_ref().map(RobotArgument::read).transpose()?;
    if let Some(robot) = &robot {
        robot.name().clone_into(&mut scenario.controller.robot);
    }
    make_directory(&options.out)?;
    let (target, _registration) = target(options, robot.as_ref())?;
    let mode = if options.stateless { CallMode::Stateless } else { CallMode::Session };
    warn(&scenario, &target)?;
    let recordings = [record(&scenario, robot.as_ref(), &target, mode)?];
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

/// The service to call; with a robot of one's own, one that knows it, at least for as long as the registration lives.
fn target(options: &Options, robot: Option<&Arc<RobotModel>>) -> Result<(Target, Option<Registration>), CliError> {
    match (&options.server, &options.robot, robot) {
        (None, _, Some(robot)) => Ok((Target::own(Robots::none().with(Arc::clone(robot))?)?, None)),
        (Some(url), Some(argument), Some(robot)) => {
            let target = Target::open(Some(url))?;
            let registration = argument.register(robot, &target.client, url)?;
            Ok((target, registration))
        }
        (url, _, _) => Ok((Target::open(url.as_deref())?, None)),
    }
}

/// Prints what the service warns of in this scenario; the controller that is made for it ends at once.
fn warn(scenario: &Scenario, target: &Target) -> Result<(), CliError> {
    let created = match target.client.create_controller(&scenario.controller_in_environment()) {
        Err(ClientError::Refused { problem, .. }) if is_about_environment(&problem) => {
            writeln!(stderr(), "warning: stability is not checked: {}", problem.detail)?;
            return Ok(());
        }
        created => created?,
    };
    target.client.delete_controller(&created.id)?;
    for warning in created.warnings {
        writeln!(stderr(), "warning: {warning}")?;
    }
    Ok(())
}

fn is_about_environment(problem: &Problem) -> bool {
    problem.pointer.as_ref().is_some_and(|pointer| pointer.starts_with("/environment"))
}

/// The command that repeats the run.
fn command(options: &Options, scenario: &Scenario) -> String {
    let (method, solver) = (scenario.controller.method, scenario.controller.solver);
    let stateless = if options.stateless { " --stateless" } else { "" };
    let robot = options.robot.as_ref().map(|robot| format!(" --robot {robot}")).unwrap_or_default();
    format!("revprio simulate {}{robot} --method {method} --solver {solver}{stateless}", options.scenario)
}

/// Runs a scenario, with the robot that it names or another, and shows how far it is.
pub fn record(
    scenario: &Scenario,
    robot: Option<&Arc<RobotModel>>,
    target: &Target,
    mode: CallMode,
) -> Result<Recording, CliError> {
    let label = format!("{}, {}, {}", scenario.name, scenario.controller.method, scenario.controller.solver);
    let bar = progress_bar(scenario.cycles(), &label);
    if bar.is_hidden() {
        // Nobody watches a bar, but a log may want to know.
        let _ = writeln!(stderr(), "running {label}");
    }
    let progress = |done| {
        bar.set_position(done);
        ControlFlow::Continue(())
    };
    let recording = match robot {
        Some(robot) => run_robot(robot, scenario, &target.client, mode, progress)?,
        None => run_scenario(scenario, &target.client, mode, progress)?,
    };
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
