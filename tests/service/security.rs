//! Access: tokens, origins and certificates.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use revprio::service::{AppState, Robots, ServiceConfig, Tls, Token, router, serve};
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use tungstenite::HandshakeError;
use tungstenite::client::IntoClientRequest;

use crate::harness::{Service, example};

/// Writes a file for one test.
fn file(name: &str, text: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn token(name: &str) -> Token {
    Token::read(&file(name, "  s3cret-word\n")).unwrap()
}

#[test]
fn without_the_token_only_probes_are_answered() {
    let service = Service::with(ServiceConfig { token: Some(token("token")), ..ServiceConfig::default() });
    let body = example("resolve.json").to_string();
    let resolve = |authorization: &str| {
        let headers = [("content-type", "application/json"), ("authorization", authorization)];
        service.send("POST", "/v1/resolve", &headers, &body)
    };
    resolve("Bearer s3cret-word").accepted();
    resolve("bearer s3cret-word").accepted();
    for wrong in ["Bearer s3cret-wor", "Bearer s3cret-wordd", "Bearer S3cret-word", "Bearer", "Basic s3cret-word", ""] {
        let answer = resolve(wrong);
        answer.assert_refused(401, None);
        assert_eq!(answer.header("www-authenticate"), Some("Bearer"), "{wrong}");
        assert!(!answer.text.contains("s3cret"), "{}", answer.text);
    }
    // The page is public, because a browser that opens it cannot send the token. Its later requests need the token.
    assert_eq!(service.get("/").status, 200);
    for path in ["/docs/", "/dashboard", "/v1/robots", "/v1/nothing", "/metrics", "/v1/resolve"] {
        service.get(path).assert_refused(401, None);
    }
    for path in ["/healthz", "/readyz"] {
        assert_eq!(service.get(path).status, 200, "{path}");
    }
}

#[test]
fn streams_need_the_token_and_an_allowed_origin() {
    let service = Service::with(ServiceConfig { token: Some(token("stream_token")), ..ServiceConfig::default() });
    let bearer = ("authorization", "Bearer s3cret-word");
    let json = ("content-type", "application/json");
    let body = example("controller.json").to_string();
    let session = service.send("POST", "/v1/controllers", &[bearer, json], &body).location.unwrap();
    let open = |headers: &[(&'static str, &str)]| {
        let mut request = (service.url().replace("http", "ws") + &session + "/stream").into_client_request().unwrap();
        for &(name, value) in headers {
            request.headers_mut().insert(name, value.parse().unwrap());
        }
        match tungstenite::client(request, service.connect()) {
            Ok((_, answer)) => answer.status().as_u16(),
            Err(HandshakeError::Failure(tungstenite::Error::Http(answer))) => answer.status().as_u16(),
            Err(other) => panic!("{other:?}"),
        }
    };
    assert_eq!(open(&[bearer]), 101);
    assert_eq!(open(&[]), 401);
    assert_eq!(open(&[bearer, ("origin", "https://evil.example")]), 403);
    service.get(&format!("{session}/watch")).assert_refused(401, None);
}

#[test]
fn a_token_is_one_word_and_never_printed() {
    let refusal = |name: &str, text: &str| Token::read(&file(name, text)).unwrap_err().to_string();
    assert!(refusal("empty_token", " \n").contains("is empty"));
    assert!(refusal("two_words", "one two").contains("more than one word"));
    assert!(Token::read(&PathBuf::from("no_such_token")).unwrap_err().to_string().contains("no_such_token"));
    assert!(!format!("{:?}", token("debug_token")).contains("s3cret"));
}

#[test]
fn an_address_that_others_can_reach_needs_a_token() {
    let listen = || TcpListener::bind("0.0.0.0:0").unwrap();
    let open = router(AppState::new(Robots::built_in()));
    let refused = serve(listen(), open, std::future::ready(())).unwrap_err().to_string();
    assert!(refused.contains("0.0.0.0") && refused.contains("--token-file"), "{refused}");
    let config = ServiceConfig { token: Some(token("address_token")), ..ServiceConfig::default() };
    serve(listen(), router(AppState::with_config(Robots::built_in(), config)), std::future::ready(())).unwrap();
    let mapped: SocketAddr = "[::ffff:127.0.0.1]:80".parse().unwrap();
    assert!(ServiceConfig::default().check(mapped).is_ok());
}

/// Returns the status of a request from a page of this origin to this host name.
fn status_from_page(service: &Service, origin: &str, host: &str) -> u16 {
    service.send("GET", "/v1/robots", &[("origin", origin), ("host", host)], "").status
}

#[test]
fn a_foreign_web_page_cannot_call() {
    let service = Service::start();
    let own = service.url();
    let authority = own.trim_start_matches("http://");
    assert_eq!(status_from_page(&service, &own, authority), 200);
    assert_eq!(status_from_page(&service, "http://localhost:8080", "localhost:8080"), 200);
    for foreign in ["https://evil.example", "http://127.0.0.1", "http://127.0.0.1:1", "null", ""] {
        assert_eq!(status_from_page(&service, foreign, authority), 403, "{foreign}");
    }
    // A foreign host name that resolves to this machine.
    assert_eq!(status_from_page(&service, "http://evil.example:8080", "evil.example:8080"), 403);
    let answer = service.send("GET", "/v1/robots", &[("origin", "https://evil.example")], "");
    answer.assert_refused(403, None);
    assert!(answer.header("access-control-allow-origin").is_none());
}

#[test]
fn an_allowed_page_can_call_and_read_answers() {
    let page = "https://panel.example";
    let config = ServiceConfig { allowed_origins: vec![page.to_owned()], ..ServiceConfig::default() };
    let service = Service::with(config);
    let headers = [("origin", page), ("access-control-request-method", "POST")];
    let preflight = service.send("OPTIONS", "/v1/step", &headers, "");
    assert_eq!((preflight.status, preflight.header("access-control-allow-origin")), (200, Some(page)));
    assert!(preflight.header("access-control-allow-headers").unwrap().contains("authorization"));
    let methods = preflight.header("access-control-allow-methods").unwrap();
    assert!(["GET", "POST", "PUT", "DELETE"].iter().all(|method| methods.contains(method)), "{methods}");
    let answer = service.send("GET", "/v1/robots", &[("origin", page)], "");
    assert_eq!((answer.status, answer.header("access-control-allow-origin")), (200, Some(page)));
    let other = service.send("GET", "/v1/robots", &[("origin", "https://evil.example")], "");
    assert_eq!((other.status, other.header("access-control-allow-origin")), (403, None));
}

#[test]
fn with_certificate_and_key_the_service_uses_https() {
    let pair = rcgen::generate_simple_self_signed(vec!["localhost".to_owned()]).unwrap();
    let cert = file("cert.pem", &pair.cert.pem());
    let tls = Tls::read(&cert, &file("key.pem", &pair.signing_key.serialize_pem())).unwrap();
    let timeout = Duration::from_millis(300);
    let config = ServiceConfig { tls: Some(tls), handshake_timeout: timeout, ..ServiceConfig::default() };
    let service = Service::with(config);
    assert!(service.url().starts_with("https://"));
    let connect = || TcpStream::connect(service.url().trim_start_matches("https://")).unwrap();

    let mut silent = connect();
    let mut encrypted = encrypted(connect(), pair.cert.der());
    encrypted.write_all(b"GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    encrypted.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 200 OK\r\n") && answer.ends_with("\r\n\r\nok"), "{answer}");

    let mut nothing = Vec::new();
    assert_eq!(silent.read_to_end(&mut nothing).unwrap_or(0), 0, "a client without a handshake is still connected");
}

fn encrypted(stream: TcpStream, certificate: &CertificateDer<'static>) -> StreamOwned<ClientConnection, TcpStream> {
    let mut roots = RootCertStore::empty();
    roots.add(certificate.clone()).unwrap();
    let config = ClientConfig::builder().with_root_certificates(roots).with_no_client_auth();
    let name = ServerName::try_from("localhost").unwrap();
    StreamOwned::new(ClientConnection::new(Arc::new(config), name).unwrap(), stream)
}

#[test]
fn errors_of_certificates_and_keys_name_the_file() {
    let pair = || rcgen::generate_simple_self_signed(vec!["localhost".to_owned()]).unwrap();
    let (one, other) = (pair(), pair());
    let cert = file("one_cert.pem", &one.cert.pem());
    let key = file("other_key.pem", &other.signing_key.serialize_pem());
    let nothing = file("nothing.pem", "");
    let refusal = |cert: &PathBuf, key: &PathBuf| Tls::read(cert, key).unwrap_err().to_string();
    assert!(refusal(&nothing, &key).contains("nothing.pem"));
    assert!(refusal(&cert, &nothing).contains("nothing.pem"));
    assert!(refusal(&cert, &PathBuf::from("no_such.pem")).contains("no_such.pem"));
    assert!(refusal(&cert, &key).contains("other_key.pem"), "a key of another certificate is accepted");
}
