//! What the seeds reach: a promise that is never put to the test would be kept in vain.

use std::sync::Mutex;

use crate::transcript::Transcript;

/// Parts of lines that must occur in the transcripts of the ordinary seeds.
const EVENTS: [&str; 34] = [
    "← 200",
    "← 201",
    "← 204",
    "← 400 malformed",
    "← 400 bad-host",
    "← 403 owner",
    "← 403 foreign-host",
    "← 404 unknown-controller",
    "← 404 not-found",
    "← 405 method-not-allowed",
    "← 409 sequence",
    "← 415 media-type",
    "← 422 invalid",
    "← 422 implausible",
    "← 422 key-reused",
    "← 503 deadline",
    "← 503 draining",
    "← 503 overloaded",
    "← 503 too-many-controllers",
    "← Closed",
    "← Cut",
    "← too many connections",
    "← stream: 200",
    "← stream: 404 unknown-controller",
    "← stream: 409 sequence",
    "← stream: 422",
    "← close Some(1001)",
    "← close Some(4404)",
    "← close Some(4408)",
    "no stream: 403",
    "drops its stream",
    "the machine pauses",
    "kills service",
    "has ended",
];

/// The events that no seed has reached yet.
pub struct Coverage(Mutex<Vec<&'static str>>);

impl Coverage {
    pub fn new() -> Self {
        Self(Mutex::new(EVENTS.to_vec()))
    }

    /// Notes the events of a run.
    pub fn note(&self, transcript: &Transcript) {
        let mut missing = self.0.lock().unwrap();
        if !missing.is_empty() {
            let lines = transcript.lines();
            missing.retain(|event| !lines.iter().any(|line| line.contains(event)));
        }
    }

    pub fn missing(&self) -> Vec<&'static str> {
        self.0.lock().unwrap().clone()
    }
}
