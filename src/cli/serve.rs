//! `revprio serve`

use std::future::Future;
use std::io::{self, IsTerminal, Write as _, stdout};
use std::sync::Arc;

use revprio_robot::RobotModel;
use tracing_subscriber::fmt::layer;
use tracing_subscriber::prelude::*;

use super::error::CliError;
use super::robot::RobotArgument;
use super::settings::{EffectiveSettings, LogFormat, Options};
use super::supervisor::{LOG_TIMEOUT, ProcessSupervisor, end_on_second_signal};
use crate::service::{AppState, LogWriter, Robots, bind, router, serve_supervised};

pub fn run(options: &Options) -> Result<(), CliError> {
    let settings = EffectiveSettings::of(options, |name| std::env::var(name).ok())?;
    let log = start_log(&settings)?;
    let served = run_with(&settings, &log);
    log.finish(LOG_TIMEOUT);
    served
}

fn run_with(settings: &EffectiveSettings, log: &LogWriter) -> Result<(), CliError> {
    let config = settings.service()?;
    config.check(settings.listen())?;
    let scheme = if config.tls.is_some() { "https" } else { "http" };
    let service = router(AppState::with_config(robots(settings)?, config));
    let listener = bind(settings.listen())?;
    let url = format!("{scheme}://{}", listener.local_addr()?);
    if let Err(error) = end_on_second_signal() {
        tracing::warn!(%error, "a second signal will not end the service at once");
    }
    Ok(serve_supervised(listener, service, announce_and_wait(url), ProcessSupervisor::new(log.clone()))?)
}

/// Reads the robots of the files, in addition to the built-in ones.
fn robots(settings: &EffectiveSettings) -> Result<Robots, CliError> {
    let mut robots = Robots::built_in();
    for argument in settings.robots() {
        robots = robots.with(announced(argument)?)?;
    }
    for argument in settings.robots_dir().map(RobotArgument::in_directory).transpose()?.unwrap_or_default() {
        let name = |source| CliError::RobotsDirectory { path: argument.path().to_owned(), source };
        robots = robots.with(announced(&argument)?).map_err(name)?;
    }
    Ok(robots)
}

/// Reads a robot, and writes to the log which chain of its file it is.
fn announced(argument: &RobotArgument) -> Result<Arc<RobotModel>, CliError> {
    let robot = argument.read()?;
    if let Some(chain) = robot.selection() {
        let joints: Vec<&str> = robot.joints().iter().map(|joint| joint.name.as_str()).collect();
        let left_out: Vec<&str> = chain.left_out.iter().map(|left_out| left_out.joint.as_str()).collect();
        let (base, tip, joints, left_out) = (&chain.base, &chain.tip, joints.join(" "), left_out.join(" "));
        tracing::info!(robot = robot.name(), base, tip, joints, left_out, "robot read");
    }
    Ok(robot)
}

/// Starts the log on standard error, which includes panics.
fn start_log(settings: &EffectiveSettings) -> Result<LogWriter, CliError> {
    let writer = LogWriter::start(std::io::stderr())?;
    let output = writer.clone();
    let log = layer().with_writer(move || output.clone()).log_internal_errors(false);
    let log = match settings.log_format() {
        LogFormat::Text => log.with_ansi(std::io::stderr().is_terminal()).boxed(),
        LogFormat::Json => log.json().boxed(),
    };
    tracing_subscriber::registry().with(log.with_filter(settings.log_filter())).init();
    std::panic::set_hook(Box::new(|panic| tracing::error!("{panic}")));
    Ok(writer)
}

/// Prints the address of the service, then waits for the signal that ends it.
///
/// The signal handler is installed first, so that a signal right after the address was printed ends the service in an orderly way.
async fn announce_and_wait(url: String) {
    let stop = stop_signal();
    if let Err(error) = writeln!(stdout(), "listening on {url}") {
        tracing::warn!(%error, "cannot write the address to standard output");
    }
    match stop {
        Ok(stop) => stop.await,
        Err(error) => {
            tracing::warn!(%error, "cannot listen for signals; kill the process to end the service");
            std::future::pending::<()>().await;
        }
    }
}

/// Installs the handlers for Ctrl-C and SIGTERM. The future is ready on either signal.
#[cfg(unix)]
fn stop_signal() -> io::Result<impl Future<Output = ()>> {
    use tokio::signal::unix::{SignalKind, signal};
    let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
    Ok(async move {
        tokio::select! {
            _ = interrupt.recv() => (),
            _ = terminate.recv() => (),
        }
    })
}

/// Installs the handler for Ctrl-C. The future is ready on the signal.
#[cfg(windows)]
fn stop_signal() -> io::Result<impl Future<Output = ()>> {
    let mut interrupt = tokio::signal::windows::ctrl_c()?;
    Ok(async move { drop(interrupt.recv().await) })
}
