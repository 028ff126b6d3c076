//! A service on its own port, and a client for it.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;

use revprio::service::{
    AppState, JobQueue, OperatingSystem, Platform, Robots, RunningServer, ServiceConfig, WorkKind, router,
};
use serde_json::Value;
use ureq::http::{HeaderMap, Request, Response};
use ureq::{Agent, Body};

/// Longer than every timeout of the service. A test therefore ends even if the service does not answer.
const TIMEOUT: Duration = Duration::from_mins(1);

/// How long a service of [`Service::with_long_drain`] waits for connections that do not end: longer than any test.
pub const LONG_DRAIN: Duration = Duration::from_mins(2);

/// The operating system, but long work has the priority of the tests beside it. Otherwise they would leave it no time on
/// a busy machine.
struct EqualPriority;

impl Platform for EqualPriority {
    fn random_bytes(&self) -> [u8; 16] {
        OperatingSystem.random_bytes()
    }

    fn start_workers(&self, kind: WorkKind) -> JobQueue {
        OperatingSystem.start_workers(WorkKind { low_priority: false, ..kind })
    }
}

/// A running service and a client that keeps its connection.
pub struct Service {
    server: RunningServer,
    agent: Agent,
}

/// The parts of an answer that the tests check.
pub struct Answer {
    pub status: u16,
    pub media_type: String,
    pub location: Option<String>,
    pub allow: Option<String>,
    pub text: String,
    pub headers: HeaderMap,
}

impl Service {
    pub fn start() -> Self {
        Self::with(ServiceConfig::default())
    }

    /// Starts a service that is seen to wait for connections, without a clock that a slow machine misses.
    pub fn with_long_drain() -> Self {
        Self::with(ServiceConfig { drain_timeout: LONG_DRAIN, ..ServiceConfig::default() })
    }

    pub fn with(config: ServiceConfig) -> Self {
        let built = Agent::config_builder().http_status_as_error(false).timeout_global(Some(TIMEOUT)).build();
        let platform: Arc<dyn Platform> = Arc::new(EqualPriority);
        let state = AppState::on_platform(Robots::built_in(), config, &platform);
        Self { server: RunningServer::start(router(state)).unwrap(), agent: built.into() }
    }

    /// Sends a request with any method, headers and a body that may be empty.
    pub fn send(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> Answer {
        let mut request = Request::builder().method(method).uri(self.url() + path);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        Answer::of(self.agent.run(request.body(body.to_owned()).unwrap()).unwrap())
    }

    pub fn url(&self) -> String {
        self.server.url()
    }

    pub fn get(&self, path: &str) -> Answer {
        Answer::of(self.agent.get(self.url() + path).call().unwrap())
    }

    pub fn delete(&self, path: &str) -> Answer {
        Answer::of(self.agent.delete(self.url() + path).call().unwrap())
    }

    pub fn post(&self, path: &str, body: &str) -> Answer {
        self.post_as(path, "application/json", body)
    }

    pub fn post_as(&self, path: &str, media_type: &str, body: &str) -> Answer {
        let request = self.agent.post(self.url() + path).header("content-type", media_type);
        Answer::of(request.send(body).unwrap())
    }

    /// Sends a request and returns the answer byte for byte.
    pub fn exchange(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Response<Vec<u8>> {
        let mut request = ureq::http::Request::builder().method(method).uri(self.url() + path);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let answer = match method {
            "GET" => self.agent.run(request.body(()).unwrap()),
            _ => self.agent.run(request.body(body).unwrap()),
        };
        answer.unwrap().map(|body| body.into_with_config().limit(100 << 20).read_to_vec().unwrap())
    }

    /// Posts a body that must be accepted, and returns the answer.
    pub fn call(&self, path: &str, body: &Value) -> Value {
        self.post(path, &body.to_string()).accepted()
    }

    /// Opens a session and returns its path.
    pub fn open(&self, controller: &Value) -> String {
        let answer = self.post("/v1/controllers", &controller.to_string());
        assert_eq!(answer.status, 201, "{}", answer.text);
        answer.location.unwrap()
    }

    /// Opens a TCP connection.
    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.url().trim_start_matches("http://")).unwrap();
        stream.set_read_timeout(Some(TIMEOUT)).unwrap();
        stream
    }

    /// Sends bytes and returns all that comes back until the service closes the connection.
    pub fn raw(&self, bytes: &[u8]) -> String {
        String::from_utf8(self.raw_bytes(bytes)).unwrap()
    }

    pub fn raw_bytes(&self, bytes: &[u8]) -> Vec<u8> {
        let mut stream = self.connect();
        stream.write_all(bytes).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        answer
    }

    pub fn assert_alive(&self) {
        let answer = self.get("/healthz");
        assert_eq!((answer.status, answer.text.as_str()), (200, "ok"));
    }
}

impl Answer {
    fn of(mut response: Response<Body>) -> Self {
        let header = |name: &str| response.headers().get(name).map(|value| value.to_str().unwrap().to_owned());
        let (media_type, location, allow) = (header("content-type"), header("location"), header("allow"));
        Self {
            status: response.status().as_u16(),
            media_type: media_type.unwrap_or_default(),
            location,
            allow,
            headers: response.headers().clone(),
            text: response.body_mut().read_to_string().unwrap(),
        }
    }

    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.get(name).map(|value| value.to_str().unwrap())
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.text).unwrap()
    }

    /// Returns the body of an answer that must be a success.
    pub fn accepted(&self) -> Value {
        assert!((200..300).contains(&self.status), "{}: {}", self.status, self.text);
        assert_eq!(self.media_type, "application/json");
        self.json()
    }

    /// Returns how this answer differs from a problem with this status and JSON pointer; `None` if it does not.
    pub fn refusal_difference(&self, status: u16, pointer: Option<&str>) -> Option<String> {
        if self.status != status || self.media_type != "application/problem+json" {
            return Some(format!("{} {}, not {status}: {}", self.status, self.media_type, self.text));
        }
        let problem = self.json();
        let text = |field: &str| problem[field].as_str().is_some_and(|text| !text.is_empty());
        let whole = text("title") && text("detail") && problem["type"].as_str()?.starts_with("/problems/");
        let right = problem["status"] == status && problem.get("pointer").and_then(Value::as_str) == pointer;
        (!(whole && right)).then(|| format!("not at {pointer:?}: {problem}"))
    }

    /// Asserts that this answer is a problem with this status and JSON pointer.
    pub fn assert_refused(&self, status: u16, pointer: Option<&str>) {
        assert_eq!(self.refusal_difference(status, pointer), None);
    }
}

/// Reads a file of `api/examples`.
pub fn example(name: &str) -> Value {
    let path = format!("{}/api/examples/{name}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Removes fields from an object.
pub fn without(mut answer: Value, fields: &[&str]) -> Value {
    for field in fields {
        answer.as_object_mut().unwrap().remove(*field);
    }
    answer
}

/// Converts a JSON list to numbers.
pub fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}
