//! HTTP/1.1 as strict as possible: one whole answer per request, and no byte more.

use std::fmt::Write as _;
use std::io;

use revprio_api::wire;
use serde::de::DeserializeOwned;
use tokio::io::{AsyncReadExt, AsyncWriteExt};

use crate::network::Wire;
use crate::random::Random;

/// A request.
#[derive(Debug, Clone)]
pub struct Request {
    pub method: &'static str,
    pub path: String,
    pub headers: Vec<(&'static str, String)>,
    pub body: Vec<u8>,
    /// Sent as `x-request-id`. The answer must repeat it.
    pub id: String,
}

/// An answer.
#[derive(Debug, Clone)]
pub struct Answer {
    pub status: u16,
    pub headers: Vec<(String, String)>,
    pub body: Vec<u8>,
}

/// The reason why there is no answer.
#[derive(Debug)]
pub enum NoAnswer {
    /// The connection ended before the first byte.
    Closed,
    /// The connection ended in the middle of the answer.
    Cut,
    /// The bytes are no answer.
    Malformed,
}

impl Request {
    pub fn new(method: &'static str, path: impl Into<String>, id: String) -> Self {
        Self { method, path: path.into(), headers: vec![("host", "localhost".to_owned())], body: Vec::new(), id }
    }

    pub fn with(mut self, name: &'static str, value: impl Into<String>) -> Self {
        self.headers.push((name, value.into()));
        self
    }

    pub fn with_body(self, media_type: &str, body: Vec<u8>) -> Self {
        Self { body, ..self.with("content-type", media_type) }
    }

    /// Returns the bytes of the request.
    pub fn bytes(&self) -> Vec<u8> {
        let mut head = format!("{} {} HTTP/1.1\r\nx-request-id: {}\r\n", self.method, self.path, self.id);
        for (name, value) in &self.headers {
            let _ = write!(head, "{name}: {value}\r\n");
        }
        if self.method == "POST" {
            let _ = write!(head, "content-length: {}\r\n", self.body.len());
        }
        [head.as_bytes(), b"\r\n", &self.body].concat()
    }
}

impl Answer {
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    pub fn closes(&self) -> bool {
        self.header("connection").is_some_and(|value| value.eq_ignore_ascii_case("close"))
    }

    /// Returns the kind of a problem, such as `sequence`; empty if the answer is none.
    pub fn problem(&self) -> String {
        let problem = self.read::<wire::Problem>().map(|problem| problem.kind).unwrap_or_default();
        problem.trim_start_matches("/problems/").to_owned()
    }

    /// Decodes the body in the format of its media type.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, String> {
        match self.header("content-type") {
            Some("application/json" | "application/problem+json") => {
                serde_json::from_slice(&self.body).map_err(|error| error.to_string())
            }
            Some("application/msgpack") => rmp_serde::from_slice(&self.body).map_err(|error| error.to_string()),
            other => Err(format!("media type {other:?}")),
        }
    }
}

/// A client's connection.
pub struct Connection {
    pub wire: Wire,
    received: Vec<u8>,
    /// Number of answers.
    pub answers: u32,
}

impl Connection {
    pub fn new(wire: Wire) -> Self {
        Self { wire, received: Vec::new(), answers: 0 }
    }

    /// Reads one answer to a request with this method.
    pub async fn read(&mut self, method: &str) -> Result<Answer, NoAnswer> {
        let head_length = loop {
            if let Some(at) = self.received.windows(4).position(|window| window == b"\r\n\r\n") {
                break at + 4;
            }
            self.fill().await?;
        };
        let head: Vec<u8> = self.received.drain(..head_length).collect();
        let mut answer = parse_head(&head).ok_or(NoAnswer::Malformed)?;
        if method != "HEAD" && answer.status != 204 {
            let length = answer.header("content-length").and_then(|length| length.parse::<usize>().ok());
            let length = length.ok_or(NoAnswer::Malformed)?;
            while self.received.len() < length {
                self.fill().await.map_err(|_| NoAnswer::Cut)?;
            }
            answer.body = self.received.drain(..length).collect();
        }
        self.answers += 1;
        Ok(answer)
    }

    /// Returns whether bytes arrived that belong to no request.
    pub fn has_more(&self) -> bool {
        !self.received.is_empty()
    }

    async fn fill(&mut self) -> Result<(), NoAnswer> {
        match self.wire.read_buf(&mut self.received).await {
            Ok(1..) => Ok(()),
            _ if self.received.is_empty() => Err(NoAnswer::Closed),
            _ => Err(NoAnswer::Cut),
        }
    }
}

fn parse_head(head: &[u8]) -> Option<Answer> {
    let mut lines = std::str::from_utf8(head).ok()?.trim_end_matches("\r\n").split("\r\n");
    let status = lines.next()?.strip_prefix("HTTP/1.1 ")?.get(..3)?.parse().ok()?;
    let header = |line: &str| line.split_once(": ").map(|(name, value)| (name.to_owned(), value.to_owned()));
    Some(Answer { status, headers: lines.map(header).collect::<Option<_>>()?, body: Vec::new() })
}

/// Writes bytes, in pieces with pauses if `random` decides so.
pub async fn write(mut wire: Wire, bytes: &[u8], random: &mut Random) -> io::Result<()> {
    let pieces = if random.one_in(3) { random.below(6) + 1 } else { 1 };
    for piece in bytes.chunks(bytes.len().div_ceil(pieces).max(1)) {
        wire.write_all(piece).await?;
        if pieces > 1 && random.one_in(3) {
            tokio::time::sleep(random.millis(0, 3)).await;
        }
    }
    Ok(())
}
