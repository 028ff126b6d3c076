//! The service without a server, for bindings to other languages.
//!
//! It reads and writes the bodies of the HTTP interface and shares their code, so answers equal those over HTTP to the last
//! bit.

use std::sync::Arc;

use crate::clock::Instant;
use revprio_api::wire;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::all_cores::map_on_all_cores;
use super::checked_stepper::{ComputedStep, ControlLoop, PreparedController};
use super::convert;
use super::error::ApiError;
use super::json;
use super::price;
use super::robots::{Robots, RobotsError};
use super::step::{ITEMS_PER_THREAD, batch_item, check_batch_size, resolve, stateless_step, stateless_stepper};

/// The service as function calls with JSON bodies.
pub struct LocalService {
    robots: Arc<Robots>,
}

impl LocalService {
    /// Creates a service that knows these robots.
    pub fn new(robots: Robots) -> Self {
        Self::sharing(Arc::new(robots))
    }

    /// Creates a service that knows these robots, which others may know as well.
    pub fn sharing(robots: Arc<Robots>) -> Self {
        Self { robots }
    }

    /// Answers a request to a route: its method, path and JSON body. Returns the JSON body of the answer.
    ///
    /// Sessions, simulations and scenarios need a server; a session is a [`LocalController`] here.
    pub fn call(&self, method: &str, path: &str, body: &[u8]) -> Result<Vec<u8>, ApiError> {
        match (method, path) {
            ("POST", "/v1/resolve") => write(&self.resolve(body)?),
            ("POST", "/v1/resolve/batch") => write(&self.resolve_batch(&read(body)?)?),
            ("POST", "/v1/step") => write(&self.step(&read(body)?)?),
            ("POST", "/v1/kinematics") => write(&convert::kinematics(&read(body)?, &self.robots)?),
            ("POST", "/v1/stability") => write(&stability(&read(body)?)?),
            ("POST", "/v1/payload") => write(&convert::payload(&read(body)?, &self.robots)?),
            ("GET", "/v1/robots") => {
                let robots = self.robots.all().iter().map(|robot| convert::robot_answer(robot)).collect();
                write(&wire::RobotList { robots })
            }
            ("POST", "/v1/robots") => write(&self.register(&read(body)?)?),
            _ => self.call_robot(method, path),
        }
    }

    /// Resolves a problem, `POST /v1/resolve`.
    pub fn resolve(&self, body: &[u8]) -> Result<wire::ResolveAnswer, ApiError> {
        self.resolve_read(&read(body)?)
    }

    /// Returns the price of a problem, `POST /v1/resolve`, by which a server decides on which thread it is solved.
    pub fn price(&self, body: &[u8]) -> Result<Price, ApiError> {
        let problem = convert::resolve_problem(&read(body)?, &self.robots)?;
        let units = price::of_problem(&problem.problem, problem.solver);
        Ok(Price { units, is_within_budget: units <= price::RESOLVE_BUDGET })
    }

    /// Opens a controller, `POST /v1/controllers`. Without an owner and without an end by time.
    pub fn controller(&self, body: &[u8]) -> Result<LocalController, ApiError> {
        let PreparedController { stepper, warnings, .. } = PreparedController::new(read(body)?, &self.robots)?;
        Ok(LocalController { control: ControlLoop::new(stepper), warnings })
    }

    /// Replaces a controller, `PUT /v1/controllers/{id}`.
    pub fn replace(&self, controller: &mut LocalController, body: &[u8]) -> Result<(), ApiError> {
        let PreparedController { stepper, warnings, .. } = PreparedController::new(read(body)?, &self.robots)?;
        controller.warnings = controller.control.replace(stepper, warnings)?;
        Ok(())
    }

    fn resolve_read(&self, request: &wire::ResolveRequest) -> Result<wire::ResolveAnswer, ApiError> {
        let start = Instant::now();
        resolve(&convert::resolve_problem(request, &self.robots)?, start, || false)
    }

