//! Controllers that keep their memory between calls.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::watch;
use uuid::Uuid;

use super::convert;
use super::problem::Problem;
use crate::controller::{Command, Controller, Measurement, Memory};
use crate::wire;

/// Sessions at a time; each holds a few kilobytes.
const MOST_SESSIONS: usize = 1024;

/// A session that gets no state for this long ends; looking at it does not keep it.
pub const IDLE_TIMEOUT: Duration = Duration::from_mins(15);

/// One controller with its memory.
pub struct Session {
    /// As it was asked for.
    pub request: wire::Controller,
    /// Ready to step.
    pub controller: Controller,
    memory: Option<Memory>,
    last: watch::Sender<Option<Arc<wire::WatchedStep>>>,
    steps: u64,
    retries: u64,
    called: Instant,
}

impl Session {
    /// Answers a state: by a step, or, for the state of the last call, by the same answer again.
    fn answer(
        &mut self,
        state: &wire::State,
        measurement: &Measurement,
        describe: impl FnOnce(&Controller, &Command) -> wire::StepAnswer,
    ) -> Result<wire::StepAnswer, Problem> {
        self.called = Instant::now();
        if let Some(last) = &*self.last.borrow() {
            if last.state == *state {
                self.retries += 1;
                return Ok(last.answer.clone());
            }
            grows(last.state.sequence, state.sequence)?;
        }
        let command =
            self.controller.step(&mut self.memory, measurement).map_err(|error| convert::step_problem(&error, ""))?;
        let answer = describe(&self.controller, &command);
        self.steps += 1;
        self.last.send_replace(Some(Arc::new(wire::WatchedStep { state: state.clone(), answer: answer.clone() })));
        Ok(answer)
    }

    /// Hears of every step, without holding it up.
    pub fn watch(&self) -> watch::Receiver<Option<Arc<wire::WatchedStep>>> {
        self.last.subscribe()
    }

    /// What `GET` shows.
    pub fn status(&self, id: Uuid) -> wire::SessionStatus {
        wire::SessionStatus {
            id: id.to_string(),
            controller: self.request.clone(),
            last_sequence: self.last.borrow().as_ref().map(|last| last.state.sequence),
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
        let last = watch::Sender::new(None);
        let session = Session { request, controller, memory: None, last, steps: 0, retries: 0, called: now };
        sessions.insert(id, Arc::new(Mutex::new(session)));
        Ok(id)
    }

    /// Ends the sessions that were not called for long, and lets go of their robots.
    pub fn end_idle(&self) {
        let now = Instant::now();
        lock(&self.0).retain(|_, session| now.duration_since(lock(session).called) < IDLE_TIMEOUT);
    }

    /// Answers a state of a session.
    pub fn step(&self, id: &str, state: &wire::State) -> Result<wire::StepAnswer, Problem> {
        let start = Instant::now();
        self.with(id, |_, session| {
            let measurement = convert::measurement(state, &session.controller)?;
            session.answer(state, &measurement, |controller, command| {
                convert::step_answer(controller, state.sequence, command, start)
            })
        })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::robots::Robots;

    fn open(sessions: &Sessions) -> String {
        let request: wire::Controller =
            serde_json::from_str(include_str!("../../api/examples/controller.json")).unwrap();
        let controller = convert::controller(&request, &Robots::built_in()).unwrap();
        sessions.create(request, controller).unwrap().to_string()
    }

    fn state() -> wire::State {
        serde_json::from_str(include_str!("../../api/examples/state.json")).unwrap()
    }

    /// Lets all sessions wait for the longest time they may.
    fn let_time_pass(sessions: &Sessions) {
        for session in lock(&sessions.0).values() {
            let mut session = lock(session);
            session.called = session.called.checked_sub(IDLE_TIMEOUT).unwrap();
        }
    }

    #[test]
    fn an_idle_session_ends_and_makes_room() {
        let sessions = Sessions::default();
        let (idle, busy) = (open(&sessions), open(&sessions));
        let_time_pass(&sessions);
        lock(&lock(&sessions.0)[&parse(&busy).unwrap()]).called = Instant::now();
        assert!(sessions.step(&idle, &state()).unwrap_err().is_not_found());
        assert!(sessions.step(&busy, &state()).is_ok());
        open(&sessions);
        assert_eq!(lock(&sessions.0).len(), 2);
    }

    #[test]
    fn states_keep_a_session_and_looking_at_it_does_not() {
        let sessions = Sessions::default();
        let id = open(&sessions);
        let called = || lock(&lock(&sessions.0)[&parse(&id).unwrap()]).called;
        let first = called();
        sessions.with(&id, |id, session| Ok(session.status(id))).unwrap();
        assert_eq!(called(), first);
        sessions.step(&id, &state()).unwrap();
        assert!(called() > first);
    }
}
