//! A session over WebSocket: one state message in, one answer out, for loops faster than requests allow.
//!
//! Without a subprotocol, or with `revprio.json`, messages are JSON in text frames; with `revprio.msgpack` they are
//! MessagePack in binary frames. The next state is read when the answer to the last one is sent, so that a slow reader
//! holds no memory. A state that is refused is answered by a problem object, which has a `status`, and the stream goes on.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, WebSocketUpgrade};
use axum::http::HeaderValue;
use axum::response::Response;
use tokio::time::{Instant, interval_at, timeout};

use super::app::AppState;
use super::drain::Draining;
use super::error::ApiError;
use super::format::Format;
use super::sessions::Answered;

/// Subprotocol of JSON.
const JSON: &str = "revprio.json";
/// Subprotocol of MessagePack.
const MESSAGE_PACK: &str = "revprio.msgpack";

/// Largest message in bytes; a state is about one sixtieth of it.
const MESSAGE_LIMIT: usize = 64 << 10;

/// Larger ones are not even read.
const READ_LIMIT: usize = 2 * MESSAGE_LIMIT;

/// Buffers of a connection: some messages.
const BUFFER: usize = 16 << 10;

/// A ping is sent this often.
const PING_INTERVAL: Duration = Duration::from_secs(10);

/// A client that is not heard of for this long, not even by an answer to a ping, is gone.
const SILENCE_LIMIT: Duration = Duration::from_secs(30);

/// Time for a client to read what is sent to it.
const READ_TIMEOUT: Duration = Duration::from_secs(5);

/// Time for a client to answer the closing of the stream.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(500);

/// Why a stream ends.
struct Farewell(u16, &'static str);

const DRAINING: Farewell = Farewell(1001, "the service ends");
const UNREADABLE: Farewell = Farewell(1002, "this is no WebSocket message, or a far too large one");
const INTERNAL: Farewell = Farewell(1011, "a defect of the service; the log has the details");
const NO_CONTROLLER: Farewell = Farewell(4404, "the controller has ended");
const SILENT: Farewell = Farewell(4408, "nothing was heard of the client");

/// Answers the upgrade and serves the session `id` until either side ends the stream.
pub fn accept(upgrade: WebSocketUpgrade, app: Arc<AppState>, id: String, draining: Draining) -> Response {
    let upgrade = upgrade
        .protocols([JSON, MESSAGE_PACK])
        .read_buffer_size(BUFFER)
        .write_buffer_size(0)
        .max_message_size(READ_LIMIT)
        .max_frame_size(READ_LIMIT);
    upgrade.on_upgrade(|socket| async move {
        let is_binary = socket.protocol().map(HeaderValue::as_bytes) == Some(MESSAGE_PACK.as_bytes());
        let format = if is_binary { Format::MessagePack } else { Format::Json };
        Stream { socket, app, id, format }.serve(draining).await;
    })
}

struct Stream {
    socket: WebSocket,
    app: Arc<AppState>,
    id: String,
    format: Format,
}

impl Stream {
    async fn serve(mut self, mut draining: Draining) {
        if let Err(Farewell(code, reason)) = self.answer_all(&mut draining).await {
            let close = CloseFrame { code, reason: Utf8Bytes::from_static(reason) };
            let _ = self.send(Message::Close(Some(close))).await;
            // Closed too early, the connection would be reset and the reason lost.
            let _ = timeout(CLOSE_TIMEOUT, async { while let Some(Ok(_)) = self.socket.recv().await {} }).await;
        }
    }

    /// Answers until the client is gone, or there is a reason to end.
    async fn answer_all(&mut self, draining: &mut Draining) -> Result<(), Farewell> {
        let mut heard = Instant::now();
        let mut pings = interval_at(heard + PING_INTERVAL, PING_INTERVAL);
        loop {
            let message = tokio::select! {
                message = self.socket.recv() => message,
                now = pings.tick() => {
                    if now.duration_since(heard) >= SILENCE_LIMIT {
                        return Err(SILENT);
                    }
                    if self.send(Message::Ping("".into())).await.is_err() {
                        return Ok(());
                    }
                    continue;
                }
                () = draining.begun() => return Err(DRAINING),
            };
            heard = Instant::now();
            let bytes = match message {
                Some(Ok(Message::Text(text))) => text.into(),
                Some(Ok(Message::Binary(bytes))) => bytes,
                Some(Ok(Message::Ping(_) | Message::Pong(_))) => continue,
                Some(Ok(Message::Close(_))) | None => return Ok(()),
                Some(Err(_)) => return Err(UNREADABLE),
            };
            let (answer, farewell) = self.answer(&bytes).map_err(|_| INTERNAL)?;
            if self.send(answer).await.is_err() {
                return Ok(());
            }
            farewell.map_or(Ok(()), Err)?;
        }
    }

    /// The answer to one state, and why it is the last one if it is.
    fn answer(&self, bytes: &[u8]) -> Result<(Message, Option<Farewell>), ApiError> {
        match self.step(bytes) {
            Ok(answer) => Ok((self.message(&answer)?, None)),
            Err(problem) => {
                self.app.metrics.refused(problem.kind());
                let farewell = problem.is_not_found().then_some(NO_CONTROLLER);
                Ok((self.message(&problem.into_wire())?, farewell))
            }
        }
    }

    fn step(&self, bytes: &[u8]) -> Result<Answered, ApiError> {
        if bytes.len() > MESSAGE_LIMIT {
            return Err(ApiError::too_large(MESSAGE_LIMIT));
        }
        self.app.sessions.step(&self.id, self.format.read(bytes)?)
    }

    fn message(&self, value: &impl serde::Serialize) -> Result<Message, ApiError> {
        let bytes = self.format.write(value)?;
        match self.format {
            Format::Json => String::from_utf8(bytes).map(Message::text).map_err(|_| ApiError::internal()),
            Format::MessagePack => Ok(Message::binary(bytes)),
        }
    }

    /// Sends a message, or finds that the client does not read.
    async fn send(&mut self, message: Message) -> Result<(), ()> {
        timeout(READ_TIMEOUT, self.socket.send(message)).await.map_err(drop)?.map_err(drop)
    }
}
