//! The form of requests: host, encodings, failed authentication.

use std::io::Write;

use revprio::service::ServiceConfig;

use crate::harness::{Service, example};

/// Sends a GET request with these header lines and returns the whole answer.
fn get(service: &Service, path: &str, headers: &str) -> String {
    service.raw(format!("GET {path} HTTP/1.1\r\n{headers}connection: close\r\n\r\n").as_bytes())
}

fn assert_problem(answer: &str, status: u16, kind: &str) {
    let is_refused = answer.starts_with(&format!("HTTP/1.1 {status} ")) && answer.contains("x-request-id: ");
    assert!(is_refused && answer.contains(&format!("\"type\":\"/problems/{kind}\"")), "not {kind}: {answer}");
}

#[test]
fn every_route_refuses_a_foreign_host() {
    let service = Service::start();
    let routes = [
        "/",
        "/docs",
        "/docs/",
        "/dashboard/main.js",
        "/healthz",
        "/readyz",
        "/metrics",
        "/openapi.json",
        "/asyncapi.json",
        "/v1/controllers",
        "/v1/controllers/1",
        "/v1/controllers/1/watch",
        "/v1/controllers/1/stream",
        "/v1/robots",
        "/v1/robots/panda",
        "/v1/scenarios",
        "/v1/simulations/1",
        "/v1/simulations/1/live",
        "/nothing",
        "/v1/resolve",
    ];
    for path in routes {
        assert_problem(&get(&service, path, "host: evil.example\r\n"), 403, "foreign-host");
        assert_problem(&get(&service, path, ""), 400, "bad-host");
        assert_problem(&get(&service, path, "host: localhost\r\nhost: localhost\r\n"), 400, "bad-host");
        assert_problem(&get(&service, path, "host: a b\r\n"), 400, "bad-host");
    }
    let preflight = "OPTIONS /v1/step HTTP/1.1\r\nhost: evil.example\r\norigin: http://evil.example\r\n\
                     access-control-request-method: POST\r\n\r\n";
    let config = ServiceConfig { allowed_origins: vec!["http://evil.example".to_owned()], ..ServiceConfig::default() };
    assert_problem(&Service::with(config).raw(preflight.as_bytes()), 403, "foreign-host");
}

#[test]
fn addresses_localhost_and_configured_names_are_accepted() {
    let config = ServiceConfig { allowed_hosts: vec!["cell-4.example".to_owned()], ..ServiceConfig::default() };
    let service = Service::with(config);
    let own = service.url().replace("http://", "");
    for host in [own.as_str(), "127.0.0.1", "[::1]:80", "localhost:9000", "LOCALHOST", "Cell-4.example:443"] {
        let answer = get(&service, "/v1/robots", &format!("host: {host}\r\n"));
        assert!(answer.starts_with("HTTP/1.1 200 "), "{host}: {answer}");
    }
    assert_problem(&get(&service, "/v1/robots", "host: cell-5.example\r\n"), 403, "foreign-host");
}

#[test]
fn a_refused_form_ends_the_connection() {
    let service = Service::start();
    // Without the end of the connection, the read would time out.
    let answer = service.raw(b"GET /healthz HTTP/1.1\r\nhost: evil.example\r\n\r\n");
    assert!(answer.contains("connection: close\r\n"), "{answer}");
}

#[test]
fn unknown_codings_are_refused() {
    let service = Service::start();
    let post = |headers: &str, body: &str| {
        let head =
            "POST /v1/resolve HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\ncontent-type: application/json";
        service.raw(format!("{head}\r\n{headers}\r\n{body}").as_bytes())
    };
    for coding in ["gzip, chunked", "deflate,chunked", "identity, chunked", "chunked, chunked"] {
        let answer = post(&format!("transfer-encoding: {coding}\r\n"), "0\r\n\r\n");
        assert_problem(&answer, 501, "transfer-encoding");
    }
    assert_problem(
        &post("transfer-encoding: gzip\r\ntransfer-encoding: chunked\r\n", "0\r\n\r\n"),
        501,
        "transfer-encoding",
    );
    // RFC 9112, section 6.3: the end of such a body cannot be found.
    for coding in ["gzip", "identity", "chunked, gzip"] {
        let answer = post(&format!("transfer-encoding: {coding}\r\n"), "0\r\n\r\n");
        assert!(answer.starts_with("HTTP/1.1 400 "), "{coding}: {answer}");
    }
    let body = example("resolve.json").to_string();
    let length = format!("content-length: {}\r\n", body.len());
    for coding in ["gzip", "br", "zstd", "identity, gzip", ""] {
        let answer = post(&format!("{length}content-encoding: {coding}\r\n"), &body);
        assert_problem(&answer, 415, "content-encoding");
    }
    assert!(post(&format!("{length}content-encoding: identity\r\n"), &body).starts_with("HTTP/1.1 200 "));
    let chunk = format!("{:x}\r\n{body}\r\n0\r\n\r\n", body.len());
    assert!(post("transfer-encoding: Chunked\r\n", &chunk).starts_with("HTTP/1.1 200 "));
}

#[test]
fn many_wrong_tokens_get_429_and_the_right_token_is_always_accepted() {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("failures_token");
    std::fs::File::create(&path).unwrap().write_all(b"s3cret-word").unwrap();
    let token = Some(revprio::service::Token::read(&path).unwrap());
    let service = Service::with(ServiceConfig { token, ..ServiceConfig::default() });
    let status = |token: &str| service.send("GET", "/v1/robots", &[("authorization", token)], "").status;
    let statuses: Vec<u16> = (0..200).map(|_| status("Bearer wrong")).collect();
    assert!(statuses.iter().all(|status| [401, 429].contains(status)), "{statuses:?}");
    assert!(statuses[..30].iter().all(|status| *status == 401) && statuses.contains(&429), "{statuses:?}");
    assert_eq!(status("Bearer s3cret-word"), 200);
    let refused = (0..5).map(|_| service.get("/v1/robots")).find(|answer| answer.status == 429).unwrap();
    assert_eq!(refused.header("retry-after"), Some("1"));
}
