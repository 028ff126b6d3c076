//! Listening, timeouts and the orderly shutdown.

use std::convert::Infallible;
use std::error::Error;
use std::future::Future;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use axum::Router;
use axum::response::Response;
use hyper::Request;
use hyper::body::Incoming;
use hyper::header::UPGRADE;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt};
use tokio::sync::oneshot;
use tokio::task::JoinSet;

use super::app::Service;
use super::config::ServiceConfig;
use super::connection::{Connection, Reads, ServingTask};
use super::drain::Draining;
use super::error::connection_refusal;
use super::gate::{LocalAddress, PeerAddress};
use super::heartbeat::{Heartbeat, Supervisor};
use super::listener::{Accepted, Listener};
use super::metrics::Metrics;

type RouterResult = Result<Response, Infallible>;

/// Maximum number of bytes that wait to be read or written on a connection. Enough for all headers in use.
const MAX_BUFFER: usize = 64 << 10;

/// The reason why the service cannot run.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// Others could reach the service without a token, and move the arm.
    #[error(
        "others can reach {address} and could move the arm; give a secret with --token-file, or listen on 127.0.0.1"
    )]
    TokenNeeded {
        /// The address.
        address: SocketAddr,
    },
    /// The service cannot listen on the address.
    #[error("cannot listen on {address}: {source}; choose another address with --listen")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The async runtime or its thread cannot start.
    #[error("cannot start the service: {0}")]
    Start(#[from] io::Error),
}

impl ServiceConfig {
    /// Refuses an address that others can reach, unless requests must send a token.
    pub fn check(&self, address: SocketAddr) -> Result<(), ServeError> {
        if address.ip().to_canonical().is_loopback() || self.token.is_some() {
            return Ok(());
        }
        Err(ServeError::TokenNeeded { address })
    }
}

/// Listens on an address. Port 0 selects a free port.
pub fn bind(address: SocketAddr) -> Result<TcpListener, ServeError> {
    TcpListener::bind(address).map_err(|source| ServeError::Listen { address, source })
}

/// Serves until `stop` is ready, then answers the requests in flight and returns.
///
/// One thread serves all requests: a step takes microseconds, less than passing it to another thread.
pub fn serve(listener: TcpListener, service: Service, stop: impl Future<Output = ()>) -> Result<(), ServeError> {
    listener.set_nonblocking(true)?;
    run(listener, service, stop, &Heartbeat::new(None))
}

/// Serves like [`serve`], while another thread watches the thread of the requests and reports to the supervisor.
///
/// While the thread of the requests is stuck, every new connection is answered with 503 (closed, with TLS).
pub fn serve_supervised(
    listener: TcpListener,
    service: Service,
    stop: impl Future<Output = ()>,
    supervisor: impl Supervisor + Sync,
) -> Result<(), ServeError> {
    listener.set_nonblocking(true)?;
    let config = &service.app.config;
    config.check(listener.local_addr()?)?;
    let own = if config.tls.is_none() { Some(listener.try_clone()?) } else { None };
    let heartbeat = Heartbeat::new(own);
    let supervisor = Arc::new(supervisor);
    let _watch = heartbeat.watch(config.stuck_after, Arc::clone(&supervisor))?;
    supervisor.ready();
    let stop = async {
        stop.await;
        supervisor.stopping();
    };
    run(listener, service, stop, &heartbeat)
}

fn run(
    listener: TcpListener,
    service: Service,
    stop: impl Future<Output = ()>,
    heartbeat: &Arc<Heartbeat>,
) -> Result<(), ServeError> {
    service.app.config.check(listener.local_addr()?)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let drain_timeout = service.app.config.drain_timeout;
    let served = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let beating = Arc::clone(heartbeat);
        tokio::spawn(async move { beating.run().await });
        accept(listener, service, stop, heartbeat).await;
        Ok(())
    });
    heartbeat.end();
    // Background work notices that it is abandoned.
    runtime.shutdown_timeout(drain_timeout);
    served
}

/// Serves the connections of any listener in the current runtime until `stop` is ready, then answers the requests in flight
/// and returns. Unlike [`serve`], it does not check the address, and connections that are still open stay open.
pub async fn serve_on(listener: impl Listener, service: Service, stop: impl Future<Output = ()>) {
    accept(listener, service, stop, &Heartbeat::new(None)).await;
}

async fn accept(mut listener: impl Listener, service: Service, stop: impl Future<Output = ()>, heartbeat: &Heartbeat) {
    let app = Arc::clone(&service.app);
    let marked = Arc::clone(&app);
    // The task ends with this function.
    let mut marker = JoinSet::new();
    marker.spawn(async move { marked.admission_queue.run_marker().await });
    let mut drained = std::pin::pin!(async {
        stop.await;
        app.drain.announce();
        tokio::time::sleep(app.config.drain_delay).await;
    });
    loop {
        let accepted = tokio::select! {
            biased;
            () = &mut drained => break,
            accepted = listener.accept() => accepted,
        };
        match accepted {
            Ok(accepted) => admit(accepted, &service),
            Err(error) => {
                tracing::warn!(%error, "cannot accept a connection");
                // The usual cause is too many open files.
                app.connections.close_oldest();
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
        }
    }
    drop(listener);
    heartbeat.stop_listening();
    let timeout = app.config.drain_timeout;
    if tokio::time::timeout(timeout, app.drain.finish()).await.is_err() {
        tracing::warn!("connections still open after {timeout:?} were dropped");
    }
}

/// Starts a task that serves a connection, or refuses the connection if there are too many.
fn admit<S>(accepted: Accepted<S>, service: &Service)
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let Accepted { stream, local, peer } = accepted;
    let (config, metrics) = (&service.app.config, &service.app.metrics);
    let Some((slot, full)) = service.app.connections.add() else {
        metrics.count_connection_fault("refused");
        // An encrypted connection is only closed.
        if config.tls.is_none() {
            tokio::spawn(tokio::time::timeout(config.write_timeout, refuse(stream)));
        }
        return;
    };
    if full {
        metrics.count_connection_fault("closed_for_another");
    }
    let serving = slot.task();
    let caller = Caller { local, peer, reads: slot.reads(), task: slot.task() };
    let connection = Connection::new(stream, slot, config.write_timeout);
    let draining = service.app.drain.subscribe();
    let task = match &config.tls {
        None => tokio::spawn(answer(connection, caller, service.clone(), draining)),
        Some(tls) => {
            let handshake = tokio::time::timeout(config.handshake_timeout, tls.0.accept(connection));
            let service = service.clone();
            tokio::spawn(async move {
                match handshake.await {
                    Ok(Ok(connection)) => answer(connection, caller, service, draining).await,
                    Ok(Err(_)) | Err(_) => service.app.metrics.count_connection_fault("handshake"),
                }
            })
        }
    };
    serving.set(task.abort_handle());
}

