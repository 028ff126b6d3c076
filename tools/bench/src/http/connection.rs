//! A client with minimal cost: it sends prepared bytes and parses only the length of an answer.

use std::io::{self, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};

/// A request with a number in its body that increases with every call, at constant length.
#[derive(Debug, Clone)]
pub struct Request {
    bytes: Vec<u8>,
    /// Position of the number, if any.
    number: Option<usize>,
    next: u64,
}

/// The first number; all following numbers have the same number of digits.
const FIRST: u64 = 1_000_000_000;

/// Placeholder of the number in a body.
pub const NUMBER: &str = "1000000000";

/// Owner token of the sessions of the benchmark.
pub const OWNER: &str = "bench";

impl Request {
    /// Returns a `POST` request with a JSON body; [`NUMBER`] in it counts up.
    pub fn post(path: &str, body: &str) -> Self {
        let head = format!("POST {path} HTTP/1.1\r\nhost: localhost\r\nrevprio-owner: {OWNER}");
        let head = format!("{head}\r\ncontent-type: application/json");
        Self::from_text(format!("{head}\r\ncontent-length: {}\r\n\r\n{body}", body.len()))
    }

    /// Returns a request of any text; [`NUMBER`] in it counts up.
    pub fn from_text(text: String) -> Self {
        let number = text.rfind(NUMBER);
        Self { bytes: text.into_bytes(), number, next: FIRST }
    }

    /// Returns the bytes of the next call.
    pub fn next_bytes(&mut self) -> &[u8] {
        if let Some(at) = self.number {
            let mut rest = self.next;
            for digit in self.bytes[at..at + NUMBER.len()].iter_mut().rev() {
                *digit = b'0' + u8::try_from(rest % 10).unwrap_or(0);
                rest /= 10;
            }
            self.next += 1;
        }
        &self.bytes
    }

    /// Returns the length, bytes.
    pub fn length(&self) -> usize {
        self.bytes.len()
    }
}

/// A persistent connection.
#[derive(Debug)]
pub struct Connection {
    stream: TcpStream,
    buffer: Vec<u8>,
    request: Request,
}

impl Connection {
    pub fn open(address: SocketAddr, request: Request) -> io::Result<Self> {
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        Ok(Self { stream, buffer: vec![0; 64 << 10], request })
    }

    /// Sends the next request.
    pub fn send(&mut self) -> io::Result<()> {
        self.stream.write_all(self.request.next_bytes())
    }

    /// Reads a complete answer with status 200 and returns the length of head and body.
    pub fn receive(&mut self) -> io::Result<usize> {
        let mut filled = 0;
        loop {
            if filled == self.buffer.len() {
                self.buffer.resize(2 * filled, 0);
            }
            let read = self.stream.read(&mut self.buffer[filled..])?;
            if read == 0 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            filled += read;
            if let Some(length) = answer_length(&self.buffer[..filled])
                && filled >= length
            {
                return self.checked(length);
            }
        }
    }

    fn checked(&self, length: usize) -> io::Result<usize> {
        let answer = &self.buffer[..length];
        if answer.starts_with(b"HTTP/1.1 200") {
            return Ok(length);
        }
        Err(io::Error::other(String::from_utf8_lossy(answer)))
    }

    /// Sends a request and reads its answer.
    pub fn call(&mut self) -> io::Result<usize> {
        self.send()?;
        self.receive()
    }

    /// Sends another request and reads its answer.
    pub fn call_with(&mut self, request: &mut Request) -> io::Result<usize> {
        std::mem::swap(&mut self.request, request);
        let answer = self.call();
        std::mem::swap(&mut self.request, request);
        answer
    }

    /// Sends a request and reads `length` bytes without parsing them.
    pub fn call_bytes(&mut self, length: usize) -> io::Result<()> {
        self.send()?;
        self.stream.read_exact(&mut self.buffer[..length])
    }

    /// Returns the last answer.
    pub fn answer(&self, length: usize) -> &[u8] {
        &self.buffer[..length]
    }
}

/// Returns the length of head and body; `None` before the end of the head.
fn answer_length(bytes: &[u8]) -> Option<usize> {
    let head = bytes.windows(4).position(|window| window == b"\r\n\r\n")?;
    let name = b"content-length: ";
    let at = bytes[..head].windows(name.len()).position(|window| window == name)? + name.len();
    let digits = bytes[at..head].iter().take_while(|byte| byte.is_ascii_digit());
    Some(head + 4 + digits.fold(0, |length, digit| 10 * length + usize::from(digit - b'0')))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn number_counts_up_in_place() {
        let mut request = Request::from_text(format!("a{NUMBER}b"));
        assert_eq!(
            (request.next_bytes().to_vec(), request.next_bytes().to_vec()),
            (b"a1000000000b".into(), b"a1000000001b".into())
        );
    }

    #[test]
    fn length_of_an_answer_comes_from_its_head() {
        let head = b"HTTP/1.1 200 OK\r\ncontent-length: 12\r\n\r\n";
        assert_eq!(answer_length(head), Some(head.len() + 12));
        assert_eq!(answer_length(&head[..head.len() - 1]), None);
    }
}
