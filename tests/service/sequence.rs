//! Sequence numbers: a retry is safe, every new state needs a greater number.

use serde_json::{Value, json};

use crate::harness::{Answer, Service, example};

/// Returns the example state with another sequence number and another position of the first joint.
fn state(sequence: u64, first_joint: f64) -> Value {
    let mut state = example("state.json");
    state["sequence"] = json!(sequence);
    state["joint_position"][0] = json!(first_joint);
    state
}

/// A service with a session.
struct Session {
    service: Service,
    address: String,
}

impl Session {
    fn open() -> Self {
        let service = Service::start();
        let address = service.open(&example("controller.json"));
        Self { service, address }
    }

    fn step(&self, sequence: u64, first_joint: f64) -> Answer {
        self.service.post(&format!("{}/step", self.address), &state(sequence, first_joint).to_string())
    }

    /// Returns steps, retries and the last sequence number.
    fn counters(&self) -> [Value; 3] {
        let shown = self.service.get(&self.address).accepted();
        ["steps", "retries", "last_sequence"].map(|field| shown[field].clone())
    }
}

#[test]
fn a_retry_gets_the_same_answer_and_does_not_step_again() {
    let session = Session::open();
    session.step(1, 2.9).accepted();
    let (first, again) = (session.step(2, 2.9), session.step(2, 2.9));
    assert_eq!(first.text, again.text);
    assert_eq!(session.counters(), [json!(2), json!(1), json!(2)]);
}

#[test]
fn a_sequence_number_that_does_not_increase_is_a_conflict_and_changes_nothing() {
    let session = Session::open();
    session.step(5, 2.9).accepted();
    session.step(5, 2.91).assert_refused(409, Some("/sequence"));
    session.step(4, 2.9).assert_refused(409, Some("/sequence"));
    session.step(0, 2.9).assert_refused(409, Some("/sequence"));
    assert_eq!(session.counters(), [json!(1), json!(0), json!(5)]);
    session.step(6, 2.9).accepted();
}

#[test]
fn sequence_numbers_may_start_at_zero_and_have_gaps() {
    let session = Session::open();
    for sequence in [0, 1, 100, (1 << 53) - 1] {
        assert_eq!(session.step(sequence, 2.9).accepted()["sequence"], sequence);
    }
}

#[test]
fn without_a_session_the_memory_holds_the_last_sequence_number() {
    let service = Service::start();
    let mut request = example("step.json");
    request["memory"] = service.call("/v1/step", &request)["memory"].clone();
    service.post("/v1/step", &request.to_string()).assert_refused(409, Some("/state/sequence"));
    request["state"]["sequence"] = json!(18);
    assert_eq!(service.call("/v1/step", &request)["sequence"], 18);
}