/// Answers a connection above the limit. A new connection can be written to only after the runtime has polled it.
async fn refuse(mut stream: impl AsyncWrite + Unpin) -> io::Result<()> {
    stream.write_all(connection_refusal().as_bytes()).await?;
    stream.shutdown().await
}

/// Answers the requests of one connection. After the shutdown began, it answers only requests that have arrived.
async fn answer<C>(connection: C, caller: Caller, service: Service, mut draining: Draining)
where
    C: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let Service { router, app } = service;
    let requests = service_fn(move |request| caller.call(request, router.clone()));
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(app.config.header_timeout)
        .max_buf_size(MAX_BUFFER)
        .serve_connection(TokioIo::new(connection), requests)
        .with_upgrades();
    let mut connection = std::pin::pin!(connection);
    let result = tokio::select! {
        biased;
        result = connection.as_mut() => result,
        () = draining.begun() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = result {
        app.metrics.count_connection_fault(cause(&error));
    }
}

impl Service {
    /// Serves one connection over any transport, such as a pipe in memory, until either side ends it. `peer` is the address
    /// of the client in the log.
    ///
    /// Only [`serve`] detects overload and clients that do not read. Elsewhere, set [`ServiceConfig::max_lag`] to
    /// [`Duration::MAX`].
    pub async fn serve_connection<C>(&self, connection: C, peer: SocketAddr)
    where
        C: AsyncRead + AsyncWrite + Unpin + Send + 'static,
    {
        let Some((slot, _)) = self.app.connections.add() else { return };
        let caller = Caller { local: None, peer, reads: slot.reads(), task: slot.task() };
        answer(connection, caller, self.clone(), self.app.drain.subscribe()).await;
    }
}

/// The client of one connection.
struct Caller {
    /// The address that accepted the connection.
    local: Option<SocketAddr>,
    peer: SocketAddr,
    reads: Reads,
    task: ServingTask,
}

impl Caller {
    /// Answers a request of the connection.
    ///
    /// A request that had arrived together with the one before it waits until other connections have had their turn.
    fn call(&self, mut request: Request<Incoming>, router: Router) -> impl Future<Output = RouterResult> + use<> {
        let has_turn = self.reads.has_new();
        let is_upgrade = request.headers().contains_key(UPGRADE);
        let extensions = request.extensions_mut();
        is_upgrade.then(|| extensions.insert(self.task.clone()));
        self.local.map(|local| extensions.insert(LocalAddress(local.ip())));
        extensions.insert(PeerAddress(self.peer));
        async move {
            if !has_turn {
                // In a task of its own: a yield ends when it is polled again, and hyper polls up to 16 times in a row.
                let _ = tokio::spawn(tokio::task::yield_now()).await;
            }
            TowerToHyperService::new(router).call(request).await
        }
    }
}

/// Returns the cause of the early end of a connection, as a label of the metrics.
fn cause(error: &hyper::Error) -> &'static str {
    let io = error.source().and_then(|source| source.downcast_ref::<io::Error>());
    match io.map(io::Error::kind) {
        Some(io::ErrorKind::TimedOut) => "write_timeout",
        _ if error.is_timeout() => "header_timeout",
        _ if error.is_parse() => "not_http",
        _ => "broken",
    }
}

/// A service that runs in its own thread and ends when it is dropped.
pub struct RunningServer {
    address: SocketAddr,
    encrypted: bool,
    metrics: Arc<Metrics>,
    workers: Vec<Worker>,
}

/// A thread that serves until it is stopped.
struct Worker {
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl RunningServer {
    /// Starts the service on a free loopback port.
    #[expect(clippy::needless_pass_by_value, reason = "the server owns the service")]
    pub fn start(service: Service) -> Result<Self, ServeError> {
        Self::start_on(1, &service)
    }

    /// Starts the service with several threads, each with its own connections. Use this for measurements only: the limit of
    /// waiting requests assumes one thread.
    pub fn start_on(threads: usize, service: &Service) -> Result<Self, ServeError> {
        let listener = bind(SocketAddr::from(([127, 0, 0, 1], 0)))?;
        let (address, encrypted) = (listener.local_addr()?, service.app.config.tls.is_some());
        let worker = |_| Worker::start(listener.try_clone()?, service.clone());
        let metrics = Arc::clone(&service.app.metrics);
        Ok(Self { address, encrypted, metrics, workers: (0..threads).map(worker).collect::<io::Result<_>>()? })
    }

    /// Returns the number of requests that the service has answered, as `/metrics` reports it.
    pub fn answered(&self) -> u64 {
        self.metrics.answers()
    }

    /// Returns the base of all URLs, such as `http://127.0.0.1:40123`.
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
