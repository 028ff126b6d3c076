//! A client that sends what is no request, sends slowly, does not read, or opens many connections.

use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};

use crate::call::Call;
use crate::exchange::Client;

/// Longer than every timeout of the service.
const FOREVER: Duration = Duration::from_mins(2);

pub async fn run(client: &mut Client) {
    client.pause(0, 60).await;
    for _ in 0..client.random.from(1, 4) {
        match client.random.below(5) {
            0 => garbage(client).await,
            1 => slow(client).await,
            2 => crowd(client).await,
            3 => watch(client).await,
            _ => wrong_requests(client).await,
        }
        client.pause(0, 50).await;
    }
}

/// Requests that the gate refuses.
async fn wrong_requests(client: &mut Client) {
    let other = |method, path, host, status| Call::Other { method, path, host, status };
    let call = client.random.pick(&[
        other("GET", "/v1/nothing", "localhost", 404),
        other("DELETE", "/healthz", "localhost", 405),
        other("GET", "/healthz", "evil.example", 403),
        other("GET", "/healthz", "", 400),
        other("GET", "/healthz", "127.0.0.1:8080", 200),
    ]);
    client.call(&mut None, call).await;
}

/// Bytes that are not HTTP: the service answers with 400 or closes the connection, and does not wait.
async fn garbage(client: &mut Client) {
    let Ok(mut wire) = client.world.instance().port.connect(1024) else { return };
    let bytes: Vec<u8> = (0..client.random.from(1, 300)).map(|_| client.random.byte()).collect();
    let _ = wire.write_all(&bytes).await;
    let _ = wire.shutdown().await;
    let mut answer = Vec::new();
    let end = tokio::time::timeout(FOREVER, wire.read_to_end(&mut answer)).await;
    assert!(end.is_ok(), "the service waits for ever");
    assert!(
        answer.is_empty() || answer.starts_with(b"HTTP/1.1 4") || answer.starts_with(b"HTTP/1.1 503"),
        "{answer:?}"
    );
    client.note(&format!("garbage: {} bytes of answer", answer.len()));
}

/// The beginning of a request: the service closes the connection after a while.
async fn slow(client: &mut Client) {
    let Ok(mut wire) = client.world.instance().port.connect(1024) else { return };
    let whole =
        "POST /v1/step HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\ncontent-length: 9\r\n\r\n{";
    let part = &whole[..client.random.below(whole.len())];
    let _ = wire.write_all(part.as_bytes()).await;
    let end = tokio::time::timeout(FOREVER, wire.read_to_end(&mut Vec::new())).await;
    assert!(end.is_ok(), "the service waits for ever for the rest of {part:?}");
    client.note("slow: closed");
}

/// Connections without a request.
async fn crowd(client: &mut Client) {
    let count = client.random.from(2, 12);
    let links: Vec<_> = (0..count).filter_map(|_| client.connect()).collect();
    client.note(&format!("crowd of {}", links.len()));
    client.pause(0, 100).await;
}

/// A watcher that hardly reads.
async fn watch(client: &mut Client) {
    let instance = client.world.instance();
    let sessions = client.world.oracle().known(instance.number);
    if sessions.is_empty() {
        return;
    }
    let session = client.random.pick(&sessions);
    let Ok(mut wire) = instance.port.connect(256) else { return };
    let authorization = format!("authorization: Bearer {}\r\n", crate::plan::TOKEN);
    let head = format!("GET /v1/controllers/{session}/watch HTTP/1.1\r\nhost: localhost\r\n{authorization}\r\n");
    let _ = wire.write_all(head.as_bytes()).await;
    client.note("watches");
    let mut some = [0; 100];
    let length = wire.read(&mut some).await.unwrap_or(0);
    assert!(some[..length].is_empty() || some.starts_with(b"HTTP/1.1 "), "{some:?}");
    client.pause(0, 15_000).await;
}
