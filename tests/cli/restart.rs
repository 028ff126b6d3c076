//! The service is killed during a simulation and started again at the same address.

use std::ops::ControlFlow;

use revprio_api::{Client, ClientError, Service};
use revprio_lab::simulator::recording::{Recording, Sample};
use revprio_lab::simulator::{CallMode, RunError, Scenario, run};

use crate::serve::Server;

const KILLED: u64 = 200;
const STARTED: u64 = 500;
const PERIODS: u64 = 1000;

/// Periods of 1 ms after the last answered one that end within the 100 ms for which its answer is valid.
const VALID: usize = 99;

/// Accelerations of the arm's joints, rad/s².
const ACCELERATION: [f64; 7] = [8.0, 8.0, 8.0, 8.0, 10.0, 10.0, 10.0];

fn scenario() -> Scenario {
    let mut scenario = Scenario::find("force_tracking").unwrap();
    scenario.duration_s = PERIODS as f64 * scenario.period_s();
    scenario
}

/// Runs the scenario without a server from period `KILLED` to `STARTED`.
fn interrupted(mode: CallMode) -> (Recording, Server) {
    let mut server = Some(Server::start());
    let url = server.as_ref().unwrap().url.clone();
    let address = url.trim_start_matches("http://").to_owned();
    let recording = run(&scenario(), &Client::new(&url), mode, |done| {
        match done {
            // Called repeatedly while the run waits for the server.
            KILLED => drop(server.take()),
            STARTED if server.is_none() => server = Some(Server::start_at(&address)),
            _ => (),
        }
        ControlFlow::Continue(())
    });
    (recording.unwrap(), server.unwrap())
}

/// Asserts that the arm holds the command while the answer is valid and then ramps to rest at its acceleration limits.
fn assert_comes_to_rest(unanswered: &[Sample], last: &Sample) {
    let mut before = &last.joint_velocity;
    for (i, sample) in unanswered.iter().enumerate() {
        for (joint, limit) in ACCELERATION.iter().enumerate() {
            let (old, new) = (before[joint], sample.joint_velocity[joint]);
            let slower = (old.abs() - limit * 0.001).max(0.0);
            let expected = if i < VALID { old.abs() } else { slower };
            assert!((new.abs() - expected).abs() < 1e-12 && new * old >= 0.0, "period {i}, joint {joint}: {old} {new}");
        }
        before = &sample.joint_velocity;
    }
    assert!(last.joint_velocity.iter().any(|v| v.abs() > 1e-4), "the arm moved before");
    assert!(before.iter().all(|v| *v == 0.0), "the arm is at rest at the end: {before:?}");
}

/// Returns the samples before the kill, without answers, and after the next answer.
fn parts(recording: &Recording) -> [&[Sample]; 3] {
    let samples = &recording.samples[..];
    let gap = samples.iter().position(|sample| !sample.answered).unwrap();
    let again = samples[gap..].iter().position(|sample| sample.answered).map_or(samples.len(), |i| gap + i);
    [&samples[..gap], &samples[gap..again], &samples[again..]]
}

#[test]
fn stateless_client_continues_with_a_new_server() {
    let (recording, _server) = interrupted(CallMode::Stateless);
    let [before, silent, after] = parts(&recording);
    assert_eq!(before.len() as u64, KILLED);
    assert!(silent.len() as u64 >= STARTED - KILLED && silent.len() as u64 <= STARTED - KILLED + 2);
    assert_comes_to_rest(silent, before.last().unwrap());
    assert!(after.len() > 400 && after.iter().all(|sample| sample.answered));
    // The contact force is back at its target.
    let force = after.last().unwrap().force[0];
    assert!((force - recording.samples.last().unwrap().target_force[0].unwrap()).abs() < 3.0, "{force}");
}

#[test]
fn client_of_a_lost_session_comes_to_rest_and_gets_an_error() {
    let (recording, server) = interrupted(CallMode::Session);
    let [before, silent, after] = parts(&recording);
    assert_eq!((before.len() as u64, after.len()), (KILLED, 0));
    assert_comes_to_rest(silent, before.last().unwrap());
    let state = serde_json::from_str(include_str!("../../api/examples/state.json")).unwrap();
    let gone = Client::new(&server.url).step_controller("00000000-0000-4000-8000-000000000000", &state);
    let Err(ClientError::Refused { problem, .. }) = gone else { panic!("{gone:?}") };
    assert_eq!((problem.status, problem.kind.as_str()), (404, "/problems/unknown-controller"));
}

#[test]
fn run_without_any_answer_fails() {
    let nobody =
        run(&scenario(), &Client::new("http://127.0.0.1:9"), CallMode::Stateless, |_| ControlFlow::Continue(()));
    assert!(nobody.unwrap_err().to_string().contains("no answer from"));
}

#[test]
fn run_that_waits_for_a_server_can_be_stopped() {
    let mut server = Some(Server::start());
    let url = server.as_ref().unwrap().url.clone();
    let mut calls = 0;
    let stopped = run(&scenario(), &Client::new(&url), CallMode::Stateless, |done| {
        server.take_if(|_| done == 5);
        calls += u64::from(done == 5);
        // Called once after the period, then while waiting for the next answer.
        if calls == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(matches!(stopped, Err(RunError::Stopped { .. })), "{:?}", stopped.map(drop));
}
