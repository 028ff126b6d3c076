//! Controllers that keep their memory between calls.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use revprio_api::wire;
use revprio_core::controller::{Controller, Memory, Stepper};
use revprio_core::linalg::Vector;
use serde::{Serialize, Serializer};
use tokio::sync::watch;
use uuid::Uuid;

use super::convert;
use super::error::ApiError;
use super::metrics::Metrics;

/// A step that comes more than so many periods after the one before missed one.
const LATE_PERIODS: f64 = 1.5;

/// One control period of a session.
#[derive(Debug)]
pub struct Step {
    /// What was measured.
    pub state: wire::State,
    /// What was answered.
    pub answer: wire::StepAnswer,
    /// q̇ of the period before, n; `None` at the first or if nobody watched.
    pub last_command: Option<Vector>,
}

/// What a session answered, shared with those who watch it and with a retry rather than copied.
#[derive(Debug)]
pub struct Answered(Arc<Step>);

impl Answered {
    /// The answer.
    pub fn answer(&self) -> &wire::StepAnswer {
        &self.0.answer
    }
}

impl Serialize for Answered {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.answer.serialize(serializer)
    }
}

/// One controller with its memory.
pub struct Session {
    /// As it was asked for.
    pub request: wire::Controller,
    stepper: Stepper,
    memory: Option<Memory>,
    last: watch::Sender<Option<Arc<Step>>>,
    steps: u64,
    retries: u64,
    stepped: Option<Instant>,
    missed_periods: u64,
    /// When the last state came, or the session was opened.
    called: Instant,
}

impl Session {
    /// Answers a state that came at `now`: by a step, or, for the state of the last call, by the same answer again.
    fn answer(&mut self, state: wire::State, now: Instant, metrics: &Metrics) -> Result<Answered, ApiError> {
        let controller = Arc::clone(self.stepper.controller());
        let measurement = convert::measurement(&state, &controller)?;
        self.called = now;
        if let Some(last) = &*self.last.borrow() {
            if last.state == state {
                self.retries += 1;
                return Ok(Answered(Arc::clone(last)));
            }
            grows(last.state.sequence, state.sequence)?;
        }
        // Only watchers want it.
        let last_command = self.memory.as_ref().filter(|_| self.last.receiver_count() > 0);
        let last_command = last_command.map(|memory| memory.last_command.clone());
        let command = self.stepper.step(&mut self.memory, &measurement);
        let command = command.map_err(|error| convert::step_problem(&error, ""))?;
        let answer = convert::step_answer(&controller, state.sequence, command, now);
        metrics.solved(&answer.solver);
        self.steps += 1;
        let since = self.stepped.replace(now).map(|before| now.duration_since(before));
        if since.is_some_and(|since| since.as_secs_f64() > LATE_PERIODS * self.request.period_s) {
            self.missed_periods += 1;
            metrics.missed_periods.inc();
        }
        let step = Arc::new(Step { state, answer, last_command });
        self.last.send_replace(Some(Arc::clone(&step)));
        Ok(Answered(step))
    }

    /// The controller, ready to be shared.
    pub fn controller(&self) -> Arc<Controller> {
        Arc::clone(self.stepper.controller())
    }

    /// Hears of every step, without holding it up.
    pub fn watch(&self) -> watch::Receiver<Option<Arc<Step>>> {
        self.last.subscribe()
    }

    /// What the list shows.
    fn entry(&self, id: Uuid) -> wire::SessionEntry {
        wire::SessionEntry {
            id: id.to_string(),
            robot: self.request.robot.clone(),
            method: self.request.method,
            solver: self.request.solver,
            period_s: self.request.period_s,
            steps: self.steps,
            idle_s: self.called.elapsed().as_secs_f64(),
        }
    }

    /// What `GET` shows.
    pub fn status(&self, id: Uuid) -> wire::SessionStatus {
        wire::SessionStatus {
            id: id.to_string(),
            controller: self.request.clone(),
            last_sequence: self.last.borrow().as_ref().map(|last| last.state.sequence),
            steps: self.steps,
            retries: self.retries,
            missed_periods: self.missed_periods,
        }
    }
}

/// Refuses a sequence number that does not grow.
pub fn grows(last: u64, now: u64) -> Result<(), ApiError> {
    if now > last {
        return Ok(());
    }
    Err(ApiError::sequence(format!(
        "sequence {now} after {last}: count up with every new state; only an unchanged state may be sent again"
    )))
}

/// All sessions.
pub struct Sessions {
    limit: usize,
    idle_timeout: Duration,
    metrics: Arc<Metrics>,
    open: Mutex<HashMap<Uuid, Arc<Mutex<Session>>>>,
}

