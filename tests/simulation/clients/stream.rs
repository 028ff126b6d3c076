//! A control loop over WebSocket.

use std::sync::Arc;
use std::time::Duration;

use futures_util::{SinkExt as _, StreamExt as _};
use revprio_api::wire;
use tokio::time::Instant;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{Error, Message};

use super::pilot::Pilot;
use crate::call::{Call, Format};
use crate::exchange::Client;
use crate::http::Answer;
use crate::network::Wire;
use crate::oracle::{End, Sent};
use crate::transcript;
use crate::world::Instance;

/// Longer than every timeout of the service.
const FOREVER: Duration = Duration::from_mins(2);

/// An open stream.
struct Socket {
    messages: WebSocketStream<Wire>,
    instance: Arc<Instance>,
    format: Format,
    /// Whether the last answer said that the session has ended.
    has_ended: bool,
    /// Time of the client's last message, and the longest time without one. A client that does not read sends no pongs.
    last_sent: Instant,
    longest_silence: Duration,
}

pub async fn run(client: &mut Client) {
    let (mut pilot, mut link) = (Pilot::new(&mut client.random), None);
    client.pause(0, 30).await;
    for _ in 0..client.random.from(1, 4) {
        if pilot.session.is_none() && !pilot.open(client, &mut link).await {
            client.pause(100, 3000).await;
            continue;
        }
        if let Some(socket) = connect(client, &mut pilot).await {
            drive(client, &mut pilot, socket).await;
            pilot.miss();
        }
    }
}

/// Opens a stream. The owner token is wrong once in a while.
async fn connect(client: &mut Client, pilot: &mut Pilot) -> Option<Socket> {
    // The answers to the messages that are sent together must have a place.
    let link = client.connect_through(1 << 16)?;
    let session = pilot.session.clone()?;
    let (format, is_wrong) = (Format::random(&mut client.random), client.random.one_in(10) && pilot.owner().is_some());
    let mut request = format!("ws://localhost/v1/controllers/{session}/stream").into_client_request().unwrap();
    let owner = if is_wrong { Some(client.random.word()) } else { pilot.owner() };
    let protocol = (format == Format::MessagePack).then(|| "revprio.msgpack".to_owned());
    let token = client.world.plan.needs_token.then(|| format!("Bearer {}", crate::plan::TOKEN));
    for (name, value) in [("revprio-owner", owner), ("sec-websocket-protocol", protocol), ("authorization", token)] {
        value.map(|value| request.headers_mut().insert(name, value.parse().unwrap()));
    }
    let instance = Arc::clone(&link.instance);
    let opened = tokio::time::timeout(FOREVER, tokio_tungstenite::client_async(request, link.wire())).await;
    let refused = match opened.expect("the service answers a handshake in time") {
        Ok((messages, _)) => {
            assert!(!is_wrong, "a stream with a wrong owner token is open");
            client.note(&format!("opens a stream in {format:?}"));
            return Some(Socket {
                messages,
                instance,
                format,
                has_ended: false,
                last_sent: Instant::now(),
                longest_silence: Duration::ZERO,
            });
        }
        Err(Error::Http(refused)) => refused.status().as_u16(),
        Err(error) => {
            let is_excused = !instance.is_serving() || client.world.plan.config.max_connections < 100;
            assert!(is_excused, "the handshake fails: {error}");
            return None;
        }
    };
    client.note(&format!("no stream: {refused}"));
    match refused {
        404 => {
            assert!(client.world.oracle().may_be_gone(&session, instance.number), "the session is open");
            pilot.forget();
        }
        403 => assert!(is_wrong, "the owner token is right"),
        503 => assert!(client.world.oracle().has_paused || client.world.plan.config.max_connections < 100),
        status => panic!("no stream, status {status}"),
    }
    None
}

async fn drive(client: &mut Client, pilot: &mut Pilot, mut socket: Socket) {
    for _ in 0..client.random.from(2, 12) {
        let is_open = match client.random.below(12) {
            0 => step(client, pilot, &mut socket, 2).await,
            1 => refused(client, pilot, &mut socket).await,
            2 if client.random.one_in(3) => return client.note("drops its stream"),
            3 if client.random.one_in(3) => {
                let silence = client.random.millis(100, 45_000);
                tokio::time::sleep(silence).await;
                true
            }
            4 if client.random.one_in(2) => {
                let state = pilot.wild_state(&mut client.random);
                send(client, &mut socket, &[pilot.step(&state)]).await.is_some()
            }
            _ => step(client, pilot, &mut socket, 1).await,
        };
        if !is_open {
            return;
        }
        client.pause(0, 8).await;
    }
    let _ = socket.messages.close(None).await;
}

