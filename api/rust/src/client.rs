//! A typed, blocking client of the service.

use serde::Serialize;
use serde::de::DeserializeOwned;
use ureq::config::ConfigBuilder;
use ureq::http::header::{AUTHORIZATION, HeaderValue};
use ureq::http::{Request, Response};
use ureq::middleware::MiddlewareNext;
use ureq::typestate::AgentScope;
use ureq::{Agent, Body, SendBody};

use crate::wire;

/// Longest wait for an answer; a step takes a thousandth of it, so that a dead server does not hold a loop for ever.
const TIMEOUT: std::time::Duration = std::time::Duration::from_secs(10);

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The server cannot be reached, or the connection broke.
    #[error(
        "no answer from {url}: {source}; is the service running there? An address looks like http://127.0.0.1:8080"
    )]
    Transport {
        /// The address asked.
        url: String,
        /// What went wrong.
        source: Box<ureq::Error>,
    },
    /// The server refused the request.
    #[error("{url} refused: {} ({}){}", problem.detail, problem.status, at(problem))]
    Refused {
        /// The address asked.
        url: String,
        /// Why.
        problem: Box<wire::Problem>,
    },
    /// The server answered something else than this client knows.
    #[error("{url} answered with status {status}, but not as a revprio service does")]
    Foreign {
        /// The address asked.
        url: String,
        /// HTTP status.
        status: u16,
    },
}

fn at(problem: &wire::Problem) -> String {
    problem.pointer.as_ref().map(|pointer| format!(" at {pointer}")).unwrap_or_default()
}

/// A client of one server; keeps its connection open between calls.
#[derive(Debug, Clone)]
pub struct Client {
    agent: Agent,
    base: String,
}

impl Client {
    /// A client of the service at a base address such as `http://127.0.0.1:8080`.
    pub fn new(base: &str) -> Self {
        Self { agent: config().build().into(), base: base.trim_end_matches('/').to_owned() }
    }

    /// The same client, showing a token; `None` if that cannot stand in a header.
    pub fn with_token(self, token: &str) -> Option<Self> {
        let authorization = HeaderValue::from_str(&format!("Bearer {token}")).ok()?;
        let show = move |mut request: Request<SendBody>, next: MiddlewareNext| {
            request.headers_mut().insert(AUTHORIZATION, authorization.clone());
            next.handle(request)
        };
        Some(Self { agent: config().middleware(show).build().into(), ..self })
    }

    /// `POST /v1/resolve`
    pub fn resolve(&self, request: &wire::ResolveRequest) -> Result<wire::ResolveAnswer, ClientError> {
        self.post("/v1/resolve", request)
    }

    /// `POST /v1/stability`
    pub fn stability(&self, request: &wire::StabilityRequest) -> Result<wire::StabilityAnswer, ClientError> {
        self.post("/v1/stability", request)
    }

    /// `GET /v1/robots`
    pub fn robots(&self) -> Result<wire::RobotList, ClientError> {
        let url = format!("{}/v1/robots", self.base);
        read(sent(self.agent.get(&url).call(), &url)?, &url)
    }

    /// `POST /v1/robots`
    pub fn register_robot(&self, registration: &wire::RobotRegistration) -> Result<wire::Robot, ClientError> {
        self.post("/v1/robots", registration)
    }

    /// `DELETE /v1/robots/{name}`
    pub fn delete_robot(&self, name: &str) -> Result<(), ClientError> {
        self.delete(&format!("/v1/robots/{name}"))
    }

    pub(crate) fn delete(&self, path: &str) -> Result<(), ClientError> {
        let url = format!("{}{path}", self.base);
        let mut response = sent(self.agent.delete(&url).call(), &url)?;
        if response.status().is_success() { Ok(()) } else { Err(refusal(&mut response, &url)) }
    }

    pub(crate) fn post<Q: Serialize, A: DeserializeOwned>(&self, path: &str, body: &Q) -> Result<A, ClientError> {
        let url = format!("{}{path}", self.base);
        read(sent(self.agent.post(&url).send_json(body), &url)?, &url)
    }
}

fn config() -> ConfigBuilder<AgentScope> {
    Agent::config_builder().http_status_as_error(false).timeout_global(Some(TIMEOUT))
}

fn sent(result: Result<Response<Body>, ureq::Error>, url: &str) -> Result<Response<Body>, ClientError> {
    result.map_err(|source| ClientError::Transport { url: url.to_owned(), source: Box::new(source) })
}

fn read<A: DeserializeOwned>(mut response: Response<Body>, url: &str) -> Result<A, ClientError> {
    if !response.status().is_success() {
        return Err(refusal(&mut response, url));
    }
    let status = response.status().as_u16();
    response.body_mut().read_json().map_err(|_| ClientError::Foreign { url: url.to_owned(), status })
}

fn refusal(response: &mut Response<Body>, url: &str) -> ClientError {
    let (url, status) = (url.to_owned(), response.status().as_u16());
    match response.body_mut().read_json::<wire::Problem>() {
        Ok(problem) => ClientError::Refused { url, problem: Box::new(problem) },
        Err(_) => ClientError::Foreign { url, status },
    }
}
