//! The calls of a control loop as a trait, and the typed, blocking HTTP client that implements it.

use std::hash::{BuildHasher, RandomState};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::Serialize;
use serde::de::DeserializeOwned;
use ureq::http::header::{AUTHORIZATION, CONTENT_TYPE, HeaderValue};
use ureq::http::{Request, Response};
use ureq::middleware::MiddlewareNext;
use ureq::typestate::WithBody;
use ureq::unversioned::transport::DefaultConnector;
use ureq::{Agent, Body, RequestBuilder, SendBody};

use crate::address::AddressResolver;
use crate::wire;

/// Maximum wait for an answer, so that a dead server does not block a loop. A step takes about 0.1 ms.
const TIMEOUT: std::time::Duration = std::time::Duration::from_secs(10);

/// Why a call has no answer.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The server cannot be reached, or the connection broke.
    #[error(
        "no answer from {url}: {source}; is the service running there? An address looks like http://127.0.0.1:8080"
    )]
    Transport {
        /// The address of the request.
        url: String,
        /// The error of the connection.
        source: Box<ureq::Error>,
    },
    /// The server refused the request.
    #[error("{url} refused: {} ({}){}", problem.detail, problem.status, pointer_text(problem))]
    Refused {
        /// The address of the request.
        url: String,
        /// The reason, with the field and the remedy.
        problem: Box<wire::Problem>,
    },
    /// The answer is not one of a revprio service.
    #[error("{url} answered with status {status}, but not as a revprio service does; check the address")]
    UnexpectedAnswer {
        /// The address of the request.
        url: String,
        /// HTTP status of the answer.
        status: u16,
    },
}

fn pointer_text(problem: &wire::Problem) -> String {
    problem.pointer.as_ref().map(|pointer| format!(" at {pointer}")).unwrap_or_default()
}

/// The header with the owner token of a session.
const OWNER: &str = "revprio-owner";

/// The header with the key of a request that opens a session.
const IDEMPOTENCY_KEY: &str = "idempotency-key";

/// A client of one server. It keeps its connection open between calls.
///
/// Only this client and its clones step the sessions that it opens: each request carries a random owner token.
#[derive(Debug, Clone)]
pub struct Client {
    agent: Agent,
    base: String,
    owner: String,
    sent: Arc<AtomicU64>,
}

impl Client {
    /// Builds a client of the service at a base address such as `http://127.0.0.1:8080`.
    pub fn new(base: &str) -> Self {
        let sent = Arc::default();
        let base = base.trim_end_matches('/').to_owned();
        Self { agent: agent(&sent, None), base, owner: random_word(), sent }
    }

    /// Returns the number of requests that this client and its clones have sent.
    #[must_use]
    pub fn requests(&self) -> u64 {
        self.sent.load(Ordering::Relaxed)
    }

    /// Returns the same client with another owner token, 1 to 128 letters, digits and `-_.~`. Clients with the same token
    /// can step the same session.
    #[must_use]
    pub fn with_owner(self, owner: &str) -> Self {
        Self { owner: owner.to_owned(), ..self }
    }

    /// Returns the same client with a token for each request; `None` if the token has characters that a header cannot
    /// have.
    pub fn with_token(self, token: &str) -> Option<Self> {
        let authorization = HeaderValue::from_str(&format!("Bearer {token}")).ok()?;
        Some(Self { agent: agent(&self.sent, Some(authorization)), ..self })
    }

    /// Resolves tasks at one posture. `POST /v1/resolve`
    pub fn resolve(&self, request: &wire::ResolveRequest) -> Result<wire::ResolveAnswer, ClientError> {
        self.post("/v1/resolve", request)
    }

    /// Computes the stability margins of one axis in contact. `POST /v1/stability`
    pub fn stability(&self, request: &wire::StabilityRequest) -> Result<wire::StabilityAnswer, ClientError> {
        self.post("/v1/stability", request)
    }

    /// Identifies bias and payload of a wrench sensor. `POST /v1/payload`
    pub fn payload(&self, request: &wire::PayloadRequest) -> Result<wire::PayloadAnswer, ClientError> {
        self.post("/v1/payload", request)
    }

    /// Tares a wrench sensor of a session. `POST /v1/controllers/{id}/tare`
    pub fn tare(&self, id: &str, request: &wire::TareRequest) -> Result<wire::TareAnswer, ClientError> {
        self.post(&format!("/v1/controllers/{id}/tare"), request)
    }

    /// Lists the robots. `GET /v1/robots`
    pub fn robots(&self) -> Result<wire::RobotList, ClientError> {
        let url = format!("{}/v1/robots", self.base);
        read(check_sent(self.agent.get(&url).call(), &url)?, &url)
    }

    /// Registers a robot from a URDF text. `POST /v1/robots`
    pub fn register_robot(&self, registration: &wire::RobotRegistration) -> Result<wire::Robot, ClientError> {
        self.post("/v1/robots", registration)
    }

    /// Deletes a registered robot. `DELETE /v1/robots/{name}`
    pub fn delete_robot(&self, name: &str) -> Result<(), ClientError> {
        self.delete(&format!("/v1/robots/{name}"))
    }

