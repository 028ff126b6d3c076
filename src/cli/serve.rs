//! `revprio serve`

use std::io::IsTerminal;
use std::io::{Write as _, stdout};
use std::net::SocketAddr;

use super::CliError;
use crate::service::{App, Robots, bind, router, serve};

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Address and port to listen on; port 0 takes a free one
    #[arg(long, default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let filter = tracing_subscriber::EnvFilter::builder().with_default_directive(tracing::Level::INFO.into());
    tracing_subscriber::fmt()
        .with_env_filter(filter.from_env_lossy())
        .with_ansi(std::io::stderr().is_terminal())
        .with_writer(std::io::stderr)
        .init();
    let listener = bind(options.listen)?;
    writeln!(stdout(), "listening on http://{}", listener.local_addr()?)?;
    Ok(serve(listener, router(App::new(Robots::built_in())), stop_signal())?)
}

/// Ready on Ctrl-C or SIGTERM.
async fn stop_signal() {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut terminate) = signal(SignalKind::terminate()) {
            tokio::select! {
                _ = tokio::signal::ctrl_c() => (),
                _ = terminate.recv() => (),
            }
            return;
        }
    }
    let _ = tokio::signal::ctrl_c().await;
}
