//! Controllers that keep their memory between calls.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use uuid::Uuid;

use super::convert;
use super::problem::Problem;
use crate::controller::{Command, Controller, Measurement, Memory};
use crate::wire;

/// Sessions at a time; each holds a few kilobytes.
const MOST_SESSIONS: usize = 1024;

/// A session that is not called for this long ends.
pub const IDLE_TIMEOUT: Duration = Duration::from_mins(15);

/// One controller with its memory.
pub struct Session {
    /// As it was asked for.
    pub request: wire::Controller,
    /// Ready to step.
    pub controller: Controller,
    memory: Option<Memory>,
    last: Option<(wire::State, wire::StepAnswer)>,
    steps: u64,
    retries: u64,
    called: Instant,
}

impl Session {
    /// Answers a state: by a step, or, for the state of the last call, by the same answer again.
    pub fn answer(
        &mut self,
        state: &wire::State,
        measurement: &Measurement,
        describe: impl FnOnce(&Controller, &Command) -> wire::StepAnswer,
    ) -> Result<wire::StepAnswer, Problem> {
        if let Some((last, answer)) = &self.last {
            if last == state {
                self.retries += 1;
                return Ok(answer.clone());
            }
            grows(last.sequence, state.sequence)?;
        }
        let command =
            self.controller.step(&mut self.memory, measurement).map_err(|error| convert::step_problem(&error, ""))?;
        let answer = describe(&self.controller, &command);
        self.steps += 1;
        self.last = Some((state.clone(), answer.clone()));
        Ok(answer)
    }

    /// What `GET` shows.
    pub fn status(&self, id: Uuid) -> wire::SessionStatus {
        wire::SessionStatus {
            id: id.to_string(),
            controller: self.request.clone(),
            last_sequence: self.last.as_ref().map(|(state, _)| state.sequence),
            steps: self.steps,
            retries: self.retries,
        }
    }
}

/// Refuses a sequence number that does not grow.
pub fn grows(last: u64, now: u64) -> Result<(), Problem> {
    if now > last {
        return Ok(());
    }
    Err(Problem::sequence(format!(
        "sequence {now} after {last}: count up with every new state; only an unchanged state may be sent again"
    )))
}

/// All sessions.
#[derive(Default)]
pub struct Sessions(Mutex<HashMap<Uuid, Arc<Mutex<Session>>>>);

impl Sessions {
    /// Opens a session and returns its name.
    pub fn create(&self, request: wire::Controller, controller: Controller) -> Result<Uuid, Problem> {
        self.end_idle();
        let now = Instant::now();
        let mut sessions = lock(&self.0);
        if sessions.len() >= MOST_SESSIONS {
            return Err(Problem::too_many_sessions(MOST_SESSIONS));
        }
        let id = Uuid::new_v4();
        let session = Session { request, controller, memory: None, last: None, steps: 0, retries: 0, called: now };
        sessions.insert(id, Arc::new(Mutex::new(session)));
        Ok(id)
    }

    /// Ends the sessions that were not called for long, and lets go of their robots.
    pub fn end_idle(&self) {
        let now = Instant::now();
        lock(&self.0).retain(|_, session| now.duration_since(lock(session).called) < IDLE_TIMEOUT);
    }

    /// Lets `act` work on a session; other sessions are not held up meanwhile.
    pub fn with<T>(&self, id: &str, act: impl FnOnce(Uuid, &mut Session) -> Result<T, Problem>) -> Result<T, Problem> {
        let id = parse(id)?;
        let session = lock(&self.0).get(&id).cloned().ok_or_else(|| unknown(&id.to_string()))?;
        let mut session = lock(&session);
        if session.called.elapsed() >= IDLE_TIMEOUT {
            // Removed when the next one is created; taking both locks here, in the other order, could deadlock.
            return Err(unknown(&id.to_string()));
        }
        session.called = Instant::now();
        act(id, &mut session)
    }

    /// Ends a session.
    pub fn delete(&self, id: &str) -> Result<(), Problem> {
        lock(&self.0).remove(&parse(id)?).map(drop).ok_or_else(|| unknown(id))
    }
}

fn parse(id: &str) -> Result<Uuid, Problem> {
    Uuid::try_parse(id).map_err(|_| unknown(id))
}

fn unknown(id: &str) -> Problem {
    Problem::not_found(format!(
        "there is no controller `{id}`; it may have ended; create one with POST /v1/controllers"
    ))
}

/// A panic while a lock was held is answered and counted elsewhere; the data, replaced whole, is still consistent.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
