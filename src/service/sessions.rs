//! Sessions: controllers that keep their memory on the service between calls.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use revprio_api::wire;
use revprio_core::controller::Controller;
use revprio_core::linalg::Vector;
use serde::{Serialize, Serializer};
use tokio::sync::{Mutex as AsyncMutex, OwnedMutexGuard, watch};
use tokio::time::Instant;
use uuid::Uuid;

use super::checked_stepper::{ControlLoop, PreparedController};
use super::convert;
use super::error::ApiError;
use super::interleaving::{Interleaving, Source};
use super::metrics::Metrics;
use super::ownership::{Owner, Ownership};
use super::platform::Platform;
use super::price;
use super::robots::Robots;
use super::workers::Workers;

/// A step more than this many periods after the previous step counts as a missed period.
const LATE_PERIODS: f64 = 1.5;

/// One control period of a session.
#[derive(Debug)]
pub struct Step {
    /// The measured state.
    pub state: wire::State,
    /// The answer to the state.
    pub answer: wire::StepAnswer,
    /// Joint velocities q̇ of the previous period, n; `None` at the first step or without a watcher.
    pub last_command: Option<Vector>,
    /// The controller that computed the answer.
    pub controller: Arc<Controller>,
}

/// The answer of a session. Watchers and retries share it without a copy.
#[derive(Debug)]
pub struct SharedAnswer(Arc<Step>);

impl SharedAnswer {
    /// The answer.
    pub fn answer(&self) -> &wire::StepAnswer {
        &self.0.answer
    }
}

impl Serialize for SharedAnswer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.answer.serialize(serializer)
    }
}

/// A controller with its memory and counters.
pub struct Session {
    /// The controller of the request.
    pub request: wire::Controller,
    ownership: Ownership,
    control: ControlLoop,
    interleaving: Interleaving,
    last_step: watch::Sender<Option<Arc<Step>>>,
    steps: u64,
    retries: u64,
    last_step_time: Option<Instant>,
    missed_periods: u64,
    /// Time of the last state, or of the opening of the session.
    last_call: Instant,
    /// Whether the session was deleted. Calls that wait for it then find it ended.
    is_deleted: Arc<AtomicBool>,
}

impl Session {
    /// Answers a state that arrived at `now`. A new state makes a step. The last state again gets the last answer again.
    fn answer(
        &mut self,
        state: wire::State,
        source: Source,
        now: Instant,
        metrics: &Metrics,
    ) -> Result<SharedAnswer, ApiError> {
        // A repeated state may name what a controller that was replaced since then had.
        let repeated = self.last_step.borrow().as_ref().filter(|last| last.state == state).map(Arc::clone);
        if let Some(last) = repeated {
            self.last_call = now;
            self.retries += 1;
            return Ok(SharedAnswer(last));
        }
        let measurement = self.control.measurement(&state)?;
        self.last_call = now;
        if let Some(last) = &*self.last_step.borrow() {
            let checked = convert::check_sequence(last.state.sequence, state.sequence);
            checked.inspect_err(|_| self.interleaving.count_refused())?;
        }
        // Only watchers use the last command.
        let last_command = self.control.last_command().filter(|_| self.last_step.receiver_count() > 0).cloned();
        let mut answer = self.control.step(state.sequence, measurement, now)?;
        self.interleaving.count_step(source, &mut answer.warnings);
        metrics.count_resolution(&answer.solver);
        self.steps += 1;
        let elapsed = self.last_step_time.replace(now).map(|last| now.duration_since(last));
        if elapsed.is_some_and(|elapsed| elapsed.as_secs_f64() > LATE_PERIODS * self.request.period_s) {
            self.missed_periods += 1;
            metrics.missed_periods.inc();
        }
        let controller = Arc::clone(self.control.controller());
        let step = Arc::new(Step { state, answer, last_command, controller });
        self.last_step.send_replace(Some(Arc::clone(&step)));
        Ok(SharedAnswer(step))
    }

    /// Subscribes to the steps. A watcher never delays a step.
    pub fn watch(&self) -> watch::Receiver<Option<Arc<Step>>> {
        self.last_step.subscribe()
    }