    /// Replaces the controller of a session while the arm moves, without a jump. `PUT /v1/controllers/{id}`
    pub fn replace_controller(
        &self,
        id: &str,
        controller: &wire::Controller,
    ) -> Result<wire::CreatedController, ClientError> {
        let url = format!("{}/v1/controllers/{id}", self.base);
        let request = self.agent.put(&url).header(OWNER, &self.owner);
        read(check_sent(send(request, controller), &url)?, &url)
    }

    fn delete(&self, path: &str) -> Result<(), ClientError> {
        let url = format!("{}{path}", self.base);
        let request = self.agent.delete(&url).header(OWNER, &self.owner);
        let mut response = check_sent(request.call(), &url)?;
        if response.status().is_success() { Ok(()) } else { Err(refused(&mut response, &url)) }
    }

    fn post<Q: Serialize, A: DeserializeOwned>(&self, path: &str, body: &Q) -> Result<A, ClientError> {
        self.post_with(path, body, &[])
    }

    fn post_with<Q: Serialize, A: DeserializeOwned>(
        &self,
        path: &str,
        body: &Q,
        headers: &[(&str, &str)],
    ) -> Result<A, ClientError> {
        let url = format!("{}{path}", self.base);
        let request = self.agent.post(&url).header(OWNER, &self.owner);
        let request = headers.iter().fold(request, |request, (name, value)| request.header(*name, *value));
        read(check_sent(send(request, body), &url)?, &url)
    }
}

/// Returns a random word. The standard library seeds its hashers with random keys.
fn random_word() -> String {
    let part = || RandomState::new().hash_one(std::process::id());
    format!("{:016x}{:016x}", part(), part())
}

/// A service that computes commands, over HTTP ([`Client`]) or in the same process.
pub trait Service {
    /// Opens a session with a controller. `POST /v1/controllers`
    fn create_controller(&self, controller: &wire::Controller) -> Result<wire::CreatedController, ClientError>;

    /// Computes the command of a session for a state. `POST /v1/controllers/{id}/step`
    fn step_controller(&self, id: &str, state: &wire::State) -> Result<wire::StepAnswer, ClientError>;

    /// Ends a session. `DELETE /v1/controllers/{id}`
    fn delete_controller(&self, id: &str) -> Result<(), ClientError>;

    /// Computes a command without a session: the request carries controller and memory. `POST /v1/step`
    fn step(&self, request: &wire::StepRequest) -> Result<wire::StepAnswer, ClientError>;
}

impl Service for Client {
    fn create_controller(&self, controller: &wire::Controller) -> Result<wire::CreatedController, ClientError> {
        let key = random_word();
        let open = || self.post_with("/v1/controllers", controller, &[(IDEMPOTENCY_KEY, key.as_str())]);
        match open() {
            // The connection broke. With the same key, the request opens no second session.
            Err(ClientError::Transport { .. }) => open(),
            answer => answer,
        }
    }

    fn step_controller(&self, id: &str, state: &wire::State) -> Result<wire::StepAnswer, ClientError> {
        self.post(&format!("/v1/controllers/{id}/step"), state)
    }

    fn delete_controller(&self, id: &str) -> Result<(), ClientError> {
        self.delete(&format!("/v1/controllers/{id}"))
    }

    fn step(&self, request: &wire::StepRequest) -> Result<wire::StepAnswer, ClientError> {
        self.post("/v1/step", request)
    }
}

/// Returns an agent that counts its requests.
fn agent(sent: &Arc<AtomicU64>, authorization: Option<HeaderValue>) -> Agent {
    let sent = Arc::clone(sent);
    let count_and_authorize = move |mut request: Request<SendBody>, next: MiddlewareNext| {
        sent.fetch_add(1, Ordering::Relaxed);
        if let Some(authorization) = &authorization {
            request.headers_mut().insert(AUTHORIZATION, authorization.clone());
        }
        next.handle(request)
    };
    let config = Agent::config_builder().http_status_as_error(false).timeout_global(Some(TIMEOUT));
    let config = config.middleware(count_and_authorize).build();
    Agent::with_parts(config, DefaultConnector::default(), AddressResolver::default())
}

/// Sends a body without spaces and line breaks, which ureq would add.
fn send<Q: Serialize>(request: RequestBuilder<WithBody>, body: &Q) -> Result<Response<Body>, ureq::Error> {
    let body = serde_json::to_vec(body)?;
    request.header(CONTENT_TYPE, "application/json").send(&body[..])
}

fn check_sent(result: Result<Response<Body>, ureq::Error>, url: &str) -> Result<Response<Body>, ClientError> {
    result.map_err(|source| ClientError::Transport { url: url.to_owned(), source: Box::new(source) })
}

fn read<A: DeserializeOwned>(mut response: Response<Body>, url: &str) -> Result<A, ClientError> {
    if !response.status().is_success() {
        return Err(refused(&mut response, url));
    }
    let status = response.status().as_u16();
    let body = response.body_mut().read_to_vec().ok();
    let answer = body.and_then(|body| serde_json::from_slice(&body).ok());
    answer.ok_or_else(|| ClientError::UnexpectedAnswer { url: url.to_owned(), status })
}

fn refused(response: &mut Response<Body>, url: &str) -> ClientError {
    let (url, status) = (url.to_owned(), response.status().as_u16());
    match response.body_mut().read_json::<wire::Problem>() {
        Ok(problem) => ClientError::Refused { url, problem: Box::new(problem) },
        Err(_) => ClientError::UnexpectedAnswer { url, status },
    }
}
