//! Watching a session without delaying it.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use revprio_api::wire;
use serde_json::{Value, json};

use crate::harness::{LONG_DRAIN, Service, example};

fn state(sequence: u64) -> Value {
    let mut state = example("state.json");
    state["sequence"] = json!(sequence);
    state
}

/// Reads the events of a session.
struct Watcher(BufReader<TcpStream>);

impl Watcher {
    fn open(service: &Service, session: &str) -> Self {
        let mut stream = service.connect();
        write!(stream, "GET {session}/watch HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n").unwrap();
        Self(BufReader::new(stream))
    }

    /// Returns the next event; `None` at the end.
    fn next(&mut self) -> Option<Value> {
        let mut line = String::new();
        while self.0.read_line(&mut line).unwrap() > 0 {
            if let Some(data) = line.strip_prefix("data: ") {
                return Some(serde_json::from_str(data).unwrap());
            }
            line.clear();
        }
        None
    }
}

#[test]
fn a_watcher_gets_the_last_step_at_once_and_then_new_ones() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let mut early = Watcher::open(&service, &session);
    let answer = service.call(&format!("{session}/step"), &state(7));
    let mut late = Watcher::open(&service, &session);
    for watcher in [&mut early, &mut late] {
        let seen: wire::WatchedStep = serde_json::from_value(watcher.next().unwrap()).unwrap();
        assert_eq!(seen.state, serde_json::from_value(state(7)).unwrap());
        assert_eq!(seen.answer, serde_json::from_value(answer.clone()).unwrap());
    }
    service.get("/v1/controllers/nobody/watch").assert_refused(404, None);
}

#[test]
fn a_watcher_gets_events_at_a_limited_rate_until_the_controller_ends() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let mut watcher = Watcher::open(&service, &session);
    let start = Instant::now();
    for sequence in 0..500 {
        service.call(&format!("{session}/step"), &state(sequence));
    }
    std::thread::sleep(Duration::from_millis(100));
    let time = start.elapsed();
    service.delete(&session);
    let seen: Vec<u64> =
        std::iter::from_fn(|| watcher.next()).map(|event| event["state"]["sequence"].as_u64().unwrap()).collect();
    assert!(seen.is_sorted_by(|a, b| a < b) && seen.last() == Some(&499), "{seen:?}");
    assert!(seen.len() as f64 <= 2.0 + time.as_secs_f64() / 0.033, "{} in {time:?}", seen.len());
}

#[test]
fn a_service_with_watchers_ends_promptly() {
    let service = Service::with_long_drain();
    let session = service.open(&example("controller.json"));
    let mut watcher = Watcher::open(&service, &session);
    service.call(&format!("{session}/step"), &state(1));
    watcher.next().unwrap();
    let start = Instant::now();
    drop(service);
    assert!(start.elapsed() < LONG_DRAIN / 2, "{:?}", start.elapsed());
    assert_eq!(watcher.next(), None);
}
