//! `revprio serve`

use std::future::Future;
use std::io::{self, IsTerminal, Write as _, stdout};
use std::net::SocketAddr;

use super::CliError;
use super::robot::RobotArgument;
use crate::service::{App, Robots, bind, router, serve};

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Address and port to listen on; port 0 takes a free one
    #[arg(long, default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
    /// An arm of your own beside the built-in ones; may be given several times
    #[arg(long, value_name = RobotArgument::SYNTAX, long_help = RobotArgument::HELP)]
    robot: Vec<RobotArgument>,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let filter = tracing_subscriber::EnvFilter::builder().with_default_directive(tracing::Level::INFO.into());
    tracing_subscriber::fmt()
        .with_env_filter(filter.from_env_lossy())
        .with_ansi(std::io::stderr().is_terminal())
        .with_writer(std::io::stderr)
        .init();
    let mut robots = Robots::built_in();
    for argument in &options.robot {
        robots = robots.with(argument.read()?)?;
    }
    let listener = bind(options.listen)?;
    let address = listener.local_addr()?;
    Ok(serve(listener, router(App::new(robots)), announced_until_stopped(address))?)
}

/// Says where the service listens, then waits for the signal that ends it.
///
/// In this order: whoever reads the address and ends the service at once must not kill it instead.
async fn announced_until_stopped(address: SocketAddr) {
    let stop = stop_signal();
    if let Err(error) = writeln!(stdout(), "listening on http://{address}") {
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
