//! The routes of the page.

use std::sync::Arc;

use revprio_api::wire;
use revprio_lab::simulator::{Scenario, ScenarioList};
use revprio_local::robots::Robots;
use revprio_local::{ApiError, LocalService, json};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use crate::controllers::Controllers;
use crate::simulations::Simulations;

/// A request as the host writes it.
#[derive(Deserialize)]
struct Request<'a> {
    method: &'a str,
    path: &'a str,
    #[serde(borrow, default)]
    body: Option<&'a RawValue>,
}

/// An answer: the status of HTTP, and the body in JSON; empty for status 204.
#[derive(Debug)]
pub struct Answer {
    /// Status.
    pub status: u16,
    /// Body.
    pub body: Vec<u8>,
}

/// The service of one page.
pub struct BrowserService {
    local: LocalService,
    controllers: Controllers,
    simulations: Simulations,
}

impl Default for BrowserService {
    fn default() -> Self {
        Self::new()
    }
}

impl BrowserService {
    /// Creates a service that knows the robots that ship with the program.
    pub fn new() -> Self {
        let robots = Arc::new(Robots::built_in());
        Self {
            local: LocalService::sharing(Arc::clone(&robots)),
            controllers: Controllers::default(),
            simulations: Simulations::new(robots),
        }
    }

    /// Answers a request that is a JSON object, with a JSON object.
    pub fn answer_text(&mut self, request: &[u8]) -> Vec<u8> {
        let Answer { status, body } = match serde_json::from_slice::<Request>(request) {
            Ok(Request { method, path, body }) => {
                self.answer(method, path, body.map_or(b"".as_slice(), |body| body.get().as_bytes()))
            }
            Err(error) => problem(ApiError::malformed(error.to_string())),
        };
        let body = if body.is_empty() { b"null".as_slice() } else { &body };
        [format!("{{\"status\":{status},\"body\":").as_bytes(), body, b"}"].concat()
    }

    /// Answers a request: its method, path and body in JSON.
    pub fn answer(&mut self, method: &str, path: &str, body: &[u8]) -> Answer {
        self.route(method, path, body).unwrap_or_else(problem)
    }

    fn route(&mut self, method: &str, path: &str, body: &[u8]) -> Result<Answer, ApiError> {
        let parts: Vec<&str> = path.trim_start_matches("/v1/").split('/').collect();
        let Self { local, controllers, simulations } = self;
        match (method, parts.as_slice()) {
            ("POST", ["robots"]) => Ok(Answer { status: 201, body: local.call(method, path, body)? }),
            ("DELETE", ["robots", _]) => local.call(method, path, body).map(|_| no_content()),
            ("GET", ["scenarios"]) => ok(&ScenarioList::built_in().map_err(|_| ApiError::internal())?),
            ("GET", ["scenarios", name]) => {
                let unknown = || format!("there is no scenario `{name}`; known: {}", Scenario::names());
                let found = Scenario::built_in(name).ok_or_else(|| ApiError::not_found(unknown()))?;
                ok(&found.map_err(|_| ApiError::internal())?)
            }
            ("GET", ["controllers"]) => ok(&wire::SessionList { controllers: Vec::new() }),
            ("POST", ["controllers"]) => written(201, &controllers.open(local, body)?),
            ("PUT", ["controllers", id]) => ok(&controllers.replace(local, id, body)?),
            ("DELETE", ["controllers", id]) => controllers.close(id).map(|()| no_content()),
            ("POST", ["controllers", id, "step"]) => ok(&controllers.step(id, &json::read(body)?)?),
            ("POST", ["simulations"]) => written(202, &simulations.create(json::read(body)?)?),
            ("GET", ["simulations", id]) => ok(&simulations.status(id)?),
            ("DELETE", ["simulations", id]) => simulations.delete(id).map(|()| no_content()),
            ("POST", ["simulations", id, "control"]) => ok(&simulations.control(id, &json::read(body)?)?),
            ("GET", ["simulations", id, "cycle"]) => ok(&simulations.cycle(id)?),
            ("POST", ["simulations", id, "advance"]) => ok(&simulations.advance(id)?),
            _ => Ok(Answer { status: 200, body: local.call(method, path, body)? }),
        }
    }
}

fn ok<T: Serialize>(value: &T) -> Result<Answer, ApiError> {
    written(200, value)
}

fn written<T: Serialize>(status: u16, value: &T) -> Result<Answer, ApiError> {
    Ok(Answer { status, body: json::write(value).map_err(|_| ApiError::internal())? })
}

fn no_content() -> Answer {
    Answer { status: 204, body: Vec::new() }
}

fn problem(error: ApiError) -> Answer {
    let problem = error.into_wire();
    Answer { status: problem.status, body: serde_json::to_vec(&problem).unwrap_or_default() }
}
