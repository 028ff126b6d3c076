//! The service under test and its requests.

use std::net::SocketAddr;
use std::time::Duration;

use revprio::service::{AppState, Robots, RunningServer, ServiceConfig, router};
use revprio_api::wire;
use revprio_api::{Client, Service};
use serde::de::DeserializeOwned;

use super::connection::{Connection, NUMBER, OWNER, Request};
use crate::error::BenchError;

/// A force and an impedance task on Sawyer, solver `auto`, limits of position and velocity.
const STEP: &str = include_str!("../../../../api/examples/step.json");

/// T B_d / M_d of the force task: the share of the steady speed (F_d − F) / B_d that an arm reaches from rest in one period.
const FIRST_SHARE: f64 = 0.01;

/// Force at which the tool moves at 3 mm/s, N.
const NEARLY_TARGET: f64 = 29.5;

/// The kind of a step request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Call {
    /// The request contains controller and memory. The service recognises the text of the controller from the call before.
    Stateless,
    /// The service keeps controller and memory in a session.
    Session,
}

impl Call {
    /// Returns the route.
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

/// Returns a service that does not shed load when the machine stops for some milliseconds, as virtual machines do.
pub fn state_without_load_shedding() -> AppState {
    AppState::with_config(
        Robots::built_in(),
        ServiceConfig { max_lag: Duration::from_secs(10), ..ServiceConfig::default() },
    )
}

impl UnderTest {
    /// Starts a service on the cores of this thread.
    pub fn start() -> Result<Self, BenchError> {
        Self::on(RunningServer::start(router(state_without_load_shedding()))?)
    }

    /// Uses a running service.
    pub fn on(server: RunningServer) -> Result<Self, BenchError> {
        let client = Client::new(&server.url()).with_owner(OWNER);
        let step = steady(&client, NUMBER.parse().map_err(BenchError::defect)?)?;
        let session = client.create_controller(&step.controller)?.id;
        let address = server.url().trim_start_matches("http://").parse().map_err(BenchError::defect)?;
        Ok(Self { address, _server: server, client, step, session })
    }

    /// Returns a request; each call is a new control period.
    pub fn request(&self, call: Call) -> Request {
        match call {
            Call::Stateless => Request::post("/v1/step", &self.step_body()),
            Call::Session => self.request_of(&self.session),
        }
    }

    /// Returns a request for another session.
    pub fn request_of(&self, session: &str) -> Request {
        Request::post(&format!("/v1/controllers/{session}/step"), &self.state())
    }

    /// Returns the body of a stateless step as JSON.
    pub fn step_body(&self) -> String {
        to_json(&self.step)
    }

    /// Returns a state as JSON, with a number that counts up.
    pub fn state(&self) -> String {
        to_json(&self.step.state)
    }

    /// Opens another session and returns its identifier.
    pub fn another_session(&self) -> Result<String, BenchError> {
        Ok(self.client.create_controller(&self.step.controller)?.id)
    }

    /// Opens `count` connections to an address, each with its own session of this service.
    pub fn connections(&self, count: usize, address: SocketAddr) -> Result<Vec<Connection>, BenchError> {
        let open = |_| Ok(Connection::open(address, self.request_of(&self.another_session()?))?);
        (0..count).map(open).collect()
    }

    /// Returns the length of an answer with head, bytes.
    pub fn answer_length(&self, call: Call) -> Result<usize, BenchError> {
        Ok(Connection::open(self.address, self.fresh(call)?)?.call()?)
    }

    /// Returns the answer to a request.
    pub fn parsed_answer<A: DeserializeOwned>(&self, call: Call) -> Result<A, BenchError> {
        let mut connection = Connection::open(self.address, self.fresh(call)?)?;
        let length = connection.call()?;
        let answer = connection.answer(length);
        let body = answer.windows(4).position(|window| window == b"\r\n\r\n").map_or(&[][..], |at| &answer[at + 4..]);
        serde_json::from_slice(body).map_err(BenchError::defect)
    }

    /// Returns a request that does not use a sequence number of the measured session.
    fn fresh(&self, call: Call) -> Result<Request, BenchError> {
        match call {
            Call::Stateless => Ok(self.request(call)),
            Call::Session => Ok(self.request_of(&self.another_session()?)),
        }
    }
}

/// Returns the example with an arm that moves at the speed that the force task commands. The state can then be sent
/// repeatedly: the integrators do not change, and each period is solved in closed form without an active limit. From rest,
/// the integrators would reach the limits within a second. The arm is slow, because an answer would otherwise warn of joints that do
/// not follow their commands.
fn steady(client: &Client, sequence: u64) -> Result<wire::StepRequest, BenchError> {
    let mut step: wire::StepRequest = serde_json::from_str(STEP).map_err(BenchError::defect)?;
    step.state.wrench.get_or_insert_default().force[0] = NEARLY_TARGET;
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

/// Serializes a value as JSON, which cannot fail for these types.
fn to_json(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}
