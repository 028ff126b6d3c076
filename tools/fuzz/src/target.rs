//! The targets: how each one sends an input to the service.

use std::time::Duration;

use revprio_api::wire::{
    BatchAnswer, BatchItem, BatchRequest, CreatedController, KinematicsAnswer, Object, ResolveAnswer, ResolveRequest,
    StabilityAnswer, StepAnswer, StepRequest,
};
use serde::de::DeserializeOwned;

use crate::answers::{command, problem, value};
use crate::budget::{Bound, Work, processor_time};
use crate::connection::{Answer, InMemory};
use crate::limits;
use crate::{Defect, frames, urdf};

/// Number of times that a late answer is asked for again. The first one may pay for memory pages or a new thread.
const ATTEMPTS: usize = 5;

/// Deadline of work in worker threads, which have a low priority. It bounds hangs, not the processor time.
const WORK_TIMEOUT: Duration = Duration::from_secs(10);

/// Deadline of stability margins. Shorter than the default, so that the fuzzer makes progress.
const MARGIN_TIMEOUT: Duration = Duration::from_millis(500);

/// Maximum number of states that a session gets.
const MAX_STEPS: usize = 16;

/// What the bytes of an input are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A line with the route, then a body in JSON.
    Json,
    /// A line with the route, then a body in MessagePack.
    MessagePack,
    /// A body in JSON for `/v1/stability`, whose answers take longer than all others.
    Stability,
    /// A URDF text to register. A first line may have the names of base and tip.
    Urdf,
    /// A line with the kind of messages, then messages or bytes of a WebSocket.
    Stream,
    /// Lines of JSON: a controller, then states.
    Controller,
}

impl Target {
    /// All targets.
    pub const ALL: [Self; 6] =
        [Self::Json, Self::MessagePack, Self::Stability, Self::Urdf, Self::Stream, Self::Controller];

    /// Returns the name, which is the name of the folder of its corpus.
    pub fn name(self) -> &'static str {
        match self {
            Self::Json => "json",
            Self::MessagePack => "message_pack",
            Self::Stability => "stability",
            Self::Urdf => "urdf",
            Self::Stream => "stream",
            Self::Controller => "controller",
        }
    }

    /// Returns the target with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|target| target.name() == name)
    }
}

/// Sends inputs to a service, and checks its answers.
pub struct Checker {
    target: Target,
    bound: Bound,
    pub(crate) service: InMemory,
}

impl Checker {
    /// Starts a service in memory for the inputs of this target.
    pub fn start(target: Target, bound: Bound) -> Self {
        let work_timeout = if target == Target::Stability { MARGIN_TIMEOUT } else { WORK_TIMEOUT };
        Self { target, bound, service: InMemory::start(work_timeout) }
    }

    /// Sends an input to the service. Returns the first defect.
    pub fn check(&self, input: &[u8]) -> Result<(), Defect> {
        let mut result = Ok(());
        for _ in 0..ATTEMPTS {
            result = match self.target {
                Target::Json => self.body(input, Format::Json),
                Target::MessagePack => self.body(input, Format::MessagePack),
                Target::Stability => self.stability(input),
                Target::Urdf => urdf::check(self, input),
                Target::Stream => frames::check(self, input),
                Target::Controller => self.session(input),
            };
            if !matches!(result, Err(Defect::Slow(_))) {
                break;
            }
        }
        result
    }

    /// Runs `act`, which may use this much processor time.
    pub(crate) fn timed<T>(&self, budget: Duration, act: impl FnOnce() -> Result<T, Defect>) -> Result<T, Defect> {
        let start = processor_time();
        let value = act()?;
        let used = processor_time().saturating_sub(start);
        if self.bound == Bound::ProcessorTime && used > budget {
            return Err(Defect::Slow(format!("{used:?} of processor time, more than {budget:?}")));
        }
        Ok(value)
    }

    /// Posts a body in JSON, and returns its answer in time.
    pub(crate) fn post(&self, path: &str, body: &[u8], work: Work) -> Result<Answer, Defect> {
        self.post_as(Format::Json, path, body, work)
    }

    fn post_as(&self, format: Format, path: &str, body: &[u8], work: Work) -> Result<Answer, Defect> {
        let work = Work { bytes: body.len(), ..work };
        self.timed(work.budget(), || self.service.post(path, format.media_type(), body))
    }

    fn body(&self, input: &[u8], format: Format) -> Result<(), Defect> {
        let Some((route, body)) = split_line(input) else { return Ok(()) };
        match route {
            b"resolve" => self.resolve(body, format),
            b"resolve/batch" => self.batch(body, format),
            b"step" => self.step(body, format),
            b"kinematics" => {
                let answer = self.post_as(format, "/v1/kinematics", body, Work::default())?;
                value::<KinematicsAnswer>(&answer, false).map(drop)
            }
            _ => Ok(()),
        }
    }

    fn resolve(&self, body: &[u8], format: Format) -> Result<(), Defect> {
        let request: Option<ResolveRequest> = format.read(body);
        let work = request.as_ref().map(Work::of_problem).unwrap_or_default();
        let answer = self.post_as(format, "/v1/resolve", body, work)?;
        let Some(answer) = value::<ResolveAnswer>(&answer, work.exceeds_arm())? else { return Ok(()) };
        command(&answer, limits::of_problem(&accepted(request)?).as_ref())
    }

