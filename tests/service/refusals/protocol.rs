//! Errors before the fields: text, media type, size, route, method.

use std::io::{Read, Write};

use super::changed;
use crate::harness::{Answer, Service, example};

#[test]
fn text_that_is_not_json_is_refused() {
    let service = Service::start();
    let good = example("resolve.json").to_string();
    for text in [
        "",
        " ",
        "{",
        "}",
        "hello",
        "\u{feff}{}",
        "{'robot': 1}",
        r#"{"robot": "\ud800"}"#,
        "{\"robot\": \"sawyer_dh\",}",
    ] {
        service.post("/v1/resolve", text).assert_refused(400, None);
    }
    for end in (1..good.len()).step_by(17) {
        service.post("/v1/resolve", &good[..end]).assert_refused(400, None);
    }
    for more in ["x", "{}", ",", "]"] {
        service.post("/v1/resolve", &(good.clone() + more)).assert_refused(400, None);
    }
    service.assert_alive();
}

#[test]
fn deep_nesting_is_refused() {
    let service = Service::start();
    let deep = |at: &str| service.post("/v1/resolve", &changed(&example("resolve.json"), at, &"[".repeat(100_000)));
    deep("/tasks").assert_refused(422, Some("/tasks/0"));
    deep("/joint_position").assert_refused(422, Some("/joint_position/0"));
    deep("/bogus").assert_refused(422, Some("/bogus"));
    service.post("/v1/resolve", &"[".repeat(100_000)).assert_refused(422, Some(""));
    service.post("/v1/resolve", &"{\"tasks\":[".repeat(50_000)).assert_refused(422, Some("/tasks/0/tasks"));
}

#[test]
fn json_that_is_not_an_object_is_refused() {
    let service = Service::start();
    for text in ["null", "[]", "3", "\"resolve\"", "true"] {
        for path in ["/v1/resolve", "/v1/step", "/v1/controllers"] {
            service.post(path, text).assert_refused(422, Some(""));
        }
    }
}

#[test]
fn a_repeated_field_is_refused() {
    let service = Service::start();
    let twice = |at: &str, text: &str| service.post("/v1/resolve", &changed(&example("resolve.json"), at, text));
    twice("/method", r#""reverse_priority", "method": "pseudoinverse""#).assert_refused(422, Some(""));
    twice("/robot", r#""sawyer_dh", "robot": "sawyer_dh""#).assert_refused(422, Some(""));
    twice("/tasks/0/name", r#""a", "name": "b""#).assert_refused(422, Some("/tasks/0"));
    twice("/limits/upper", r#"[1, 1, 1, 1, 1, 1, 1], "upper": [1]"#).assert_refused(422, Some("/limits"));
}

#[test]
fn other_media_types_are_refused() {
    let service = Service::start();
    let body = example("resolve.json").to_string();
    for media_type in ["text/plain", "application/x-www-form-urlencoded", "application/jsonp", "", "json"] {
        service.post_as("/v1/resolve", media_type, &body).assert_refused(415, None);
    }
    for media_type in ["application/json", "application/json; charset=utf-8", "Application/JSON"] {
        service.post_as("/v1/resolve", media_type, &body).accepted();
    }
    assert!(
        service
            .raw(b"POST /v1/step HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\ncontent-length: 0\r\n\r\n")
            .starts_with("HTTP/1.1 415 ")
    );
}

#[test]
fn the_maximum_body_is_accepted_and_one_byte_more_is_refused() {
    let service = Service::start();
    let padded = |size: usize| {
        let body = example("resolve.json").to_string();
        body.clone() + &" ".repeat(size - body.len())
    };
    service.post("/v1/resolve", &padded(4 << 20)).accepted();
    for too_large in [(4 << 20) + 1, 5 << 20, 12 << 20] {
        service.post("/v1/resolve", &padded(too_large)).assert_refused(413, None);
    }
    service.assert_alive();
}

#[test]
fn an_endless_body_is_refused() {
    let service = Service::start();
    let mut stream = service.connect();
    let head = "POST /v1/step HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\ntransfer-encoding: chunked\r\n\r\n";
    stream.write_all(head.as_bytes()).unwrap();
    let chunk = format!("10000\r\n{}\r\n", " ".repeat(1 << 16));
    for _ in 0..305 {
        stream.write_all(chunk.as_bytes()).unwrap();
    }
    let mut answer = [0; 12];
    stream.read_exact(&mut answer).unwrap();
    assert_eq!(&answer, b"HTTP/1.1 413");
}

#[test]
fn a_body_of_thousands_of_joints_is_refused_at_once() {
    let service = Service::start();
    let names: Vec<String> = (0..80_000).map(|i| format!(r#""{i:x}":0"#)).collect();
    let body = changed(&example("state.json"), "/joint_position", &format!("{{{}}}", names.join(",")));
    let address = format!("{}/step", service.open(&example("controller.json")));
    service.post(&address, &body).assert_refused(422, Some("/joint_position/0"));
}

#[test]
fn unknown_routes_and_methods_are_refused() {
    let service = Service::start();
    for path in ["/v1", "/v1/resolve/", "/v2/resolve", "/v1/robots/", "/v1/robots/a/b", "/healthz/x", "/%00", "//"] {
        service.get(path).assert_refused(404, None);
    }
    for path in ["/v1/robots/%ff", "/v1/controllers/%ff", "/v1/controllers/%00", "/v1/controllers/1"] {
        service.get(path).assert_refused(404, None);
    }
    service.post("/v1/controllers/%ff/step", &example("state.json").to_string()).assert_refused(404, None);
    let allows = |answer: Answer, methods: &str| {
        answer.assert_refused(405, None);
        assert_eq!(answer.allow.as_deref(), Some(methods));
    };
    allows(service.get("/v1/resolve"), "POST");
    allows(service.get("/v1/step"), "POST");
    allows(service.delete("/v1/robots"), "GET,HEAD,POST");
    allows(service.post("/healthz", "{}"), "GET,HEAD");
}

#[test]
fn bytes_that_are_not_http_are_refused() {
    let service = Service::start();
    for bytes in ["\r\n\r\nhello\r\n\r\n", "GET / HTTP/9.9\r\n\r\n", "GET /\u{1} HTTP/1.1\r\n\r\n", "\u{16}\u{3}\u{1}"]
    {
        let answer = service.raw(bytes.as_bytes());
        assert!(answer.starts_with("HTTP/1.1 400 ") || answer.is_empty(), "{answer}");
    }
    service.assert_alive();
}
