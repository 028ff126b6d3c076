//! A session over WebSocket.

use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::protocol::CloseFrame;
use tungstenite::{Message, WebSocket};

use crate::harness::{LONG_DRAIN, Service, example, without};

/// A client of one stream.
pub struct Client {
    socket: WebSocket<TcpStream>,
    protocol: Option<String>,
}

impl Client {
    /// Opens a stream of a session.
    pub fn open(service: &Service, session: &str, protocol: Option<&str>) -> Self {
        let mut request = (service.url().replace("http", "ws") + session + "/stream").into_client_request().unwrap();
        if let Some(protocol) = protocol {
            request.headers_mut().insert("sec-websocket-protocol", protocol.parse().unwrap());
        }
        let (socket, answer) = tungstenite::client(request, service.connect()).unwrap();
        let protocol = answer.headers().get("sec-websocket-protocol").map(|name| name.to_str().unwrap().to_owned());
        Self { socket, protocol }
    }

    /// Sends a text message and returns the answer.
    pub fn call(&mut self, text: &str) -> Value {
        self.socket.send(Message::text(text)).unwrap();
        self.read()
    }

    fn read(&mut self) -> Value {
        loop {
            match self.socket.read().unwrap() {
                Message::Text(text) => return serde_json::from_str(&text).unwrap(),
                Message::Binary(bytes) => return rmp_serde::from_slice(&bytes).unwrap(),
                Message::Ping(_) | Message::Pong(_) => (),
                other => panic!("{other:?}"),
            }
        }
    }

    /// Returns the close frame of the service.
    fn close_frame(&mut self) -> CloseFrame {
        loop {
            if let Message::Close(frame) = self.socket.read().unwrap() {
                return frame.unwrap();
            }
        }
    }
}

fn state(sequence: u64) -> Value {
    let mut state = example("state.json");
    state["sequence"] = json!(sequence);
    state["time_s"] = json!(0.001 * sequence as f64);
    state["wrench"]["force"][0] = json!(0.1 * sequence as f64);
    state
}

#[test]
fn a_stream_answers_as_requests_do_to_the_last_bit_in_every_protocol() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let step = |sequence| without(service.call(&format!("{session}/step"), &state(sequence)), &["elapsed_us"]);
    let expected: Vec<Value> = (0..50).map(step).collect();
    for protocol in [None, Some("revprio.json"), Some("revprio.msgpack")] {
        let session = service.open(&example("controller.json"));
        let mut client = Client::open(&service, &session, protocol);
        assert_eq!(client.protocol.as_deref(), protocol);
        for sequence in 0..50 {
            let answer = if protocol == Some("revprio.msgpack") {
                client.socket.send(Message::binary(rmp_serde::to_vec_named(&state(sequence)).unwrap())).unwrap();
                client.read()
            } else {
                client.call(&state(sequence).to_string())
            };
            assert_eq!(without(answer, &["elapsed_us"]), expected[usize::try_from(sequence).unwrap()]);
        }
        let shown = service.get(&session).accepted();
        assert_eq!((&shown["steps"], &shown["last_sequence"]), (&json!(50), &json!(49)));
    }
}

#[test]
fn the_first_known_subprotocol_is_used() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let client = Client::open(&service, &session, Some("v12.other, revprio.msgpack"));
    assert_eq!(client.protocol.as_deref(), Some("revprio.msgpack"));
}

#[test]
fn refused_states_get_problems_and_the_stream_continues() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let mut client = Client::open(&service, &session, None);
    let first = client.call(&state(5).to_string());
    assert_eq!(first["sequence"], 5);
    assert_eq!(client.call(&state(5).to_string()), first);
    let mut changed = state(5);
    changed["joint_position"][0] = json!(2.0);
    let mut short = state(6);
    short["joint_position"] = json!([1]);
    for (text, status, pointer) in [
        (changed.to_string(), 409, json!("/sequence")),
        (state(4).to_string(), 409, json!("/sequence")),
        (short.to_string(), 422, json!("/joint_position")),
        ("{}".to_owned(), 422, json!("")),
        ("hello".to_owned(), 400, Value::Null),
        (state(6).to_string() + &" ".repeat(70_000), 413, Value::Null),
    ] {
        let problem = client.call(&text);
        assert_eq!((&problem["status"], &problem["pointer"]), (&json!(status), &pointer), "{problem}");
        assert!(problem["type"].as_str().unwrap().starts_with("/problems/"));
    }
    assert_eq!(client.call(&state(6).to_string())["sequence"], 6);
}

