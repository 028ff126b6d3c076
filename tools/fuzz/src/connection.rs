//! A service in memory, and connections to it.

use std::net::SocketAddr;
use std::time::Duration;

use revprio::service::{AppState, Robots, Service, ServiceConfig, router};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex, split};
use tokio::runtime::{Builder, Runtime};
use tokio::time::timeout;

use crate::Defect;

/// Bytes that a pipe holds, as many as the buffers of a socket.
const PIPE: usize = 64 << 10;

/// A connection without an answer for this long hangs.
const HANG: Duration = Duration::from_secs(20);

/// An answer to a request.
#[derive(Debug, Clone)]
pub struct Answer {
    /// Status code.
    pub status: u16,
    /// Media type.
    pub media_type: String,
    /// Body.
    pub body: Vec<u8>,
}

/// A service whose connections are pipes in memory. It serves them on the thread that calls.
pub struct InMemory {
    runtime: Runtime,
    service: Service,
}

impl InMemory {
    /// Starts a service with the built-in robots and this deadline of work in worker threads.
    ///
    /// # Panics
    ///
    /// If the runtime cannot start.
    pub fn start(work_timeout: Duration) -> Self {
        let config = ServiceConfig { max_lag: Duration::MAX, work_timeout, ..ServiceConfig::default() };
        let runtime = Builder::new_current_thread().enable_all().build().expect("the runtime starts");
        Self { runtime, service: router(AppState::with_config(Robots::built_in(), config)) }
    }

    /// Sends a request with a body, and returns its answer.
    pub fn post(&self, path: &str, media_type: &str, body: &[u8]) -> Result<Answer, Defect> {
        let length = body.len();
        self.request(
            &format!("POST {path}"),
            &format!("content-type: {media_type}\r\ncontent-length: {length}\r\n"),
            body,
        )
    }

    /// Sends `DELETE`, and returns the answer.
    pub fn delete(&self, path: &str) -> Result<Answer, Defect> {
        self.request(&format!("DELETE {path}"), "", &[])
    }

    fn request(&self, line: &str, headers: &str, body: &[u8]) -> Result<Answer, Defect> {
        let head = format!("{line} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n{headers}\r\n");
        let bytes = self.connect(async |client| {
            let (mut reader, mut writer) = split(client);
            let request = [head.as_bytes(), body].concat();
            let mut answer = Vec::new();
            // The service may refuse a body before it has read all of it.
            let (_, read) = tokio::join!(writer.write_all(&request), reader.read_to_end(&mut answer));
            read.map(|_| answer)
        })?;
        parse(&bytes)
    }

    /// Opens a WebSocket, writes these bytes to it after the handshake, and ends the connection. Returns all bytes that the
    /// service sends after its handshake; `None` if it refuses the handshake.
    pub fn web_socket(&self, path: &str, protocol: &str, frames: &[u8]) -> Result<Option<Vec<u8>>, Defect> {
        let head = format!(
            "GET {path} HTTP/1.1\r\nhost: localhost\r\nconnection: upgrade\r\nupgrade: websocket\r\n\
             sec-websocket-version: 13\r\nsec-websocket-key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\
             sec-websocket-protocol: {protocol}\r\n\r\n"
        );
        self.connect(async |client| {
            let (mut reader, mut writer) = split(client);
            writer.write_all(head.as_bytes()).await?;
            let mut handshake = Vec::new();
            while !handshake.ends_with(b"\r\n\r\n") {
                handshake.push(reader.read_u8().await?);
            }
            if !handshake.starts_with(b"HTTP/1.1 101 ") {
                return Ok(None);
            }
            let mut answer = Vec::new();
            let write = async {
                let _ = writer.write_all(frames).await;
                let _ = writer.shutdown().await;
            };
            let ((), read) = tokio::join!(write, reader.read_to_end(&mut answer));
            read.map(|_| Some(answer))
        })
    }

    /// Serves one connection while `talk` is its client.
    fn connect<T>(&self, talk: impl AsyncFnOnce(DuplexStream) -> std::io::Result<T>) -> Result<T, Defect> {
        let (client, server) = duplex(PIPE);
        let service = self.service.clone();
        let peer = SocketAddr::from(([127, 0, 0, 1], 1));
        let exchange = async {
            let served = tokio::spawn(async move { service.serve_connection(server, peer).await });
            let answer = talk(client).await;
            let _ = served.await;
            answer
        };
        let result = self.runtime.block_on(async { timeout(HANG, exchange).await });
        let answer = result.map_err(|_| Defect::Slow(format!("no answer within {HANG:?}")))?;
        answer.map_err(|error| Defect::Wrong(format!("the connection broke: {error}")))
    }
}

/// Reads an answer with a body of known length.
fn parse(bytes: &[u8]) -> Result<Answer, Defect> {
    let wrong = || Defect::Wrong(format!("not an HTTP answer: {}", String::from_utf8_lossy(bytes)));
    let end = bytes.windows(4).position(|window| window == b"\r\n\r\n").ok_or_else(wrong)?;
    let head = std::str::from_utf8(&bytes[..end]).map_err(|_| wrong())?;
    let status = head.strip_prefix("HTTP/1.1 ").and_then(|rest| rest.get(..3)?.parse().ok()).ok_or_else(wrong)?;
    let header = |name: &str| head.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_default().to_owned();
    Ok(Answer { status, media_type: header("content-type: "), body: bytes[end + 4..].to_vec() })
}
