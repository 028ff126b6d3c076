//! Peers of the service: a bare route with the same bodies, and a bare TCP connection.

use std::io::{self, Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::thread::JoinHandle;

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::IntoResponse;
use axum::routing::post;
use axum::serve::ListenerExt as _;
use revprio_api::wire;
use serde::Serialize;
use serde::de::DeserializeOwned;
use tokio::sync::oneshot;

/// Route of a session step.
pub const SESSION: &str = "/v1/controllers/{id}/step";

/// A route that parses the body with serde and serialises the same answer each time.
pub struct Echo {
    pub address: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

impl Echo {
    /// Starts the route on the cores of this thread.
    pub fn start(stateless: wire::StepAnswer, session: wire::StepAnswer) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let address = listener.local_addr()?;
        listener.set_nonblocking(true)?;
        let (stop, stopped) = oneshot::channel::<()>();
        let routes = route::<wire::StepRequest>("/v1/step", stateless).merge(route::<wire::State>(SESSION, session));
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
            runtime.block_on(async {
                let listener = tokio::net::TcpListener::from_std(listener)?;
                let listener = listener.tap_io(|stream| drop(stream.set_nodelay(true)));
                axum::serve(listener, routes).with_graceful_shutdown(async { drop(stopped.await) }).await
            })
        });
        Ok(Self { address, stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for Echo {
    fn drop(&mut self) {
        drop(self.stop.take());
        drop(self.thread.take().map(JoinHandle::join));
    }
}

fn route<Q: DeserializeOwned + 'static>(path: &str, answer: wire::StepAnswer) -> Router {
    Router::new().route(path, post(echo::<Q, wire::StepAnswer>)).with_state(answer)
}

async fn echo<Q: DeserializeOwned, A: Serialize>(State(answer): State<A>, body: Bytes) -> impl IntoResponse {
    let parsed = serde_json::from_slice::<Q>(&body);
    std::hint::black_box(&parsed);
    match (parsed, serde_json::to_vec(&answer)) {
        (Ok(_), Ok(bytes)) => Ok(([(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))], bytes)),
        _ => Err(StatusCode::BAD_REQUEST),
    }
}

/// Starts a server that answers `request` bytes with `answer` bytes, one connection at a time.
pub fn ping_pong(request: usize, answer: usize) -> io::Result<SocketAddr> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let address = listener.local_addr()?;
    std::thread::spawn(move || {
        let (mut asked, answer) = (vec![0; request], vec![b'x'; answer]);
        while let Ok((mut stream, _)) = listener.accept() {
            let _ = stream.set_nodelay(true);
            while stream.read_exact(&mut asked).is_ok() && stream.write_all(&answer).is_ok() {}
        }
    });
    Ok(address)
}
