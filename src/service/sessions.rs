//! Controllers that keep their memory between calls.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use prometheus_client::metrics::counter::Counter;
use uuid::Uuid;

use super::convert;
use super::problem::Problem;
use crate::controller::{Command, Controller, Measurement, Memory};
use crate::wire;

/// A step that comes more than so many periods after the one before missed one.
const LATE_PERIODS: f64 = 1.5;

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
    stepped: Option<Instant>,
    missed_periods: u64,
    all_missed_periods: Counter,
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
        self.count_missed_period();
        self.last = Some((state.clone(), answer.clone()));
        Ok(answer)
    }

    /// Counts this step if it comes late; the session was called just now.
    fn count_missed_period(&mut self) {
        let since = self.stepped.replace(self.called).map(|before| self.called.duration_since(before));
        if since.is_some_and(|since| since.as_secs_f64() > LATE_PERIODS * self.request.period_s) {
            self.missed_periods += 1;
            self.all_missed_periods.inc();
        }
    }

    /// What `GET` shows.
    pub fn status(&self, id: Uuid) -> wire::SessionStatus {
        wire::SessionStatus {
            id: id.to_string(),
            controller: self.request.clone(),
            last_sequence: self.last.as_ref().map(|(state, _)| state.sequence),
            steps: self.steps,
            retries: self.retries,
            missed_periods: self.missed_periods,
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
pub struct Sessions {
    limit: usize,
    idle_timeout: Duration,
    missed_periods: Counter,
    open: Mutex<HashMap<Uuid, Arc<Mutex<Session>>>>,
}

impl Sessions {
    /// None yet; `missed_periods` counts those of all sessions.
    pub fn new(limit: usize, idle_timeout: Duration, missed_periods: Counter) -> Self {
        Self { limit, idle_timeout, missed_periods, open: Mutex::default() }
    }

    /// How many have not ended.
    pub fn count(&self) -> usize {
        self.not_ended().len()
    }

    /// Forgets those that ended.
    fn not_ended(&self) -> MutexGuard<'_, HashMap<Uuid, Arc<Mutex<Session>>>> {
        let mut open = lock(&self.open);
        open.retain(|_, session| lock(session).called.elapsed() < self.idle_timeout);
        open
    }

    /// Opens a session and returns its name.
    pub fn create(&self, request: wire::Controller, controller: Controller) -> Result<Uuid, Problem> {
        let mut sessions = self.not_ended();
        if sessions.len() >= self.limit {
            return Err(Problem::too_many_sessions(self.limit));
        }
        let id = Uuid::new_v4();
        let session = Session {
            request,
            controller,
            memory: None,
            last: None,
            steps: 0,
            retries: 0,
            stepped: None,
            missed_periods: 0,
            all_missed_periods: self.missed_periods.clone(),
            called: Instant::now(),
        };
        sessions.insert(id, Arc::new(Mutex::new(session)));
        Ok(id)
    }

    /// Lets `act` work on a session; other sessions are not held up meanwhile.
    pub fn with<T>(&self, id: &str, act: impl FnOnce(Uuid, &mut Session) -> Result<T, Problem>) -> Result<T, Problem> {
        let id = parse(id)?;
        let session = lock(&self.open).get(&id).cloned().ok_or_else(|| unknown(&id.to_string()))?;
        let mut session = lock(&session);
        if session.called.elapsed() >= self.idle_timeout {
            // Removed when the next one is created; taking both locks here, in the other order, could deadlock.
            return Err(unknown(&id.to_string()));
        }
        session.called = Instant::now();
        act(id, &mut session)
    }

    /// Ends a session.
    pub fn delete(&self, id: &str) -> Result<(), Problem> {
        lock(&self.open).remove(&parse(id)?).map(drop).ok_or_else(|| unknown(id))
    }
}

fn parse(id: &str) -> Result<Uuid, Problem> {
    Uuid::try_parse(id).map_err(|_| unknown(id))
}

fn unknown(id: &str) -> Problem {
    Problem::unknown_controller(id)
}

/// A panic while a lock was held is answered and counted elsewhere; the data, replaced whole, is still consistent.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