    fn resolve_batch(&self, request: &wire::BatchRequest) -> Result<wire::BatchAnswer, ApiError> {
        check_batch_size(request.items.len())?;
        let item = |i: usize, problem: &wire::ResolveRequest| batch_item(i, self.resolve_read(problem));
        let items = map_on_all_cores(&request.items, ITEMS_PER_THREAD, || false, item);
        Ok(wire::BatchAnswer { items: items.ok_or_else(ApiError::internal)? })
    }

    fn step(&self, request: &wire::StepRequest) -> Result<wire::StepAnswer, ApiError> {
        let mut stepper = stateless_stepper(&request.controller, &self.robots)?;
        stateless_step(&mut stepper, &request.state, request.memory.as_ref())
    }

    fn register(&self, request: &wire::RobotRegistration) -> Result<wire::Robot, ApiError> {
        let robot = Arc::new(convert::robot(request)?);
        let answer = convert::robot_answer(&robot);
        self.robots.register(robot).map_err(|error| convert::robots_error(&error))?;
        Ok(answer)
    }

    fn call_robot(&self, method: &str, path: &str) -> Result<Vec<u8>, ApiError> {
        let robots_error = |error: RobotsError| convert::robots_error(&error);
        match (method, path.strip_prefix("/v1/robots/")) {
            ("GET", Some(name)) => {
                let robot = self.robots.get(name).map_err(robots_error)?;
                write(&convert::robot_answer(&robot))
            }
            ("DELETE", Some(name)) => self.robots.remove(name).map(|()| b"null".to_vec()).map_err(robots_error),
            _ => Err(ApiError::not_found(format!("{method} {path} needs a server; start one with `revprio serve`"))),
        }
    }
}

/// The price of a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Price {
    /// The price; one unit is about 0.25 µs at most.
    pub units: usize,
    /// Whether the thread of the steps solves the problem, and no worker.
    pub is_within_budget: bool,
}

/// A session without a server: a controller and its memory.
pub struct LocalController {
    control: ControlLoop,
    warnings: Vec<String>,
}

impl LocalController {
    /// Names of the joints, in order.
    pub fn joints(&self) -> impl Iterator<Item = &str> {
        self.control.controller().config().robot.joints().iter().map(|joint| joint.name.as_str())
    }

    /// Warnings about the controller, such as unstable loops.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Braking deceleration of the joints in all answers, n, rad/s² or m/s²; infinite: stop at once.
    pub fn braking_deceleration(&self) -> Vec<f64> {
        let joints = self.control.controller().config().robot.joints();
        joints.iter().map(|joint| revprio_core::limits::braking_deceleration(&joint.limits)).collect()
    }

    /// Computes the answer to a state, whose sequence number must increase.
    pub fn step(&mut self, state: &wire::State) -> Result<ComputedStep, ApiError> {
        let start = Instant::now();
        let measurement = self.control.measurement(state)?;
        if let Some(last) = self.control.last_sequence() {
            convert::check_sequence(last, state.sequence)?;
        }
        self.control.command(state.sequence, measurement, start)
    }
}

fn stability(request: &wire::StabilityRequest) -> Result<wire::StabilityAnswer, ApiError> {
    Ok(convert::margin_answer(&convert::margin(&convert::contact_loop(request)?, || false)?))
}

fn read<T: DeserializeOwned>(body: &[u8]) -> Result<T, ApiError> {
    json::read(body)
}

