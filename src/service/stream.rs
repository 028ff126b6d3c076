//! A session over WebSocket: one state in, one answer out. A stream is faster than requests.
//!
//! Messages are JSON in text frames (no subprotocol or `revprio.json`) or MessagePack in binary frames
//! (`revprio.msgpack`). The next state is read after the answer to the last one is sent, so a slow reader uses no memory.
//! A refused state is answered with a problem object, which has a `status`, and the stream continues.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, WebSocketUpgrade};
use axum::http::HeaderValue;
use axum::response::Response;
use tokio::time::{Instant, interval_at, timeout};

use super::connection::ServingTask;
use super::drain::Draining;
use super::error::ApiError;
use super::format::Format;
use super::interleaving::Source;
use super::ownership::Owner;
use super::sessions::SharedAnswer;
use super::state::AppState;

/// Subprotocol of JSON.
const JSON: &str = "revprio.json";
/// Subprotocol of MessagePack.
const MESSAGE_PACK: &str = "revprio.msgpack";

/// Maximum size of a message, bytes. A state has about one sixtieth of it.
const MAX_MESSAGE: usize = 64 << 10;

/// Maximum size of a message that is read and refused, bytes. A larger one ends the stream.
const MAX_READ: usize = 2 * MAX_MESSAGE;

/// Size of the read buffer, bytes: a few messages.
const BUFFER: usize = 16 << 10;

/// Size of the write buffer, bytes: more than an answer needs. Where it is full, only the answer to the newest ping waits.
const MAX_WRITE: usize = 1 << 20;

/// Time between two pings.
const PING_INTERVAL: Duration = Duration::from_secs(10);

/// A client that sends nothing for this long, not even an answer to a ping, is gone.
const MAX_SILENCE: Duration = Duration::from_secs(30);

/// Timeout for a client that does not read.
const READ_TIMEOUT: Duration = Duration::from_secs(5);

/// Timeout for the end of a stream after a close frame.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(500);

/// Why a state is refused that comes as text where MessagePack was agreed on.
const TEXT_FRAME: &str = "a text frame on a stream with `revprio.msgpack`; send MessagePack in binary frames, or open the stream with `revprio.json`";

/// Number of the next stream.
static NEXT_STREAM: AtomicU64 = AtomicU64::new(0);