    /// Returns the entry for the list of sessions.
    fn entry(&self, id: Uuid) -> wire::SessionEntry {
        wire::SessionEntry {
            id: id.to_string(),
            robot: self.request.robot.clone(),
            method: self.request.method,
            solver: self.request.solver,
            period_s: self.request.period_s,
            steps: self.steps,
            idle_s: self.last_call.elapsed().as_secs_f64(),
        }
    }

    /// Returns the answer to `GET`.
    pub fn status(&self, id: Uuid) -> wire::SessionStatus {
        wire::SessionStatus {
            id: id.to_string(),
            controller: self.request.clone(),
            last_sequence: self.last_step.borrow().as_ref().map(|last| last.state.sequence),
            steps: self.steps,
            retries: self.retries,
            missed_periods: self.missed_periods,
        }
    }
}

type SharedSession = Arc<AsyncMutex<Session>>;

/// A session, and what is known of it while it steps.
struct Open {
    request: wire::Controller,
    ownership: Ownership,
    is_deleted: Arc<AtomicBool>,
    session: SharedSession,
}

/// All sessions.
pub struct Sessions {
    limit: usize,
    idle_timeout: Duration,
    metrics: Arc<Metrics>,
    platform: Arc<dyn Platform>,
    /// A session is locked while it steps, in another thread if the step is expensive. The thread of the steps must
    /// therefore never wait for the lock of a session.
    open: Mutex<HashMap<Uuid, Open>>,
}

impl Sessions {
    /// Creates an empty table for at most `limit` sessions.
    pub fn new(limit: usize, idle_timeout: Duration, metrics: Arc<Metrics>, platform: Arc<dyn Platform>) -> Self {
        Self { limit, idle_timeout, metrics, platform, open: Mutex::default() }
    }

    /// Returns the number of open sessions.
    pub fn count(&self) -> usize {
        self.lock_active().len()
    }

    /// Lists the open sessions, the last called one first.
    pub async fn list(&self) -> wire::SessionList {
        let mut open: Vec<(Uuid, SharedSession)> =
            self.lock_active().iter().map(|(id, open)| (*id, Arc::clone(&open.session))).collect();
        // A session in use makes the list wait. Its time must not depend on the order of the table.
        open.sort_unstable_by_key(|(id, _)| *id);
        let mut controllers = Vec::with_capacity(open.len());
        for (id, session) in open {
            controllers.push(session.lock().await.entry(id));
        }
        controllers.sort_by(|a, b| a.idle_s.total_cmp(&b.idle_s).then_with(|| a.id.cmp(&b.id)));
        wire::SessionList { controllers }
    }

    /// Opens a session.
    ///
    /// A request that repeats an idempotency key gets the session that the first one opened.
    pub fn create(
        &self,
        controller: PreparedController,
        ownership: Ownership,
    ) -> Result<wire::CreatedController, ApiError> {
        let id = Uuid::from_bytes(self.platform.random_bytes());
        let PreparedController { request, stepper, warnings } = controller;
        let answer = self.created(id, stepper.controller(), warnings);
        let session = Session {
            request,
            ownership,
            control: ControlLoop::new(stepper),
            interleaving: Interleaving::default(),
            last_step: watch::Sender::new(None),
            steps: 0,
            retries: 0,
            last_step_time: None,
            missed_periods: 0,
            last_call: Instant::now(),
            is_deleted: Arc::default(),
        };
        let (request, ownership) = (session.request.clone(), session.ownership.clone());
        let is_deleted = Arc::clone(&session.is_deleted);
        let mut sessions = self.lock_active();
        if let Some((known, open)) = sessions.iter().find(|(_, open)| open.ownership.has_key_of(&ownership)) {
            let is_same = open.request == request && open.ownership.has_owner_of(&ownership);
            return if is_same {
                Ok(wire::CreatedController { id: known.to_string(), ..answer })
            } else {
                Err(ApiError::key_reused())
            };
        }
        if sessions.len() >= self.limit {
            return Err(ApiError::too_many_sessions(self.limit));
        }
        sessions.insert(id, Open { request, ownership, is_deleted, session: Arc::new(AsyncMutex::new(session)) });
        Ok(answer)
    }

