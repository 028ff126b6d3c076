//! Common parts of the commands that run scenarios: running them, and writing the output directory.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use indicatif::ProgressBar;
use revprio_api::ClientError;
use revprio_api::wire::Problem;
use revprio_lab::report::experiment::{Experiment, store};
use revprio_lab::report::requests::Requests;
use revprio_lab::report::run::{Program, Run};
use revprio_lab::report::{self, Output, Report};
use revprio_lab::simulator::recording::Recording;
use revprio_lab::simulator::{CallMode, Scenario, built_in_robot, run_robot};
use revprio_robot::RobotModel;

use super::error::CliError;
use super::output::print_remark;
use super::progress_bar::progress_bar;
use super::robot::{Registration, RobotArgument};
use super::service_choice::{CalledService, ServiceChoice};
use super::target::Target;
use super::traces;
use crate::service::robot_answer;

/// The service that runs call, and the robot that replaces the robot of the scenario, if given.
pub struct ExperimentRunner {
    service: CalledService,
    robot: Option<Arc<RobotModel>>,
    _registration: Option<Registration>,
    mode: CallMode,
}

impl ExperimentRunner {
    /// Opens a service. If a robot is given, the service knows it at least as long as this value exists.
    pub fn open(choice: &ServiceChoice, robot: Option<&RobotArgument>, mode: CallMode) -> Result<Self, CliError> {
        let model = robot.map(RobotArgument::read).transpose()?;
        let (service, registration) = match &choice.server {
            Some(url) => {
                let target = Target::open(Some(url))?;
                let given = robot.zip(model.as_ref());
                let registration =
                    given.map(|(robot, model)| robot.register(model, &target.client, url)).transpose()?;
                (CalledService::Http(target), registration.flatten())
            }
            None if choice.in_process => (CalledService::in_process(model.as_ref())?, None),
            None => (CalledService::start(model.as_ref())?, None),
        };
        Ok(Self { service, robot: model, _registration: registration, mode })
    }

    /// Returns a scenario by name or path, with the robot of this runner.
    pub fn scenario(&self, name_or_path: &str) -> Result<Scenario, CliError> {
        let mut scenario = Scenario::find(name_or_path)?;
        if let Some(robot) = &self.robot {
            robot.name().clone_into(&mut scenario.controller.robot);
        }
        Ok(scenario)
    }

    /// Prints the warnings of the service about this scenario, which has this name or path. The session for this check is closed at once.
    pub fn warn(&self, scenario: &Scenario, name_or_path: &str) -> Result<(), CliError> {
        let calls = self.service.calls();
        let created = match calls.create_controller(&scenario.controller_in_environment()) {
            Err(ClientError::Refused { problem, .. }) if is_about_environment(&problem) => {
                print_remark(format_args!("warning: stability is not checked: {}", problem.detail));
                calls.create_controller(&scenario.controller)
            }
            created => created,
        };
        let created = created.map_err(|refusal| refused_scenario(refusal, name_or_path))?;
        calls.delete_controller(&created.id)?;
        for warning in created.warnings {
            print_remark(format_args!("warning: {warning}"));
        }
        Ok(())
    }

    /// Runs a scenario and shows the progress.
    pub fn run(&self, scenario: &Scenario) -> Result<Run, CliError> {
        let bar = visible_bar(scenario.cycles(), &label(scenario));
        let robot = match &self.robot {
            Some(robot) => Arc::clone(robot),
            None => built_in_robot(&scenario.controller.robot)?,
        };
        let run = run_with(&robot, scenario, &self.service, self.mode, |done| bar.set_position(done))?;
        bar.finish();
        Ok(run)
    }
}

/// Runs a scenario against a service and counts its requests.
pub fn run_with(
    robot: &Arc<RobotModel>,
    scenario: &Scenario,
    service: &CalledService,
    mode: CallMode,
    mut progress: impl FnMut(u64),
) -> Result<Run, CliError> {
    let progress = |done| {
        progress(done);
        ControlFlow::Continue(())
    };
    let before = service.requests();
    let recording = run_robot(robot, scenario, service.calls(), mode, progress)?;
    print_missing_answers(&recording, &label(scenario));
    let count = service.requests().zip(before).map(|(after, before)| after - before);
    let requests = count.map(|count| Requests::new(count, &recording.timings));
    Ok(Run { scenario: scenario.clone(), robot: robot_answer(robot), recording, requests })
}

