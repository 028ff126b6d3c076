//! The oracle: what every answer must be, derived from the documentation and from what the clients sent.
//!
//! The oracle knows only what clients can know. If two requests are on their way at the same time, either may be first.
//! It therefore knows for each session which states may have been stepped and which must have been.

mod answers;
mod replay;
mod session;

use std::collections::BTreeMap;
use std::sync::Arc;

use revprio::service::ServiceConfig;
use revprio_api::wire;
use tokio::time::Instant;

use crate::call::{Call, Open};
use crate::http::Answer;
use crate::violation::Violation;
use session::Session;

/// Everything that clients know together.
pub struct Oracle {
    config: ServiceConfig,
    /// Whether the clock of the service jumped, so that it may say that it is overloaded.
    pub has_paused: bool,
    pub sessions: BTreeMap<String, Session>,
    /// Requests to open a session without an answer, by instance: key, and whether it is still on its way.
    openings: Vec<Opening>,
}

/// A request to open a session.
struct Opening {
    instance: u32,
    key: Option<String>,
    state: OpeningState,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum OpeningState {
    OnItsWay,
    /// It may have opened a session whose ID nobody knows.
    Lost,
    /// Answered, or never complete.
    Done,
}

/// What was known when a call was sent.
pub struct Sent {
    at: Instant,
    /// Highest sequence number of the session's answered steps.
    floor: Option<u64>,
    /// Whether the session must be gone already.
    was_gone: bool,
    opening: Option<usize>,
}

/// How a call ended.
pub enum End<'a> {
    Answered(&'a Answer),
    /// The whole request may have arrived.
    Lost,
    /// The request never arrived completely.
    Incomplete,
}

impl Oracle {
    pub fn new(config: ServiceConfig) -> Self {
        Self { config, has_paused: false, sessions: BTreeMap::new(), openings: Vec::new() }
    }

    /// Notes that a client sends a call to an instance of the service.
    pub fn sent(&mut self, call: &Call, instance: u32, client: &str) -> Sent {
        let idle = self.config.session_idle;
        let mut sent = Sent { at: Instant::now(), floor: None, was_gone: true, opening: None };
        match call {
            Call::Open(Open { key, .. }) => {
                sent.opening = Some(self.openings.len());
                self.openings.push(Opening { instance, key: key.clone(), state: OpeningState::OnItsWay });
            }
            Call::Step { session, state, owner, fault } => {
                if let Some(session) = self.sessions.get_mut(session) {
                    sent.was_gone = session.must_be_gone(instance, idle);
                    sent.floor = session.floor();
                    let is_heard = fault.is_none() && session.allows(owner.as_ref()) && session.instance == instance;
                    session.send(is_heard.then_some(state), client);
                }
            }
            Call::Show { session } | Call::Delete { session, .. } => {
                if let Some(session) = self.sessions.get_mut(session) {
                    sent.was_gone = session.must_be_gone(instance, idle);
                    sent.floor = session.floor();
                    let deletes = matches!(call, Call::Delete { owner, .. } if session.allows(owner.as_ref()));
                    session.deletions += u32::from(deletes && session.instance == instance);
                }
            }
            Call::List | Call::Ready | Call::Other { .. } | Call::Once { .. } => (),
        }
        sent
    }

    /// Judges the end of a call.
    pub fn ended(&mut self, call: &Call, instance: u32, sent: &Sent, end: &End) -> Result<(), Violation> {
        if let Call::Step { session, state, .. } = call
            && let Some(session) = self.sessions.get_mut(session)
        {
            session.in_flight -= 1;
            if matches!(end, End::Lost) && session.instance == instance {
                session.lose(state);
            }
        }
        if let Some(opening) = sent.opening {
            let lost = if matches!(end, End::Lost) { OpeningState::Lost } else { OpeningState::Done };
            self.openings[opening].state = lost;
        }
        match end {
            End::Answered(answer) => self.answered(call, instance, sent, answer),
            End::Lost | End::Incomplete => Ok(()),
        }
    }

    /// Returns the IDs of the sessions that may be open on an instance.
    pub fn known(&self, instance: u32) -> Vec<String> {
        let open =
            self.sessions.iter().filter(|(_, session)| session.instance == instance && session.deleted_at.is_none());
        open.map(|(id, _)| id.clone()).collect()
    }

    /// Returns the maximum number of sessions that an instance may have had since a time. The answer to a request may come
    /// after that to the deletion of a session which was open when the request was refused.
    fn open_at_most(&self, instance: u32, since: Instant) -> usize {
        let idle = self.config.session_idle;
        let was_open = |session: &Session| session.instance == instance && session.deleted_at >= Some(since);
        let may_be_open = |session: &&Session| !session.must_be_gone(instance, idle) || was_open(session);
        let known = self.sessions.values().filter(may_be_open).count();
        known + self.unknown(instance)
    }

    /// Returns the number of sessions that may be open although no client knows their IDs.
    fn unknown(&self, instance: u32) -> usize {
        let is_open = |opening: &&Opening| opening.instance == instance && opening.state != OpeningState::Done;
        self.openings.iter().filter(is_open).count()
    }

    /// Compares the list of all sessions with what the clients know, while nothing is on its way.
    pub fn check_list(&self, list: &wire::SessionList, instance: u32) -> Result<(), Violation> {
        let idle = self.config.session_idle;
        let listed = |id: &String| list.controllers.iter().any(|entry| entry.id == *id);
        for (id, session) in &self.sessions {
            if session.must_be_open(instance, idle) && !listed(id) {
                return Err(format!("session {id} is not in the list"));
            }
            if session.deleted_at.is_some() && session.instance == instance && listed(id) {
                return Err(format!("session {id} was deleted and is in the list"));
            }
        }
        let unknown = list.controllers.iter().filter(|entry| !self.sessions.contains_key(&entry.id)).count();
        if unknown > self.unknown(instance) || list.controllers.len() > self.config.max_sessions {
            return Err(format!("{unknown} sessions of {} were opened by nobody", list.controllers.len()));
        }
        Ok(())
    }

    /// Repeats every session without disturbance.
    pub fn replay(&self) -> Result<(), Violation> {
        self.sessions.iter().try_for_each(|(id, session)| replay::check(id, session))
    }

    /// Returns whether an instance may answer that it does not know a session.
    pub fn may_be_gone(&self, session: &str, instance: u32) -> bool {
        let may_be_gone =
            |session: &Session| session.instance != instance || session.may_be_gone(self.config.session_idle);
        self.sessions.get(session).is_none_or(may_be_gone)
    }

    /// Returns whether only this client ever stepped a session.
    pub fn is_used_by_one(&self, session: &str) -> bool {
        self.sessions.get(session).is_none_or(|session| session.clients.len() <= 1)
    }

    /// Returns the state of the last answered step.
    pub fn last_state(&self, session: &str) -> Option<Arc<wire::State>> {
        self.sessions.get(session)?.accepted.last_key_value().map(|(_, (state, _))| Arc::clone(state))
    }
}
