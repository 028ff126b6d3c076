//! The request of the clients, and clients that send only half of one.

use std::io::Write as _;
use std::net::TcpStream;

use super::server::Server;
use crate::error::BenchError;

/// One control period, about 1 KB.
pub const STEP: &str = include_str!("../../../../api/examples/step.json");

const HALF_A_REQUEST: &[u8] = b"POST /v1/step HTTP/1.1\r\nhost: localhost\r\ncontent-ty";

/// Connects clients that send half a request and wait.
pub fn half_requests(server: &Server, count: usize) -> Result<Vec<TcpStream>, BenchError> {
    let half = |_| {
        let mut stream = TcpStream::connect(server.address)?;
        stream.write_all(HALF_A_REQUEST)?;
        Ok(stream)
    };
    (0..count).map(half).collect()
}