fn write<T: Serialize>(answer: &T) -> Result<Vec<u8>, ApiError> {
    serde_json::to_vec(answer).map_err(|_| ApiError::internal())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example(name: &str) -> Vec<u8> {
        std::fs::read(format!("{}/../../api/examples/{name}.json", env!("CARGO_MANIFEST_DIR"))).unwrap()
    }

    fn problem(error: ApiError) -> (u16, String, Option<String>) {
        let problem = error.into_wire();
        (problem.status, problem.detail, problem.pointer)
    }

    #[test]
    fn a_controller_from_state_to_state_equals_steps_with_their_memory() {
        let service = LocalService::new(Robots::built_in());
        let mut request: wire::StepRequest = serde_json::from_slice(&example("step")).unwrap();
        request.memory = None;
        let mut controller = service.controller(&serde_json::to_vec(&request.controller).unwrap()).unwrap();
        for sequence in 0..50 {
            request.state.sequence = sequence;
            let stateless = service.step(&request).unwrap();
            let step = controller.step(&request.state).unwrap();
            let answer = step.answer();
            assert_eq!(step.joint_velocity(), stateless.joint_velocity);
            assert_eq!(step.valid_for_ms(), stateless.valid_for_ms);
            let expected = wire::StepAnswer { memory: None, elapsed_us: answer.elapsed_us, ..stateless.clone() };
            assert_eq!(answer, expected);
            request.memory = stateless.memory;
        }
    }

    #[test]
    fn an_answer_that_is_kept_does_not_change() {
        let controller = || LocalService::new(Robots::built_in()).controller(&example("controller")).unwrap();
        let state: wire::State = serde_json::from_slice(&example("state")).unwrap();
        let first = state.sequence;
        let steps = |keep: usize| {
            let (mut controller, mut kept) = (controller(), Vec::new());
            for sequence in first..first + 20 {
                let mut state = wire::State { sequence, ..state.clone() };
                if let wire::JointVector::Ordered(position) = &mut state.joint_position {
                    position[0] += 1e-3 * (sequence - first) as f64;
                }
                kept.push(controller.step(&state).unwrap());
                if kept.len() > keep {
                    kept.remove(0);
                }
            }
            kept
        };
        let velocities = |steps: &[ComputedStep]| steps.iter().map(|s| s.joint_velocity().to_vec()).collect::<Vec<_>>();
        let all = velocities(&steps(20));
        assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "{all:?}");
        for keep in 1..5 {
            assert_eq!(velocities(&steps(keep)), all[20 - keep..]);
        }
    }

    #[test]
    fn errors_name_field_and_status_as_over_http() {
        let service = LocalService::new(Robots::built_in());
        let refused = |method, path, body: &str| problem(service.call(method, path, body.as_bytes()).unwrap_err());
        let (status, _, pointer) = refused("POST", "/v1/resolve", r#"{"tasks": [{"axes": ["x"], "velocity": [1]}]}"#);
        assert_eq!((status, pointer.as_deref()), (422, Some("/tasks/0/axes")));
        assert_eq!(refused("POST", "/v1/resolve", "{").0, 400);
        assert_eq!(refused("GET", "/v1/robots/nobody", "").0, 404);
        let (status, detail, _) = refused("POST", "/v1/simulations", "{}");
        assert!(status == 404 && detail.contains("revprio serve"), "{detail}");
    }

    #[test]
    fn a_repeated_sequence_number_is_refused() {
        let service = LocalService::new(Robots::built_in());
        let mut controller = service.controller(&example("controller")).unwrap();
        let state = serde_json::from_slice(&example("state")).unwrap();
        assert!(controller.step(&state).is_ok());
        assert_eq!(controller.step(&state).err().map(|error| problem(error).0), Some(409));
    }

    #[test]
    fn a_registered_robot_can_be_used_and_deleted() {
        let service = LocalService::new(Robots::built_in());
        let robot: wire::Robot =
            serde_json::from_slice(&service.call("POST", "/v1/robots", &example("robot")).unwrap()).unwrap();
        let path = format!("/v1/robots/{}", robot.name);
        assert!(service.call("GET", &path, b"").is_ok());
        assert!(service.call("DELETE", &path, b"").is_ok());
        assert!(service.call("DELETE", &path, b"").is_err());
    }
}
