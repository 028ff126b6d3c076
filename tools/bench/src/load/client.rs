//! One client of the load test.

use std::io;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use tokio::net::TcpStream;

use super::tally::Tally;
use crate::error::BenchError;

/// Timeout for an answer.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(30);

/// A request as bytes.
#[derive(Clone)]
pub struct Request(std::sync::Arc<str>);

impl Request {
    pub fn post(path: &str, body: &str) -> Self {
        let head = format!("POST {path} HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json");
        Self(format!("{head}\r\ncontent-length: {}\r\n\r\n{body}", body.len()).into())
    }

    pub fn bytes(&self) -> &[u8] {
        self.0.as_bytes()
    }

    pub fn get(path: &str) -> Self {
        Self(format!("GET {path} HTTP/1.1\r\nhost: localhost\r\n\r\n").into())
    }
}

/// When a client sends its requests.
#[derive(Debug, Clone, Copy)]
pub enum Pace {
    /// Directly after each answer.
    Unpaced,
    /// Once per period.
    Every(Duration),
}

/// The times at which one client sends.
pub struct Schedule {
    pace: Pace,
    next: Instant,
}

impl Pace {
    /// Returns the schedule of client `i` of `clients`; the clients are spread over the period.
    pub fn schedule(self, start: Instant, i: usize, clients: usize) -> Schedule {
        let offset = match self {
            Self::Unpaced => Duration::ZERO,
            Self::Every(period) => period.mul_f64(i as f64 / clients as f64),
        };
        Schedule { pace: self, next: start + offset }
    }
}

impl Schedule {
    /// Waits for the next time to send and returns the number of missed periods.
    async fn next(&mut self) -> u64 {
        let Pace::Every(period) = self.pace else { return 0 };
        let mut missed = 0;
        while self.next + period < Instant::now() {
            self.next += period;
            missed += 1;
        }
        tokio::time::sleep_until(self.next.into()).await;
        self.next += period;
        missed
    }
}

/// Sends requests until a time.
pub async fn send_until(
    address: SocketAddr,
    request: Request,
    mut schedule: Schedule,
    until: Instant,
) -> Result<Tally, BenchError> {
    let mut tally = Tally::default();
    let mut stream = connect(address).await?;
    loop {
        tally.missed += schedule.next().await;
        let start = Instant::now();
        if start >= until {
            return Ok(tally);
        }
        let answer = tokio::time::timeout(ANSWER_TIMEOUT, call(&stream, request.0.as_bytes())).await;
        let answer = answer.map_err(|_| BenchError::Load(format!("no answer within {ANSWER_TIMEOUT:?}")))??;
        match (answer.status, answer.has("retry-after:")) {
            (200, _) => tally.accepted.push(start.elapsed()),
            (503, true) => tally.shed += 1,
            (status, _) => return Err(BenchError::Load(format!("status {status}: {}", answer.head))),
        }
        if answer.has("connection: close") {
            stream = connect(address).await?;
        }
    }
}

async fn connect(address: SocketAddr) -> io::Result<TcpStream> {
    let stream = TcpStream::connect(address).await?;
    stream.set_nodelay(true)?;
    Ok(stream)
}

/// A complete answer.
pub struct Answer {
    pub status: u16,
    head: String,
    /// Place of the first byte of the body.
    pub body: usize,
}

impl Answer {
    fn has(&self, header: &str) -> bool {
        self.head.lines().any(|line| line.starts_with(header))
    }
}

/// Sends a request and reads its complete answer.
async fn call(stream: &TcpStream, mut request: &[u8]) -> io::Result<Answer> {
    while !request.is_empty() {
        stream.writable().await?;
        match stream.try_write(request) {
            Ok(written) => request = &request[written..],
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => (),
            Err(error) => return Err(error),
        }
    }
    let (mut bytes, mut part) = (Vec::with_capacity(4096), [0; 4096]);
    loop {
        stream.readable().await?;
        match stream.try_read(&mut part) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(read) => bytes.extend_from_slice(&part[..read]),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => continue,
            Err(error) => return Err(error),
        }
        if let Some(answer) = parse_answer(&bytes) {
            return Ok(answer);
        }
    }
}

/// Parses an answer; `None` if it is not complete.
pub fn parse_answer(bytes: &[u8]) -> Option<Answer> {
    let end = bytes.windows(4).position(|window| window == b"\r\n\r\n")?;
    let head = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let length = head.lines().find_map(|line| line.strip_prefix("content-length: ")?.parse::<usize>().ok())?;
    let status = head.split(' ').nth(1)?.parse().ok()?;
    (bytes.len() >= end + 4 + length).then_some(Answer { status, head, body: end + 4 })
}