#[test]
fn text_on_a_stream_of_message_pack_is_named() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let mut client = Client::open(&service, &session, Some("revprio.msgpack"));
    let problem = client.call(&state(1).to_string());
    assert_eq!(problem["status"], 400, "{problem}");
    assert!(problem["detail"].as_str().unwrap().contains("a text frame on a stream"), "{problem}");
}

#[test]
fn several_streams_share_one_session() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let mut clients = [None, Some("revprio.json")].map(|protocol| Client::open(&service, &session, protocol));
    for sequence in 0..10 {
        let answer = clients[usize::from(sequence % 2 == 1)].call(&state(sequence).to_string());
        assert_eq!(answer["sequence"], sequence);
    }
    assert_eq!(clients[0].call(&state(3).to_string())["status"], 409);
}

#[test]
fn the_end_of_the_controller_closes_the_stream_with_a_code() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let mut client = Client::open(&service, &session, None);
    client.call(&state(1).to_string());
    service.delete(&session);
    assert_eq!(client.call(&state(2).to_string())["status"], 404);
    assert_eq!(u16::from(client.close_frame().code), 4404);
}

#[test]
fn the_shutdown_closes_streams_promptly_with_a_code() {
    let service = Service::with_long_drain();
    let session = service.open(&example("controller.json"));
    let mut client = Client::open(&service, &session, None);
    client.call(&state(1).to_string());
    let start = Instant::now();
    let end = std::thread::spawn(move || drop(service));
    assert_eq!(u16::from(client.close_frame().code), 1001);
    end.join().unwrap();
    assert!(start.elapsed() < LONG_DRAIN / 2, "{:?}", start.elapsed());
}

#[test]
fn a_far_too_large_message_ends_only_its_own_stream() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let mut client = Client::open(&service, &session, None);
    // The service may close the stream before the whole message is sent.
    let _ = client.socket.send(Message::text(" ".repeat(3 << 20)));
    let ended = (0..10).any(|_| !matches!(client.socket.read(), Ok(Message::Text(_) | Message::Binary(_))));
    assert!(ended);
    service.assert_alive();
    service.get(&session).accepted();
}

#[test]
fn a_client_that_does_not_read_delays_nobody() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    let mut client = Client::open(&service, &session, None);
    client.socket.get_ref().set_write_timeout(Some(Duration::from_millis(200))).unwrap();
    // Fills all buffers: each answer is larger than its state.
    let sent = (0..100_000).take_while(|i| client.socket.send(Message::text(state(*i).to_string())).is_ok()).count();
    assert!(sent < 100_000);
    service.assert_alive();
    let steps = service.get(&session).accepted()["steps"].as_u64().unwrap();
    assert!(steps <= sent as u64);
    let other = service.open(&example("controller.json"));
    service.call(&format!("{other}/step"), &state(1));
}

#[test]
fn a_stream_needs_a_controller_and_a_web_socket() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    service.get(&format!("{session}/stream")).assert_refused(426, None);
    service.get("/v1/controllers/nobody/stream").assert_refused(404, None);
    service.post(&format!("{session}/stream"), "{}").assert_refused(405, None);
    let request =
        (service.url().replace("http", "ws") + "/v1/controllers/nobody/stream").into_client_request().unwrap();
    match tungstenite::client(request, service.connect()) {
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => assert_eq!(answer.status(), 404),
        other => panic!("{:?}", other.map(drop)),
    }
}

#[test]
fn a_client_that_closes_gets_the_answer_of_the_close_frame() {
    let service = Service::start();
    let session = service.open(&example("controller.json"));
    for code in [1000, 4000] {
        let mut client = Client::open(&service, &session, None);
        client.socket.close(Some(CloseFrame { code: code.into(), reason: "bye".into() })).unwrap();
        assert_eq!(u16::from(client.close_frame().code), code);
        // A clean end, and no reset.
        assert!(matches!(client.socket.read(), Err(tungstenite::Error::ConnectionClosed)));
    }
}
