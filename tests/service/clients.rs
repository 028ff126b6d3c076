//! Clients that stop in the middle of a request.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::harness::{Service, example};

const HALF_A_HEADER: &str = "POST /v1/resolve HTTP/1.1\r\nhost: localhost\r\ncontent-ty";
const HALF_A_BODY: &str = "POST /v1/resolve HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\ncontent-length: 500\r\n\r\n{\"robot\"";

/// Far below every timeout of the service.
const PROMPTLY: Duration = Duration::from_secs(5);

/// Opens connections that send these bytes and then nothing.
fn stopped_clients(service: &Service, count: usize, bytes: &str) -> Vec<TcpStream> {
    let connect = |_| {
        let mut stream = service.connect();
        stream.write_all(bytes.as_bytes()).unwrap();
        stream
    };
    (0..count).map(connect).collect()
}

#[test]
fn stopped_clients_do_not_delay_a_working_one() {
    let service = Service::start();
    let stopped = ["", HALF_A_HEADER, HALF_A_BODY].map(|bytes| stopped_clients(&service, 50, bytes));
    let start = Instant::now();
    for _ in 0..50 {
        service.call("/v1/resolve", &example("resolve.json"));
    }
    assert!(start.elapsed() < PROMPTLY, "{:?}", start.elapsed());
    drop(stopped);
    service.assert_alive();
}

#[test]
fn the_service_ends_promptly_with_stopped_clients() {
    for bytes in ["", "GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n", HALF_A_HEADER, HALF_A_BODY] {
        let service = Service::start();
        let stopped = stopped_clients(&service, 20, bytes);
        service.assert_alive();
        let start = Instant::now();
        drop(service);
        assert!(start.elapsed() < PROMPTLY, "{bytes:?}: {:?}", start.elapsed());
        drop(stopped);
    }
}

#[test]
fn a_missing_body_is_answered_with_408() {
    let service = Service::start();
    let mut stream = stopped_clients(&service, 1, HALF_A_BODY).remove(0);
    let mut answer = [0; 12];
    stream.read_exact(&mut answer).unwrap();
    assert_eq!(&answer, b"HTTP/1.1 408");
}

#[test]
fn pipelined_requests_are_all_answered() {
    let service = Service::start();
    let one = "GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n";
    let last = "GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n";
    let answers = service.raw((one.repeat(9) + last).as_bytes());
    assert_eq!(answers.matches("HTTP/1.1 200 OK").count(), 10);
}
