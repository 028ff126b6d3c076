//! Listening, timeouts and an orderly end.

use std::future::Future;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::thread::JoinHandle;
use std::time::Duration;

use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpStream;
use tokio::sync::oneshot;

use super::drain::{Drain, Draining};

/// Time for a request's headers, and for an idle connection. Clients keep idle connections for some 15 s.
const HEADER_TIMEOUT: Duration = Duration::from_secs(30);

/// Time for requests in flight when the service ends. One that came in whole is answered within milliseconds; what is
/// open after this waits for a client that stopped in the middle.
const DRAIN_TIMEOUT: Duration = Duration::from_secs(1);

/// Why the service cannot run.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {source}; choose another address with --listen")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        source: io::Error,
    },
    /// The runtime or its thread cannot start.
    #[error("cannot start the service: {0}")]
    Start(#[from] io::Error),
}

/// Listens on an address; port 0 takes a free one.
pub fn bind(address: SocketAddr) -> Result<TcpListener, ServeError> {
    TcpListener::bind(address).map_err(|source| ServeError::Listen { address, source })
}

/// Serves until `stop` is ready, then answers what is in flight and returns.
///
/// One thread serves all: a step takes microseconds, less than handing it to another thread.
pub fn serve(listener: TcpListener, router: Router, stop: impl Future<Output = ()>) -> Result<(), ServeError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let served = runtime.block_on(async {
        listener.set_nonblocking(true)?;
        let listener = tokio::net::TcpListener::from_std(listener)?;
        accept(listener, router, stop).await;
        Ok(())
    });
    // What runs in the background notices that it is abandoned.
    runtime.shutdown_timeout(DRAIN_TIMEOUT);
    served
}

async fn accept(listener: tokio::net::TcpListener, router: Router, stop: impl Future<Output = ()>) {
    let (drain, draining) = Drain::new();
    let service = TowerToHyperService::new(router.layer(Extension(draining.clone())));
    let mut stop = std::pin::pin!(stop);
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = &mut stop => break,
        };
        match accepted {
            Ok((stream, _)) => {
                // Answers are small and awaited: never hold one back to fill a packet.
                let _ = stream.set_nodelay(true);
                let connection = http1::Builder::new()
                    .timer(TokioTimer::new())
                    .header_read_timeout(HEADER_TIMEOUT)
                    .serve_connection(TokioIo::new(stream), service.clone());
                tokio::spawn(serve_connection(connection.with_upgrades(), draining.clone()));
            }
            Err(error) => {
                tracing::warn!(%error, "cannot accept a connection");
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
        }
    }
    drop((listener, service, draining));
    if tokio::time::timeout(DRAIN_TIMEOUT, drain.finished()).await.is_err() {
        tracing::warn!("connections still open after {DRAIN_TIMEOUT:?} were dropped");
    }
}

type Connection = http1::UpgradeableConnection<TokioIo<TcpStream>, TowerToHyperService<Router>>;

/// Serves a connection until its client closes it or the service ends. One that fails concerns its client alone.
async fn serve_connection(connection: Connection, mut draining: Draining) {
    let mut connection = std::pin::pin!(connection);
    tokio::select! {
        _ = &mut connection => return,
        () = draining.begun() => connection.as_mut().graceful_shutdown(),
    }
    let _ = connection.await;
}

/// A service in a thread of its own, ended when dropped.
pub struct RunningServer {
    address: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl RunningServer {
    /// Starts on a free loopback port.
    pub fn start(router: Router) -> Result<Self, ServeError> {
        let listener = bind(SocketAddr::from(([127, 0, 0, 1], 0)))?;
        let address = listener.local_addr()?;
        let (stop, stopped) = oneshot::channel::<()>();
        let run = move || {
            let stopped = async {
                let _ = stopped.await;
            };
            if let Err(error) = serve(listener, router, stopped) {
                tracing::error!(%error, "the service ended");
            }
        };
        let thread = std::thread::Builder::new().name("service".to_owned()).spawn(run)?;
        Ok(Self { address, stop: Some(stop), thread: Some(thread) })
    }

    /// Base of all addresses, such as `http://127.0.0.1:40123`.
    pub fn url(&self) -> String {
        format!("http://{}", self.address)
    }
}

impl Drop for RunningServer {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
