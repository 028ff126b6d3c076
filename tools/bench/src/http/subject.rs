//! The service under test and the bytes that it is sent.

use std::net::SocketAddr;
use std::time::Duration;

use revprio::service::{AppState, Robots, RunningServer, ServiceConfig, router};
use revprio_api::wire;
use revprio_api::{Client, Service};
use serde::de::DeserializeOwned;

use super::connection::{Connection, NUMBER, Request};
use crate::BenchError;

/// A force and an impedance task on Sawyer, solver `auto`, limits of position and velocity.
const STEP: &str = include_str!("../../../../api/examples/step.json");

/// T B_d / M_d of its force task: the share of its steady speed, (F_d − F) / B_d, that an arm at rest reaches in a period.
const FIRST_SHARE: f64 = 0.01;

/// How a step is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Call {
    /// The controller and its memory travel with the state; the service knows the controller's text from the call before, as
    /// it does in a loop.
    Stateless,
    /// The service keeps them.
    Session,
}

impl Call {
    /// For people.
    pub fn route(self) -> &'static str {
        match self {
            Self::Stateless => "/v1/step",
            Self::Session => "/v1/controllers/{id}/step",
        }
    }
}

/// A running service with a session.
pub struct UnderTest {
    pub address: SocketAddr,
    _server: RunningServer,
    client: Client,
    step: wire::StepRequest,
    session: String,
}

/// The service, but for its refusals when the machine stops for some milliseconds, as a busy virtual one does.
pub fn patient() -> AppState {
    AppState::with_config(
        Robots::built_in(),
        ServiceConfig { max_lag: Duration::from_secs(10), ..ServiceConfig::default() },
    )
}

impl UnderTest {
    /// Starts one on this thread's cores.
    pub fn start() -> Result<Self, BenchError> {
        Self::on(RunningServer::start(router(patient()))?)
    }

    /// The service that runs already.
    pub fn on(server: RunningServer) -> Result<Self, BenchError> {
        let client = Client::new(&server.url());
        let step = steady(&client, NUMBER.parse().map_err(BenchError::defect)?)?;
        let session = client.create_controller(&step.controller)?.id;
        let address = server.url().trim_start_matches("http://").parse().map_err(BenchError::defect)?;
        Ok(Self { address, _server: server, client, step, session })
    }

    /// Requests of which each is a new control period.
    pub fn request(&self, call: Call) -> Request {
        match call {
            Call::Stateless => Request::post("/v1/step", &self.step_body()),
            Call::Session => self.request_of(&self.session),
        }
    }

    /// The same for another session.
    pub fn request_of(&self, session: &str) -> Request {
        Request::post(&format!("/v1/controllers/{session}/step"), &self.state())
    }

    /// The body of a stateless step as JSON.
    pub fn step_body(&self) -> String {
        text(&self.step)
    }

    /// A state as JSON, with a number that counts up.
    pub fn state(&self) -> String {
        text(&self.step.state)
    }

    /// Opens another session and returns its name.
    pub fn another_session(&self) -> Result<String, BenchError> {
        Ok(self.client.create_controller(&self.step.controller)?.id)
    }

    /// So many connections to an address, each with a session of its own here.
    pub fn connections(&self, count: usize, address: SocketAddr) -> Result<Vec<Connection>, BenchError> {
        let open = |_| Ok(Connection::open(address, self.request_of(&self.another_session()?))?);
        (0..count).map(open).collect()
    }

    /// Length of an answer, head included, bytes.
    pub fn answer_length(&self, call: Call) -> Result<usize, BenchError> {
        Ok(Connection::open(self.address, self.fresh(call)?)?.ask()?)
    }

    /// What such a request is answered.
    pub fn parsed_answer<A: DeserializeOwned>(&self, call: Call) -> Result<A, BenchError> {
        let mut connection = Connection::open(self.address, self.fresh(call)?)?;
        let length = connection.ask()?;
        let answer = connection.answer(length);
        let body = answer.windows(4).position(|window| window == b"\r\n\r\n").map_or(&[][..], |at| &answer[at + 4..]);
        serde_json::from_slice(body).map_err(BenchError::defect)
    }

    /// A request that spends no number of the session that is measured.
    fn fresh(&self, call: Call) -> Result<Request, BenchError> {
        match call {
            Call::Stateless => Ok(self.request(call)),
            Call::Session => Ok(self.request_of(&self.another_session()?)),
        }
    }
}

/// The example with an arm that moves as the force task would have it, so that the state can be sent again and again: the
/// integrators stay where they are, and each period is a `closed_form` one without an active limit. Sent from rest they
/// would run up to the limits within a second, and the confirmation of those be measured instead of the service.
fn steady(client: &Client, sequence: u64) -> Result<wire::StepRequest, BenchError> {
    let mut step: wire::StepRequest = serde_json::from_str(STEP).map_err(BenchError::defect)?;
    let from_rest = client.step(&step)?.joint_velocity;
    step.state.joint_velocity = Some(from_rest.iter().map(|speed| speed / FIRST_SHARE).collect::<Vec<_>>().into());
    let answer = client.step(&step)?;
    if answer.solver.path != wire::Path::ClosedForm {
        return Err(BenchError::Defect("the steady state is at a limit".to_owned()));
    }
    step.memory = answer.memory;
    step.state.sequence = sequence;
    Ok(step)
}

/// As JSON; what comes from this crate's own types always can be written.
fn text(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}
