//! Listening, timeouts and an orderly end.

use std::error::Error;
use std::future::Future;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::sync::oneshot;

use super::app::Service;
use super::connection::Connection;
use super::drain::Draining;
use super::error::no_room;

/// Most bytes of a connection that wait to be read or written; holds any headers in use.
const BUFFER_LIMIT: usize = 64 << 10;

/// Why the service cannot run.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// Others would reach it, and it would obey them.
    #[error(
        "{address} can be reached by others, who could move the arm: give a secret with --token-file, or listen on \
         127.0.0.1"
    )]
    TokenNeeded {
        /// The address.
        address: SocketAddr,
    },
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
pub fn serve(listener: TcpListener, service: Service, stop: impl Future<Output = ()>) -> Result<(), ServeError> {
    service.app.config.check(listener.local_addr()?)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let drain_timeout = service.app.config.drain_timeout;
    let served = runtime.block_on(async {
        listener.set_nonblocking(true)?;
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let app = Arc::clone(&service.app);
        tokio::spawn(async move { app.admission_queue.carry_marker().await });
        accept(listener, service, stop).await;
        Ok(())
    });
    // What runs in the background notices that it is abandoned.
    runtime.shutdown_timeout(drain_timeout);
    served
}

async fn accept(listener: tokio::net::TcpListener, service: Service, stop: impl Future<Output = ()>) {
    let app = Arc::clone(&service.app);
    let mut drained = std::pin::pin!(async {
        stop.await;
        app.drain.announce();
        tokio::time::sleep(app.config.drain_delay).await;
    });
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = &mut drained => break,
        };
        match accepted {
            Ok((stream, _)) => admit(stream, &service),
            Err(error) => {
                tracing::warn!(%error, "cannot accept a connection");
                // Most often there are too many open files.
                app.connections.close_oldest();
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
        }
    }
    drop(listener);
    let timeout = app.config.drain_timeout;
    if tokio::time::timeout(timeout, app.drain.finished()).await.is_err() {
        tracing::warn!("connections still open after {timeout:?} were dropped");
    }
}

/// Serves a connection in a task of its own, if there is room.
fn admit(stream: TcpStream, service: &Service) {
    let (config, metrics) = (&service.app.config, &service.app.metrics);
    let Some((slot, full)) = service.app.connections.enter() else {
        metrics.connection_fault("refused");
        // Fits into any send buffer. An encrypted connection is only closed.
        if config.tls.is_none() {
            let _ = stream.try_write(no_room().as_bytes());
        }
        return;
    };
    if full {
        metrics.connection_fault("closed_for_another");
    }
    // Answers are small and awaited: never hold one back to fill a packet.
    let _ = stream.set_nodelay(true);
    let own = slot.owner();
    let connection = Connection::new(stream, slot, config.write_timeout);
    let draining = service.app.drain.listener();
    let task = match &config.tls {
        None => tokio::spawn(answer(connection, service.clone(), draining)),
        Some(tls) => {
            let handshake = tokio::time::timeout(config.handshake_timeout, tls.0.accept(connection));
            let service = service.clone();
            tokio::spawn(async move {
                match handshake.await {
                    Ok(Ok(connection)) => answer(connection, service, draining).await,
                    Ok(Err(_)) | Err(_) => service.app.metrics.connection_fault("handshake"),
                }
            })
        }
    };
    own(task.abort_handle());
}

/// Answers the requests of one connection; at the end, only that which came already.
async fn answer<C>(connection: C, service: Service, mut draining: Draining)
where
    C: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let app = service.app;
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(app.config.header_timeout)
        .max_buf_size(BUFFER_LIMIT)
        .serve_connection(TokioIo::new(connection), TowerToHyperService::new(service.router))
        .with_upgrades();
    let mut connection = std::pin::pin!(connection);
    let result = tokio::select! {
        result = connection.as_mut() => result,
        () = draining.begun() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = result {
        app.metrics.connection_fault(cause(&error));
    }
}

/// Why a connection ended early; it concerns its client alone.
fn cause(error: &hyper::Error) -> &'static str {
    let io = error.source().and_then(|source| source.downcast_ref::<io::Error>());
    match io.map(io::Error::kind) {
        Some(io::ErrorKind::TimedOut) => "write_timeout",
        _ if error.is_timeout() => "header_timeout",
        _ if error.is_parse() => "not_http",
        _ => "broken",
    }
}

/// A service in a thread of its own, ended when dropped.
pub struct RunningServer {
    address: SocketAddr,
    encrypted: bool,
    workers: Vec<Worker>,
}

/// A thread that serves until it is told to stop.
struct Worker {
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl RunningServer {
    /// Starts on a free loopback port.
    #[expect(clippy::needless_pass_by_value, reason = "a server takes what it runs")]
    pub fn start(service: Service) -> Result<Self, ServeError> {
        Self::start_on(1, &service)
    }

    /// The same with so many threads, each with connections of its own: for measurements, as the line of waiting requests
    /// is measured for one.
    pub fn start_on(threads: usize, service: &Service) -> Result<Self, ServeError> {
        let listener = bind(SocketAddr::from(([127, 0, 0, 1], 0)))?;
        let (address, encrypted) = (listener.local_addr()?, service.app.config.tls.is_some());
        let worker = |_| Worker::start(listener.try_clone()?, service.clone());
        Ok(Self { address, encrypted, workers: (0..threads).map(worker).collect::<io::Result<_>>()? })
    }

    /// Base of all addresses, such as `http://127.0.0.1:40123`.
    pub fn url(&self) -> String {
        let scheme = if self.encrypted { "https" } else { "http" };
        format!("{scheme}://{}", self.address)
    }
}

impl Worker {
    fn start(listener: TcpListener, service: Service) -> io::Result<Self> {
        let (stop, stopped) = oneshot::channel::<()>();
        let run = move || {
            let stopped = async {
                let _ = stopped.await;
            };
            if let Err(error) = serve(listener, service, stopped) {
                tracing::error!(%error, "the service ended");
            }
        };
        let thread = std::thread::Builder::new().name("service".to_owned()).spawn(run)?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for RunningServer {
    fn drop(&mut self) {
        self.workers.iter_mut().for_each(|worker| drop(worker.stop.take()));
        for thread in self.workers.iter_mut().filter_map(|worker| worker.thread.take()) {
            let _ = thread.join();
        }
    }
}
