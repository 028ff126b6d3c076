//! Batches: many problems in one request.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::harness::{Service, example, without};

/// Returns different problems, every tenth one wrong.
fn items(count: usize) -> Vec<Value> {
    let item = |i: usize| {
        let mut item = example("resolve.json");
        item["tasks"][0]["velocity"][0] = json!(0.001 * i as f64);
        item["solver"] = json!(["auto", "qp", "closed_form"][i % 3]);
        if i % 10 == 7 {
            item["joint_position"] = json!([0.0]);
        }
        item
    };
    (0..count).map(item).collect()
}

fn gunzipped(bytes: &[u8]) -> Vec<u8> {
    let mut plain = Vec::new();
    flate2::read::GzDecoder::new(bytes).read_to_end(&mut plain).unwrap();
    plain
}

#[test]
fn a_batch_is_answered_in_order_like_single_problems() {
    let service = Service::start();
    let items = items(60);
    let answer = service.call("/v1/resolve/batch", &json!({"items": items}));
    let answers = answer["items"].as_array().unwrap();
    assert_eq!(answers.len(), 60);
    for (i, (item, answer)) in items.iter().zip(answers).enumerate() {
        let mut single = service.post("/v1/resolve", &item.to_string()).json();
        if i % 10 == 7 {
            assert_eq!(answer["status"], 422);
            assert_eq!(answer["pointer"], format!("/items/{i}/joint_position"));
            single["pointer"] = answer["pointer"].clone();
            assert_eq!(*answer, without(single, &["request_id"]));
        } else {
            assert_eq!(without(answer.clone(), &["elapsed_us"]), without(single, &["elapsed_us"]));
        }
    }
}

#[test]
fn the_example_is_resolved() {
    let answer = Service::start().call("/v1/resolve/batch", &example("batch.json"));
    assert_eq!(answer["items"][0]["tasks"][0]["name"], "push");
    assert_eq!(answer["items"][1]["solver"]["status"], "optimal");
    assert_eq!(answer["items"][1]["joint_velocity"].as_array().unwrap().len(), 3);
}

#[test]
fn a_batch_may_be_empty_and_has_a_maximum_size() {
    let service = Service::start();
    assert_eq!(service.call("/v1/resolve/batch", &json!({"items": []})), json!({"items": []}));
    let small = json!({"tasks": [{"jacobian": [[1]], "velocity": [1]}]});
    let many = |count: usize| service.post("/v1/resolve/batch", &json!({"items": vec![&small; count]}).to_string());
    assert_eq!(many(10_000).accepted()["items"].as_array().unwrap().len(), 10_000);
    many(10_001).assert_refused(422, Some("/items"));
}