    /// Replaces the controller of a session, after a step that is running.
    pub async fn replace(
        &self,
        id: &str,
        controller: PreparedController,
        client: &Owner,
    ) -> Result<wire::CreatedController, ApiError> {
        let mut session = self.active(id, self.find(id)?.lock_owned().await)?;
        session.ownership.owner.allow(client)?;
        let PreparedController { request, stepper, warnings } = controller;
        let warnings = session.control.replace(stepper, warnings)?;
        session.request = request;
        Ok(self.created(parse(id)?, session.control.controller(), warnings))
    }

    /// Tares a wrench sensor of a session, after a step that is running. The next state gets the bias.
    pub async fn tare(
        &self,
        id: &str,
        request: &wire::TareRequest,
        client: &Owner,
    ) -> Result<wire::TareAnswer, ApiError> {
        let mut session = self.active(id, self.find(id)?.lock_owned().await)?;
        session.ownership.owner.allow(client)?;
        let Session { control, request: controller, .. } = &mut *session;
        let (answer, tared) = control.tare(request, controller)?;
        session.request = tared;
        Ok(answer)
    }

    fn created(&self, id: Uuid, controller: &Controller, warnings: Vec<String>) -> wire::CreatedController {
        let joints = controller.config().robot.joints().iter().map(|joint| joint.name.clone()).collect();
        wire::CreatedController { id: id.to_string(), joints, idle_timeout_s: self.idle_timeout.as_secs(), warnings }
    }

    /// Ends idle sessions. They no longer use their robots.
    pub fn end_idle(&self) {
        drop(self.lock_active());
    }

    /// Ends idle sessions and returns the others.
    fn lock_active(&self) -> MutexGuard<'_, HashMap<Uuid, Open>> {
        let mut open = lock(&self.open);
        // A locked session is in use.
        let is_active = |session: &Session| session.last_call.elapsed() < self.idle_timeout;
        open.retain(|_, open| open.session.try_lock().map_or(true, |session| is_active(&session)));
        open
    }

    /// Answers a state of a session. A step above the budget runs in `workers`.
    pub async fn step(
        &self,
        id: &str,
        state: wire::State,
        client: &Owner,
        source: Source,
        workers: &Workers,
    ) -> Result<SharedAnswer, ApiError> {
        let now = Instant::now();
        let mut session = self.active(id, self.find(id)?.lock_owned().await)?;
        session.ownership.owner.allow(client)?;
        if price::of_controller(session.control.controller().config()) <= price::STEP_BUDGET {
            return session.answer(state, source, now, &self.metrics);
        }
        let metrics = Arc::clone(&self.metrics);
        workers.run(move |_| session.answer(state, source, now, &metrics)).await?
    }

    /// Refuses a client that may not step a session.
    pub async fn check_owner(&self, id: &str, client: &Owner) -> Result<(), ApiError> {
        self.with(id, |_, session| session.ownership.owner.allow(client)).await
    }

    /// Answers a state of a session in this thread, for runs in this process.
    pub fn step_here(&self, id: &str, state: wire::State) -> Result<SharedAnswer, ApiError> {
        let now = Instant::now();
        let mut session = self.active(id, self.find(id)?.blocking_lock_owned())?;
        session.answer(state, Source::Request, now, &self.metrics)
    }

    /// Runs `act` on a session, after a step that is running.
    pub async fn with<T>(
        &self,
        id: &str,
        act: impl FnOnce(Uuid, &mut Session) -> Result<T, ApiError>,
    ) -> Result<T, ApiError> {
        let mut session = self.active(id, self.find(id)?.lock_owned().await)?;
        act(parse(id)?, &mut session)
    }

    fn find(&self, id: &str) -> Result<SharedSession, ApiError> {
        let found = lock(&self.open).get(&parse(id)?).map(|open| Arc::clone(&open.session));
        found.ok_or_else(|| ApiError::unknown_controller(id))
    }

    /// Returns the session unless it has ended. The next call of `lock_active` removes it.
    fn active(&self, id: &str, session: OwnedMutexGuard<Session>) -> Result<OwnedMutexGuard<Session>, ApiError> {
        let is_deleted = session.is_deleted.load(Ordering::Acquire);
        let is_active = !is_deleted && session.last_call.elapsed() < self.idle_timeout;
        is_active.then_some(session).ok_or_else(|| ApiError::unknown_controller(id))
    }

    /// Ends a session, also while a step is running.
    pub fn delete(&self, id: &str, client: &Owner) -> Result<(), ApiError> {
        let key = parse(id)?;
        let mut open = lock(&self.open);
        let session = open.get(&key).ok_or_else(|| ApiError::unknown_controller(id))?;
        session.ownership.owner.allow(client)?;
        session.is_deleted.store(true, Ordering::Release);
        open.remove(&key);
        Ok(())
    }
}