/// Code and reason of a close frame.
struct CloseReason(u16, &'static str);

const DRAINING: CloseReason = CloseReason(1001, "the service ends");
const UNREADABLE: CloseReason = CloseReason(1002, "the message is not a WebSocket message, or is far too large");
const INTERNAL: CloseReason = CloseReason(1011, "a defect of the service; the log has the details");
const NO_CONTROLLER: CloseReason = CloseReason(4404, "the controller has ended");
const SILENT: CloseReason = CloseReason(4408, "the client was silent for too long");

/// Upgrades the connection, and serves the session `id` until either side ends the stream. `task`: the place of the task that serves the
/// connection from then on.
pub fn accept(upgrade: WebSocketUpgrade, task: ServingTask, app: Arc<AppState>, id: String, owner: Owner) -> Response {
    let draining = app.drain.subscribe();
    let upgrade = upgrade
        .protocols([JSON, MESSAGE_PACK])
        .read_buffer_size(BUFFER)
        .write_buffer_size(0)
        .max_write_buffer_size(MAX_WRITE)
        .max_message_size(MAX_READ)
        .max_frame_size(MAX_READ);
    upgrade.on_upgrade(|socket| async move {
        let is_binary = socket.protocol().map(HeaderValue::as_bytes) == Some(MESSAGE_PACK.as_bytes());
        let format = if is_binary { Format::MessagePack } else { Format::Json };
        let source = Source::Stream(NEXT_STREAM.fetch_add(1, Ordering::Relaxed));
        task.note_state();
        let stream = Stream { socket, app, id, owner, source, format, task: task.clone() };
        let serving = tokio::spawn(stream.serve(draining));
        task.set(serving.abort_handle());
        let _ = serving.await;
    })
}

struct Stream {
    socket: WebSocket,
    app: Arc<AppState>,
    id: String,
    owner: Owner,
    source: Source,
    format: Format,
    task: ServingTask,
}

impl Stream {
    async fn serve(mut self, mut draining: Draining) {
        if let Err(CloseReason(code, reason)) = self.answer_all(&mut draining).await {
            let close = CloseFrame { code, reason: Utf8Bytes::from_static(reason) };
            let _ = self.send(Message::Close(Some(close))).await;
        }
        // An early end would reset the connection, and the client would lose the reason. Reading also sends the answer to a close frame.
        let _ = timeout(CLOSE_TIMEOUT, async { while let Some(Ok(_)) = self.socket.recv().await {} }).await;
    }

    /// Answers until the client is gone or the service has a reason to end the stream.
    async fn answer_all(&mut self, draining: &mut Draining) -> Result<(), CloseReason> {
        let mut last_received = Instant::now();
        let mut pings = interval_at(last_received + PING_INTERVAL, PING_INTERVAL);
        loop {
            let message = tokio::select! {
                // The same order every time. Messages are last: a client that never pauses must not delay the others.
                biased;
                () = draining.begun() => return Err(DRAINING),
                now = pings.tick() => {
                    if now.duration_since(last_received) >= MAX_SILENCE {
                        return Err(SILENT);
                    }
                    if self.send(Message::Ping("".into())).await.is_err() {
                        return Ok(());
                    }
                    continue;
                }
                message = self.socket.recv() => message,
            };
            last_received = Instant::now();
            let (bytes, is_text) = match message {
                Some(Ok(Message::Text(text))) => (text.into(), true),
                Some(Ok(Message::Binary(bytes))) => (bytes, false),
                Some(Ok(Message::Ping(_) | Message::Pong(_))) => continue,
                Some(Ok(Message::Close(_))) | None => return Ok(()),
                Some(Err(_)) => return Err(UNREADABLE),
            };
            self.task.note_state();
            let (answer, close_reason) = self.answer(&bytes, is_text).await.map_err(|_| INTERNAL)?;
            if self.send(answer).await.is_err() {
                return Ok(());
            }
            close_reason.map_or(Ok(()), Err)?;
            // More messages may have arrived with this one. Other connections have their turn first.
            tokio::task::yield_now().await;
        }
    }

    /// Returns the answer to one state, and a reason to close the stream after it.
    async fn answer(&mut self, bytes: &[u8], is_text: bool) -> Result<(Message, Option<CloseReason>), ApiError> {
        match self.step(bytes, is_text).await {
            Ok(answer) => Ok((self.message(&answer)?, None)),
            Err(error) => {
                self.app.metrics.count_problem(error.kind());
                let close_reason = error.is_not_found().then_some(NO_CONTROLLER);
                Ok((self.message(&error.into_wire())?, close_reason))
            }
        }
    }

    async fn step(&mut self, bytes: &[u8], is_text: bool) -> Result<SharedAnswer, ApiError> {
        if is_text && self.format == Format::MessagePack {
            return Err(ApiError::malformed(TEXT_FRAME));
        }
        if bytes.len() > MAX_MESSAGE {
            return Err(ApiError::too_large(MAX_MESSAGE));
        }
        let state = self.format.read(bytes)?;
        self.app.sessions.step(&self.id, state, &self.owner, self.source, &self.app.large_steps).await
    }

    fn message(&self, value: &impl serde::Serialize) -> Result<Message, ApiError> {
        let bytes = self.format.write(value)?;
        match self.format {
            Format::Json => String::from_utf8(bytes).map(Message::text).map_err(|_| ApiError::internal()),
            Format::MessagePack => Ok(Message::binary(bytes)),
        }
    }

    /// Sends a message. An error means that the client is gone or does not read.
    async fn send(&mut self, message: Message) -> Result<(), ()> {
        timeout(READ_TIMEOUT, self.socket.send(message)).await.map_err(drop)?.map_err(drop)
    }
}
