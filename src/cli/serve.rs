//! `revprio serve`

use std::future::Future;
use std::io::{self, IsTerminal, Write as _, stdout};

use tracing_subscriber::EnvFilter;

use super::CliError;
use super::settings::{InForce, LogFormat, Options, SettingsError};
use crate::service::{AppState, Robots, bind, router, serve};

pub fn run(options: &Options) -> Result<(), CliError> {
    let settings = InForce::of(options, |name| std::env::var(name).ok())?;
    start_log(&settings)?;
    let config = settings.service()?;
    config.check(settings.listen())?;
    let scheme = if config.tls.is_some() { "https" } else { "http" };
    let mut robots = Robots::built_in();
    for argument in settings.robots() {
        robots = robots.with(argument.read()?)?;
    }
    let service = router(AppState::with_config(robots, config));
    let listener = bind(settings.listen())?;
    let url = format!("{scheme}://{}", listener.local_addr()?);
    Ok(serve(listener, service, announced_until_stopped(url))?)
}

/// Log lines go to standard error, panics among them.
fn start_log(settings: &InForce) -> Result<(), SettingsError> {
    let filter = settings.log_level().parse::<EnvFilter>();
    let filter = filter.map_err(|_| settings.refused("log_level", "is no level, such as `info` or `revprio=debug`"))?;
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr);
    match settings.log_format() {
        LogFormat::Text => log.with_ansi(std::io::stderr().is_terminal()).init(),
        LogFormat::Json => log.json().init(),
    }
    std::panic::set_hook(Box::new(|panic| tracing::error!("{panic}")));
    Ok(())
}

/// Says where the service listens, then waits for the signal that ends it.
///
/// In this order: whoever reads the address and ends the service at once must not kill it instead.
async fn announced_until_stopped(url: String) {
    let stop = stop_signal();
    if let Err(error) = writeln!(stdout(), "listening on {url}") {
        tracing::warn!(%error, "cannot write the address to standard output");
    }
    match stop {
        Ok(stop) => stop.await,
        Err(error) => {
            tracing::warn!(%error, "cannot listen for signals; the service ends when it is killed");
            std::future::pending::<()>().await;
        }
    }
}

/// Ready on Ctrl-C or SIGTERM, which are listened for from the call on.
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

/// Ready on Ctrl-C.
#[cfg(windows)]
fn stop_signal() -> io::Result<impl Future<Output = ()>> {
    let mut interrupt = tokio::signal::windows::ctrl_c()?;
    Ok(async move { drop(interrupt.recv().await) })
}