/// Opens a session for a controller.
pub fn open_session(
    request: wire::Controller,
    ownership: Ownership,
    robots: &Robots,
    sessions: &Sessions,
) -> Result<wire::CreatedController, ApiError> {
    sessions.create(PreparedController::new(request, robots)?, ownership)
}

fn parse(id: &str) -> Result<Uuid, ApiError> {
    Uuid::try_parse(id).map_err(|_| ApiError::unknown_controller(id))
}

/// Ignores a panic of an earlier holder of the lock. After it, the counters or the memory of that session may contain a part
/// of the failed step; each value is still valid.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::platform::OperatingSystem;

    fn sessions() -> Sessions {
        Sessions::new(2, Duration::from_mins(15), Arc::new(Metrics::new()), Arc::new(OperatingSystem))
    }

    fn open(sessions: &Sessions) -> String {
        let request: wire::Controller =
            serde_json::from_str(include_str!("../../api/examples/controller.json")).unwrap();
        let controller = PreparedController::new(request, &Robots::built_in()).unwrap();
        sessions.create(controller, Ownership::default()).unwrap().id
    }

    fn state() -> wire::State {
        serde_json::from_str(include_str!("../../api/examples/state.json")).unwrap()
    }

    fn step(sessions: &Sessions, id: &str) -> Result<SharedAnswer, ApiError> {
        sessions.step_here(id, state())
    }

    /// Makes all sessions idle for the idle timeout.
    fn make_idle(sessions: &Sessions) {
        for open in lock(&sessions.open).values() {
            let mut session = open.session.try_lock().unwrap();
            session.last_call = session.last_call.checked_sub(sessions.idle_timeout).unwrap();
        }
    }

    #[test]
    fn an_idle_session_ends_and_another_can_open() {
        let sessions = sessions();
        let (idle, busy) = (open(&sessions), open(&sessions));
        make_idle(&sessions);
        lock(&sessions.open)[&parse(&busy).unwrap()].session.try_lock().unwrap().last_call = Instant::now();
        assert!(step(&sessions, &idle).unwrap_err().is_not_found());
        assert!(step(&sessions, &busy).is_ok());
        open(&sessions);
        assert_eq!(lock(&sessions.open).len(), 2);
    }

    #[test]
    fn states_keep_a_session_open_and_reads_do_not() {
        let sessions = sessions();
        let id = open(&sessions);
        let last_call = || lock(&sessions.open)[&parse(&id).unwrap()].session.try_lock().unwrap().last_call;
        let first = last_call();
        sessions.find(&id).unwrap().try_lock().unwrap().status(parse(&id).unwrap());
        assert_eq!(last_call(), first);
        step(&sessions, &id).unwrap();
        assert!(last_call() > first);
    }

    /// A step may wait for another one while the session is deleted.
    #[tokio::test]
    async fn a_call_that_waits_for_a_session_finds_it_deleted() {
        let sessions = sessions();
        let id = open(&sessions);
        let waiting = sessions.find(&id).unwrap();
        sessions.delete(&id, &Owner::default()).unwrap();
        assert!(sessions.active(&id, waiting.lock_owned().await).err().unwrap().is_not_found());
    }
}
