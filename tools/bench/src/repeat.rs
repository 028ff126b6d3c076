//! Repeats one operation, for a profiler that counts instructions (`tools/bench/instructions/run`).

use std::hint::black_box;

use clap::ValueEnum;
use revprio::service::Robots;
use revprio_api::wire;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::Vector;
use revprio_core::resolution::{Path, Problem, Resolution, Resolver, resolve};
use revprio_core::task::{Task, TaskStack};
use revprio_robot::built_in;
use revprio_robot::kinematics::{Axis, AxisSelection, Configuration};

use super::core::cycle::{Cycle, NOMINAL, swing};
use super::error::BenchError;
use super::http::connection::Connection;
use super::http::subject::{Call, UnderTest};
use super::http::{Echo, ping_pong};

/// An operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Repeated {
    /// Nothing
    Nothing,
    /// Pose and Jacobian of Sawyer
    Kinematics,
    /// A control period that no limit restricts, two tasks
    ClosedForm,
    /// A resolution whose active limits are those of the guess, with memory of its own
    Certificate,
    /// The same with the memory of the call before, as in a control loop
    CertificateInLoop,
    /// A control period through Clarabel
    Qp,
    /// The body of /v1/step read
    ReadStep,
    /// A state read
    ReadState,
    /// An answer written
    WriteAnswer,
    /// A session step over HTTP, client included
    Session,
    /// The same from a bare axum route
    BareSession,
    /// A stateless step over HTTP, client included
    Stateless,
    /// The same from a bare axum route
    BareStateless,
    /// The bytes of a session step over TCP, client included
    PingPong,
}

/// Repeats an operation `times` times.
pub fn repeat(what: Repeated, times: u64) -> Result<(), BenchError> {
    let mut act = action(what)?;
    (0..times).try_for_each(|_| act())
}

type Action = Box<dyn FnMut() -> Result<(), BenchError>>;

fn action(what: Repeated) -> Result<Action, BenchError> {
    match what {
        Repeated::Nothing => Ok(Box::new(|| Ok(()))),
        Repeated::Kinematics => {
            let robot = &built_in()[0];
            let mut posture = Configuration::new(robot, &NOMINAL).map_err(BenchError::defect)?;
            Ok(Box::new(move || {
                posture.update(robot, black_box(&NOMINAL)).map_err(BenchError::defect)?;
                black_box(&posture);
                Ok(())
            }))
        }
        Repeated::ClosedForm => cycles(wire::Solver::Auto, None),
        Repeated::Qp => cycles(wire::Solver::Qp, Some(0.35)),
        Repeated::Certificate => certificate(false),
        Repeated::CertificateInLoop => certificate(true),
        Repeated::ReadStep | Repeated::ReadState | Repeated::WriteAnswer => codec(what),
        Repeated::Session => http(Call::Session),
        Repeated::Stateless => http(Call::Stateless),
        Repeated::BareSession => bare(Call::Session),
        Repeated::BareStateless => bare(Call::Stateless),
        Repeated::PingPong => ping_pong_action(),
    }
}

fn cycles(solver: wire::Solver, limit: Option<f64>) -> Result<Action, BenchError> {
    let mut cycle = Cycle::along(&swing(solver, limit)?, &Robots::built_in(), &NOMINAL, 200)?;
    Ok(Box::new(move || {
        black_box(cycle.repeat()?);
        Ok(())
    }))
}

/// Limits that are active for the first task; the guess is the active set of the last answer.
fn certificate(keeps_memory: bool) -> Result<Action, BenchError> {
    let configuration = Configuration::new(&built_in()[0], &NOMINAL).map_err(BenchError::defect)?;
    let task = |name: &str, axes: &[Axis], velocity: Vec<f64>| {
        let jacobian = AxisSelection::new(axes).map_err(BenchError::defect)?.rows_of(configuration.jacobian());
        Ok::<_, BenchError>(Task::new(name, jacobian, Vector::from_vec(velocity)))
    };
    let push = task("push", &[Axis::X], vec![0.4])?;
    let hold = task("hold", &[Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz], vec![0.0; 5])?;
    let tasks = TaskStack::new(vec![push, hold]).map_err(BenchError::defect)?;
    let limits = VelocityBox::new(&[-0.35; 7], &[0.35; 7]).map_err(BenchError::defect)?;
    let problem = Problem { limits, ..Problem::new(tasks) };
    let guess = resolve(&problem, &[]).map_err(BenchError::defect)?.active_set;
    if resolve(&problem, &guess).map_err(BenchError::defect)?.solver.path != Path::ActiveSet {
        return Err(BenchError::Defect("the guess was not confirmed".to_owned()));
    }
    if !keeps_memory {
        let once = move || resolve(&problem, &guess).map(|answer| drop(black_box(answer)));
        return Ok(Box::new(move || once().map_err(BenchError::defect)));
    }
    let (mut resolver, mut answer) = (Resolver::default(), Resolution::default());
    Ok(Box::new(move || {
        resolver.resolve(&problem, &guess, &mut answer).map_err(BenchError::defect)?;
        black_box(&answer);
        Ok(())
    }))
}

fn codec(what: Repeated) -> Result<Action, BenchError> {
    let service = UnderTest::start()?;
    let (step, state) = (service.step_body(), service.state());
    let answer: wire::StepAnswer = service.parsed_answer(Call::Session)?;
    Ok(Box::new(move || {
        match what {
            Repeated::ReadStep => serde_json::from_str::<wire::StepRequest>(&step).map(|read| drop(black_box(read))),
            Repeated::ReadState => serde_json::from_str::<wire::State>(&state).map(|read| drop(black_box(read))),
            _ => serde_json::to_vec(&answer).map(|written| drop(black_box(written))),
        }
        .map_err(BenchError::defect)
    }))
}

fn http(call: Call) -> Result<Action, BenchError> {
    let service = UnderTest::start()?;
    let mut connection = Connection::open(service.address, service.request(call))?;
    Ok(Box::new(move || {
        let _keep = &service;
        Ok(connection.call().map(drop)?)
    }))
}

fn bare(call: Call) -> Result<Action, BenchError> {
    let service = UnderTest::start()?;
    let echo = Echo::start(service.parsed_answer(Call::Stateless)?, service.parsed_answer(Call::Session)?)?;
    let mut connection = Connection::open(echo.address, service.request(call))?;
    Ok(Box::new(move || {
        let _keep = &echo;
        Ok(connection.call().map(drop)?)
    }))
}

fn ping_pong_action() -> Result<Action, BenchError> {
    let service = UnderTest::start()?;
    let (request, answer) = (service.request(Call::Session), service.answer_length(Call::Session)?);
    let mut connection = Connection::open(ping_pong(request.length(), answer)?, request)?;
    Ok(Box::new(move || Ok(connection.call_bytes(answer)?)))
}