/// Sends a measured state so many times. Returns whether the stream is still open.
async fn step(client: &mut Client, pilot: &mut Pilot, socket: &mut Socket, times: usize) -> bool {
    let measured = pilot.measure(client).await;
    let answers = send(client, socket, &vec![pilot.step(&measured.state); times]).await;
    match answers.as_ref().and_then(|answers| answers.first()) {
        Some(answer) => pilot.settle(client, &measured, answer),
        None => pilot.miss(),
    }
    answers.is_some() && pilot.session.is_some()
}

async fn refused(client: &mut Client, pilot: &mut Pilot, socket: &mut Socket) -> bool {
    let last = client.world.oracle().last_state(pilot.session.as_deref().unwrap_or_default());
    let Some(last) = last else { return step(client, pilot, socket, 1).await };
    let state = Arc::new(pilot.refused_state(&mut client.random, &last));
    let answers = send(client, socket, &[pilot.step(&state)]).await;
    if answers.as_ref().is_none_or(|answers| answers[0].status == 200) {
        pilot.catch_up(client);
    }
    answers.is_some()
}

/// Sends states, and returns their answers; `None`: the stream has ended.
async fn send(client: &mut Client, socket: &mut Socket, calls: &[Call]) -> Option<Vec<Answer>> {
    socket.longest_silence = socket.longest_silence.max(socket.last_sent.elapsed());
    socket.last_sent = Instant::now();
    let sent: Vec<Sent> = calls.iter().map(|call| post(client, socket, call)).collect();
    for call in calls {
        let Call::Step { state, .. } = call else { continue };
        let message = match socket.format {
            Format::Json => Message::text(serde_json::to_string(&**state).unwrap()),
            Format::MessagePack => Message::binary(Format::MessagePack.write(&**state)),
        };
        // A stream that has ended cannot be written to, but answers may still wait in it.
        let _ = tokio::time::timeout(FOREVER, socket.messages.send(message)).await.expect("the service reads in time");
    }
    let mut answers = Vec::new();
    for (call, sent) in calls.iter().zip(&sent) {
        let answer = if answers.len() < calls.len() { read(client, socket).await } else { None };
        let end = answer.as_ref().map_or(End::Lost, End::Answered);
        let judged = client.world.oracle().ended(call, socket.instance.number, sent, &end);
        if let Err(violation) = judged {
            panic!("{}: stream: {}: {violation}", client.name, call.text());
        }
        socket.has_ended |= answer.as_ref().is_some_and(|answer| answer.status == 404);
        answers.extend(answer);
    }
    (answers.len() == calls.len() && !socket.has_ended).then_some(answers)
}

fn post(client: &Client, socket: &Socket, call: &Call) -> Sent {
    client.note(&format!("→ stream: {}", call.text()));
    client.world.oracle().sent(call, socket.instance.number, &client.name)
}

/// Reads the next answer; `None`: the stream has ended, and it may have.
async fn read(client: &mut Client, socket: &mut Socket) -> Option<Answer> {
    loop {
        let message = tokio::time::timeout(FOREVER, socket.messages.next()).await.expect("the service answers a state");
        let bytes = match message {
            Some(Ok(Message::Text(text))) => text.as_bytes().to_vec(),
            Some(Ok(Message::Binary(bytes))) => bytes.to_vec(),
            Some(Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_))) => continue,
            Some(Ok(Message::Close(frame))) => {
                let code = frame.map(|frame| u16::from(frame.code));
                client.note(&format!("← close {code:?}"));
                check_close(client, socket, code);
                return None;
            }
            Some(Err(_)) | None => {
                let is_silent = socket.longest_silence > Duration::from_secs(20);
                let is_excused = socket.has_ended || is_silent || !socket.instance.is_serving();
                assert!(is_excused, "{}: the stream ends without a reason", client.name);
                return None;
            }
        };
        let answer = answer(socket.format, bytes);
        let hash = transcript::hash(&answer.body);
        client.note(&format!("← stream: {} {} {hash:016x}", answer.status, answer.problem()));
        return Some(answer);
    }
}

/// Returns a message as an HTTP answer. Only problems have a status.
fn answer(format: Format, body: Vec<u8>) -> Answer {
    let mut answer =
        Answer { status: 200, headers: vec![("content-type".to_owned(), format.media_type().to_owned())], body };
    if let Ok(problem) = answer.read::<wire::Problem>() {
        answer.status = problem.status;
    }
    answer
}

fn check_close(client: &Client, socket: &Socket, code: Option<u16>) {
    let is_right = match code {
        Some(1001) => !socket.instance.is_serving(),
        Some(4404) => socket.has_ended,
        Some(4408) => socket.longest_silence >= Duration::from_secs(20),
        _ => false,
    };
    assert!(is_right, "{}: the stream was closed with {code:?}", client.name);
}