/// Returns scenario, method and solver of a run.
pub fn label(scenario: &Scenario) -> String {
    format!("{}, {}, {}", scenario.name, scenario.controller.method, scenario.controller.solver)
}

/// Returns a progress bar. Without a terminal there is no bar, so the log gets a line.
pub fn visible_bar(periods: u64, label: &str) -> ProgressBar {
    let bar = progress_bar(periods, label);
    if bar.is_hidden() {
        print_remark(format_args!("running {label}"));
    }
    bar
}

/// Adds the line of a scenario file to a refusal that names a field.
fn refused_scenario(refusal: ClientError, name_or_path: &str) -> CliError {
    let pointer = match &refusal {
        ClientError::Refused { problem, .. } => problem.pointer.as_deref(),
        ClientError::Transport { .. } | ClientError::UnexpectedAnswer { .. } => None,
    };
    match pointer.and_then(|pointer| Scenario::place_of_controller_field(name_or_path, pointer)) {
        Some(place) => CliError::RefusedScenario { place, refusal },
        None => refusal.into(),
    }
}

fn is_about_environment(problem: &Problem) -> bool {
    problem.pointer.as_ref().is_some_and(|pointer| pointer.starts_with("/environment"))
}

fn print_missing_answers(recording: &Recording, label: &str) {
    let unanswered = recording.samples.iter().filter(|sample| !sample.answered).count();
    if unanswered > 0 {
        print_remark(format_args!(
            "{label}: {unanswered} periods without an answer; the arm held the last one, and braked where it was no longer valid"
        ));
    }
}

/// Writes the recordings and their description.
pub fn store(out: &Path, experiment: &Experiment, traces: &traces::Options) -> Result<(), CliError> {
    for run in &experiment.runs {
        traces.write(out, &run.recording)?;
    }
    Ok(store::write(out, experiment, |recording| traces.names(recording).collect())?)
}

/// Returns a report with the names of the recordings of an experiment.
pub fn with_traces(report: Report, experiment: &Experiment, traces: &traces::Options) -> Report {
    Report { traces: experiment.runs.iter().flat_map(|run| traces.names(&run.recording)).collect(), ..report }
}

/// Writes recordings, figures and page. Returns the path of the page.
pub fn write_results(out: &Path, experiment: &Experiment, traces: &traces::Options) -> Result<PathBuf, CliError> {
    let outputs = [Output::Page, Output::Svg, Output::Png];
    write_report(out, experiment.report(), &outputs, experiment, traces)
}

/// Writes figures and page of a report, and the recordings of an experiment. Returns the path of the page.
pub fn write_report(
    out: &Path,
    report: Report,
    outputs: &[Output],
    experiment: &Experiment,
    traces: &traces::Options,
) -> Result<PathBuf, CliError> {
    store(out, experiment, traces)?;
    report::write(out, &with_traces(report, experiment, traces), outputs)?;
    Ok(out.join("index.html"))
}

/// Returns the version of this program, and the commit if it runs inside a clone of its repository and git is installed.
pub fn program() -> Program {
    Program { version: env!("CARGO_PKG_VERSION").to_owned(), commit: clone_root().and_then(|root| commit(&root)) }
}

/// Returns the root of the clone that contains the working directory.
fn clone_root() -> Option<PathBuf> {
    let here = std::env::current_dir().ok()?;
    let root = here.ancestors().find(|directory| directory.join(".git").exists())?;
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).ok()?;
    manifest.lines().any(|line| line == "name = \"revprio\"").then(|| root.to_owned())
}

/// Returns the commit, for example `1a2b3c4d5e6f`, with `-dirty` if files were changed.
fn commit(root: &Path) -> Option<String> {
    let mut git = Command::new("git");
    git.arg("-C").arg(root).args(["describe", "--always", "--dirty", "--exclude=*", "--abbrev=12"]);
    let output = git.output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned()).filter(|text| !text.is_empty())
}