impl Sessions {
    /// None yet.
    pub fn new(limit: usize, idle_timeout: Duration, metrics: Arc<Metrics>) -> Self {
        Self { limit, idle_timeout, metrics, open: Mutex::default() }
    }

    /// Time after which a session ends that gets no state.
    pub fn idle_timeout(&self) -> Duration {
        self.idle_timeout
    }

    /// How many have not ended.
    pub fn count(&self) -> usize {
        self.end_idle().len()
    }

    /// Those that have not ended, the one that was called last first.
    pub fn list(&self) -> wire::SessionList {
        let open = self.end_idle();
        let mut controllers: Vec<_> = open.iter().map(|(id, session)| lock(session).entry(*id)).collect();
        controllers.sort_by(|a, b| a.idle_s.total_cmp(&b.idle_s));
        wire::SessionList { controllers }
    }

    /// Opens a session and returns its name.
    pub fn create(&self, request: wire::Controller, controller: Controller) -> Result<Uuid, ApiError> {
        let mut sessions = self.end_idle();
        if sessions.len() >= self.limit {
            return Err(ApiError::too_many_sessions(self.limit));
        }
        let id = Uuid::new_v4();
        let stepper = Stepper::new(controller).map_err(|error| convert::step_problem(&error, ""))?;
        let session = Session {
            request,
            stepper,
            memory: None,
            last: watch::Sender::new(None),
            steps: 0,
            retries: 0,
            stepped: None,
            missed_periods: 0,
            called: Instant::now(),
        };
        sessions.insert(id, Arc::new(Mutex::new(session)));
        Ok(id)
    }

    /// Ends the sessions that got no state for long, and lets go of their robots.
    pub fn let_go(&self) {
        drop(self.end_idle());
    }

    /// Ends the sessions that got no state for long; what is left.
    fn end_idle(&self) -> MutexGuard<'_, HashMap<Uuid, Arc<Mutex<Session>>>> {
        let mut open = lock(&self.open);
        open.retain(|_, session| lock(session).called.elapsed() < self.idle_timeout);
        open
    }

    /// Answers a state of a session.
    pub fn step(&self, id: &str, state: wire::State) -> Result<Answered, ApiError> {
        let now = Instant::now();
        self.with(id, |_, session| session.answer(state, now, &self.metrics))
    }

    /// Lets `act` work on a session; other sessions are not held up meanwhile.
    pub fn with<T>(
        &self,
        id: &str,
        act: impl FnOnce(Uuid, &mut Session) -> Result<T, ApiError>,
    ) -> Result<T, ApiError> {
        let id = parse(id)?;
        let session = lock(&self.open).get(&id).cloned().ok_or_else(|| unknown(&id.to_string()))?;
        let mut session = lock(&session);
        if session.called.elapsed() >= self.idle_timeout {
            // Removed when the next one is created; taking both locks here, in the other order, could deadlock.
            return Err(unknown(&id.to_string()));
        }
        act(id, &mut session)
    }

    /// Ends a session.
    pub fn delete(&self, id: &str) -> Result<(), ApiError> {
        lock(&self.open).remove(&parse(id)?).map(drop).ok_or_else(|| unknown(id))
    }
}

fn parse(id: &str) -> Result<Uuid, ApiError> {
    Uuid::try_parse(id).map_err(|_| unknown(id))
}

fn unknown(id: &str) -> ApiError {
    ApiError::unknown_controller(id)
}

/// A panic while a lock was held is answered and counted elsewhere; the data, replaced whole, is still consistent.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::robots::Robots;

    fn sessions() -> Sessions {
        Sessions::new(2, Duration::from_mins(15), Arc::new(Metrics::new()))
    }

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
        for session in lock(&sessions.open).values() {
            let mut session = lock(session);
            session.called = session.called.checked_sub(sessions.idle_timeout).unwrap();
        }
    }

    #[test]
    fn an_idle_session_ends_and_makes_room() {
        let sessions = sessions();
        let (idle, busy) = (open(&sessions), open(&sessions));
        let_time_pass(&sessions);
        lock(&lock(&sessions.open)[&parse(&busy).unwrap()]).called = Instant::now();
        assert!(sessions.step(&idle, state()).unwrap_err().is_not_found());
        assert!(sessions.step(&busy, state()).is_ok());
        open(&sessions);
        assert_eq!(lock(&sessions.open).len(), 2);
    }

    #[test]
    fn states_keep_a_session_and_looking_at_it_does_not() {
        let sessions = sessions();
        let id = open(&sessions);
        let called = || lock(&lock(&sessions.open)[&parse(&id).unwrap()]).called;
        let first = called();
        sessions.with(&id, |id, session| Ok(session.status(id))).unwrap();
        assert_eq!(called(), first);
        sessions.step(&id, state()).unwrap();
        assert!(called() > first);
    }
}
