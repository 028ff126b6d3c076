//! Clients that stop in the middle.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::harness::{Service, example};

const HALF_A_HEADER: &str = "POST /v1/resolve HTTP/1.1\r\nhost: a\r\ncontent-ty";
const HALF_A_BODY: &str =
    "POST /v1/resolve HTTP/1.1\r\nhost: a\r\ncontent-type: application/json\r\ncontent-length: 500\r\n\r\n{\"robot\"";

/// Far less than any time limit of the service: nobody waited for one of them.
const PROMPTLY: Duration = Duration::from_secs(5);

/// Connections that send these bytes and then nothing.
fn dead_clients(service: &Service, count: usize, bytes: &str) -> Vec<TcpStream> {
    let connect = |_| {
        let mut stream = service.connect();
        stream.write_all(bytes.as_bytes()).unwrap();
        stream
    };
    (0..count).map(connect).collect()
}

#[test]
fn dead_clients_do_not_delay_an_honest_one() {
    let service = Service::start();
    let dead = ["", HALF_A_HEADER, HALF_A_BODY].map(|bytes| dead_clients(&service, 50, bytes));
    let start = Instant::now();
    for _ in 0..50 {
        service.ask("/v1/resolve", &example("resolve.json"));
    }
    assert!(start.elapsed() < PROMPTLY, "{:?}", start.elapsed());
    drop(dead);
    service.assert_alive();
}

#[test]
fn the_service_ends_promptly_with_dead_clients() {
    for bytes in ["", "GET /healthz HTTP/1.1\r\nhost: a\r\n\r\n", HALF_A_HEADER, HALF_A_BODY] {
        let service = Service::start();
        let dead = dead_clients(&service, 20, bytes);
        service.assert_alive();
        let start = Instant::now();
        drop(service);
        assert!(start.elapsed() < PROMPTLY, "{bytes:?}: {:?}", start.elapsed());
        drop(dead);
    }
}

#[test]
fn a_body_that_does_not_come_is_given_up() {
    let service = Service::start();
    let mut stream = dead_clients(&service, 1, HALF_A_BODY).remove(0);
    let mut answer = [0; 12];
    stream.read_exact(&mut answer).unwrap();
    assert_eq!(&answer, b"HTTP/1.1 408");
}

#[test]
fn requests_may_follow_each_other_without_waiting() {
    let service = Service::start();
    let one = "GET /healthz HTTP/1.1\r\nhost: a\r\n\r\n";
    let last = "GET /healthz HTTP/1.1\r\nhost: a\r\nconnection: close\r\n\r\n";
    let answers = service.raw((one.repeat(9) + last).as_bytes());
    assert_eq!(answers.matches("HTTP/1.1 200 OK").count(), 10);
}