#[test]
fn batches_of_the_wrong_shape_are_refused_as_a_whole() {
    let service = Service::start();
    let batch = |text: &str| service.post("/v1/resolve/batch", text);
    let mut broken = example("batch.json");
    broken["items"][1]["taks"] = json!([]);
    batch(&broken.to_string()).assert_refused(422, Some("/items/1/taks"));
    batch(r#"{"items": [[]]}"#).assert_refused(422, Some("/items/0"));
    batch(r#"{"item": []}"#).assert_refused(422, Some("/item"));
    batch("{}").assert_refused(422, Some(""));
    batch("{").assert_refused(400, None);
    let padded = |size: usize| {
        let body = example("batch.json").to_string();
        body.clone() + &" ".repeat(size - body.len())
    };
    batch(&padded(16 << 20)).accepted();
    batch(&padded((16 << 20) + 1)).assert_refused(413, None);
}

#[test]
fn only_large_answers_are_compressed_and_only_if_accepted() {
    let service = Service::start();
    let post = |path: &str, body: &Value| {
        let headers = [("content-type", "application/json"), ("accept-encoding", "gzip, br")];
        service.exchange("POST", path, &headers, body.to_string().as_bytes())
    };
    let body = json!({"items": items(50)});
    let large = post("/v1/resolve/batch", &body);
    assert_eq!(large.headers()["content-encoding"], "gzip");
    let answer: Value = serde_json::from_slice(&gunzipped(large.body())).unwrap();
    assert_eq!(answer["items"].as_array().unwrap().len(), 50);
    for (path, body) in [("/v1/resolve/batch", example("batch.json")), ("/v1/resolve", example("resolve.json"))] {
        let small = post(path, &body);
        assert!(!small.headers().contains_key("content-encoding"));
        assert!(serde_json::from_slice::<Value>(small.body()).is_ok());
    }
}

/// Problems of a batch that takes far longer than the test.
const MANY: usize = 4000;

/// Returns a batch of slow problems. Clarabel needs some milliseconds for each.
fn slow_batch(problems: usize) -> String {
    let row = |i: usize| (0..30).map(|j| (i * 7 + j * 3) % 10).collect::<Vec<_>>();
    let task = |k: usize| json!({"jacobian": (0..6).map(|i| row(6 * k + i)).collect::<Vec<_>>(), "velocity": [9, 8, 7, 6, 5, 4]});
    let limits = json!({"lower": vec![-0.1; 30], "upper": vec![0.1; 30]});
    let tasks: Vec<Value> = (0..8).map(task).collect();
    json!({"items": vec![json!({"tasks": tasks, "limits": limits, "solver": "qp"}); problems]}).to_string()
}

/// Sends a batch without waiting for its answer.
fn send(service: &Service, body: &str) -> TcpStream {
    let mut stream = service.connect();
    let head = "POST /v1/resolve/batch HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json";
    write!(stream, "{head}\r\ncontent-length: {}\r\n\r\n{body}", body.len()).unwrap();
    stream
}

#[test]
fn steps_continue_while_a_batch_is_resolved() {
    let service = Service::start();
    let mut batch = send(&service, &slow_batch(MANY));
    let session = service.open(&example("controller.json"));
    for sequence in 0..200 {
        let mut state = example("state.json");
        state["sequence"] = json!(sequence);
        service.call(&format!("{session}/step"), &state);
    }
    batch.set_nonblocking(true).unwrap();
    let answer = batch.read(&mut [0; 1]).map_err(|error| error.kind());
    assert_eq!(answer, Err(ErrorKind::WouldBlock), "the batch was answered before the steps");
}

/// Returns the beginning of an answer; `None` if there is none in time.
fn answered(client: &mut TcpStream, time: Duration) -> Option<String> {
    client.set_read_timeout(Some(time)).unwrap();
    let mut begin = [0; 2048];
    let length = client.read(&mut begin).ok().filter(|length| *length > 0)?;
    Some(String::from_utf8_lossy(&begin[..length]).into_owned())
}

#[test]
fn too_many_batches_are_refused_and_abandoned_ones_free_their_place() {
    let service = Service::start();
    let (body, soon) = (slow_batch(MANY), Duration::from_millis(200));
    let mut clients: Vec<TcpStream> = (0..4).map(|_| send(&service, &body)).collect();
    // Until the service has read all four batches, a fifth may be admitted. It then waits and times out. On a busy machine
    // the service may refuse one of the four as overload. The loop sends it again.
    let refusal = loop {
        for client in &mut clients {
            if answered(client, soon).is_some() {
                *client = send(&service, &body);
            }
        }
        match answered(&mut send(&service, &example("batch.json").to_string()), soon) {
            Some(answer) if answer.contains("/problems/busy") => break answer,
            _ => sleep(Duration::from_millis(20)),
        }
    };
    let head = refusal.to_ascii_lowercase();
    assert!(head.starts_with("http/1.1 503") && head.contains("retry-after: 1\r\n"), "{refusal}");
    drop(clients);
    let until_answered = |body: &str| {
        let (start, long) = (Instant::now(), Duration::from_mins(1));
        while !answered(&mut send(&service, body), long).is_some_and(|answer| answer.starts_with("HTTP/1.1 200")) {
            sleep(Duration::from_millis(20));
        }
        start.elapsed()
    };
    let waited = until_answered(&example("batch.json").to_string());
    // A hundredth of an abandoned batch, on the same machine at the same time.
    let part = until_answered(&slow_batch(MANY / 100));
    assert!(waited < 50 * part, "an abandoned batch was resolved first: {waited:?}, a hundredth of it takes {part:?}");
}