    fn batch(&self, body: &[u8], format: Format) -> Result<(), Defect> {
        let request: Option<BatchRequest> = format.read(body);
        let problems = request.as_ref().map(|batch| batch.items.as_slice()).unwrap_or_default();
        let price = problems.iter().map(|item| Work::of_problem(item).price).sum();
        let tasks = problems.iter().map(|item| item.tasks.len()).max().unwrap_or_default();
        let work = Work { price, tasks, items: problems.len(), ..Work::default() };
        let answer = self.post_as(format, "/v1/resolve/batch", body, work)?;
        let Some(answer) = value::<BatchAnswer>(&answer, work.exceeds_arm())? else { return Ok(()) };
        let request = accepted(request)?;
        if answer.items.len() != request.items.len() {
            return Err(Defect::Wrong(format!("{} answers to {} items", answer.items.len(), request.items.len())));
        }
        for (problem, item) in request.items.iter().zip(&answer.items) {
            match item {
                BatchItem::Answer(answer) => command(&**answer, limits::of_problem(problem).as_ref())?,
                BatchItem::Problem(problem) if problem.status < 500 => {}
                BatchItem::Problem(problem) => return Err(Defect::Wrong(format!("an item is answered {problem:?}"))),
            }
        }
        Ok(())
    }

    fn step(&self, body: &[u8], format: Format) -> Result<(), Defect> {
        let request: Option<StepRequest> = format.read(body);
        let work = request.as_ref().map(Work::of_step).unwrap_or_default();
        let answer = self.post_as(format, "/v1/step", body, work)?;
        let Some(answer) = value::<StepAnswer>(&answer, work.exceeds_arm())? else { return Ok(()) };
        command(&answer, limits::of_controller(&accepted(request)?.controller).as_ref())
    }

    /// Margins have workers of their own and may be late. Then their work must stop.
    fn stability(&self, body: &[u8]) -> Result<(), Defect> {
        let answer = self.timed(2 * MARGIN_TIMEOUT, || {
            let answer = self.service.post("/v1/stability", "application/json", body)?;
            if answer.status == 503 {
                // This work starts when the work before it has stopped.
                self.service.post("/v1/stability", "application/json", REFUSED_MARGIN)?;
            }
            Ok(answer)
        })?;
        value::<StabilityAnswer>(&answer, true).map(drop)
    }

    fn session(&self, input: &[u8]) -> Result<(), Defect> {
        let mut lines = input.split(|byte| *byte == b'\n');
        let controller = lines.next().unwrap_or_default();
        let request = Format::Json.read::<revprio_api::wire::Controller>(controller);
        let answer = self.post("/v1/controllers", controller, Work::default())?;
        let Some(created) = value::<CreatedController>(&answer, false)? else { return Ok(()) };
        let request = accepted(request)?;
        let step = StepRequest { controller: request, state: default_state(created.joints.len()), memory: None };
        let limits = limits::of_controller(&step.controller);
        let work = Work::of_step(&step);
        let path = format!("/v1/controllers/{}", created.id);
        let mut states: Vec<Vec<u8>> = lines.take(MAX_STEPS).map(<[u8]>::to_vec).collect();
        if states.is_empty() {
            states.push(serde_json::to_vec(&step.state).unwrap_or_default());
        }
        for state in states {
            let answer = self.post(&format!("{path}/step"), &state, work)?;
            if let Some(answer) = value::<StepAnswer>(&answer, work.exceeds_arm())? {
                command(&answer, limits.as_ref())?;
            }
        }
        let answer = self.service.delete(&path)?;
        if answer.status == 204 { Ok(()) } else { problem(&answer.body, Some(204), false) }
    }
}

/// A loop whose margins cannot be computed, which is known soon.
const REFUSED_MARGIN: &[u8] =
    br#"{"inertia": 1e-300, "damping": 1e300, "environment": {"stiffness": 1e300}, "period_s": 0.001}"#;

/// The format of a body.
#[derive(Debug, Clone, Copy)]
enum Format {
    Json,
    MessagePack,
}

impl Format {
    fn media_type(self) -> &'static str {
        match self {
            Self::Json => "application/json",
            Self::MessagePack => "application/msgpack",
        }
    }

    /// Reads a request as the service does.
    fn read<T: DeserializeOwned>(self, body: &[u8]) -> Option<T> {
        let read = match self {
            Self::Json => serde_json::from_slice(body).ok(),
            Self::MessagePack => rmp_serde::from_slice(body).ok(),
        };
        read.map(|Object(value)| value)
    }
}

/// A state at the middle of the ranges of most arms.
fn default_state(joints: usize) -> revprio_api::wire::State {
    revprio_api::wire::State {
        sequence: 1,
        time_s: 0.0,
        joint_position: vec![0.3; joints].into(),
        joint_velocity: None,
        wrench: None,
        targets: std::collections::BTreeMap::new(),
    }
}

/// Returns the request, which the service accepted and which must therefore be readable.
fn accepted<T>(request: Option<T>) -> Result<T, Defect> {
    request.ok_or_else(|| Defect::Wrong("the service accepted a body that its type refuses".to_owned()))
}

/// Splits the first line off.
pub(crate) fn split_line(input: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = input.iter().position(|byte| *byte == b'\n')?;
    Some((&input[..end], &input[end + 1..]))
}
