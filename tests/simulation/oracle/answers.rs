//! What each answer must be.

use std::sync::Arc;
use std::time::Duration;

use revprio_api::wire;
use tokio::time::Instant;

use super::session::{Session, is_plausible};
use super::{OpeningState, Oracle, Sent};
use crate::call::{Call, Open};
use crate::controllers::Design;
use crate::http::Answer;
use crate::violation::Violation;

impl Oracle {
    pub(super) fn answered(
        &mut self,
        call: &Call,
        instance: u32,
        sent: &Sent,
        answer: &Answer,
    ) -> Result<(), Violation> {
        if answer.status == 503 && self.may_be_busy(call, answer) {
            if let Call::Step { session, state, .. } = call
                && let Some(session) = self.sessions.get_mut(session)
            {
                // A step that was abandoned may still have been made.
                session.lose(state);
            }
            return Ok(());
        }
        match call {
            Call::Open(open) => self.opened(open, instance, sent, answer),
            Call::Step { session, .. } => match self.sessions.get_mut(session) {
                Some(found) => stepped(found, call, instance, sent, answer, self.config.session_idle),
                None => expect(answer, &[404, 400, 422, 415]),
            },
            Call::Show { session } => self.shown(session, instance, sent, answer),
            Call::Delete { session, owner } => self.deleted((session, owner.as_ref()), instance, sent, answer),
            Call::List => expect(answer, &[200]),
            Call::Ready => expect(answer, &[200, 503]),
            Call::Other { status, .. } => expect(answer, &[*status]),
            Call::Once { .. } => expect(answer, &[200, 409, 422]),
        }
    }

    /// Returns whether the service may refuse a call because it has too much work.
    fn may_be_busy(&self, call: &Call, answer: &Answer) -> bool {
        match answer.problem().as_str() {
            "overloaded" => self.has_paused,
            "deadline" => match call {
                Call::Open(_) | Call::Once { .. } => true,
                Call::Step { session, .. } => self.sessions.get(session).is_some_and(|found| found.design.is_large),
                _ => false,
            },
            _ => false,
        }
    }

    fn opened(&mut self, open: &Open, instance: u32, sent: &Sent, answer: &Answer) -> Result<(), Violation> {
        match (answer.status, answer.problem().as_str()) {
            (201, _) => self.created(open, instance, sent, answer),
            (422, "key-reused") => {
                let idle = self.config.session_idle;
                let is_other = |session: &Session| !session.must_be_gone(instance, idle) && !session.is_opened_by(open);
                let has_other = self.with_key(open, instance).any(is_other);
                if has_other { Ok(()) } else { Err("the key was not used before".to_owned()) }
            }
            (503, "too-many-controllers") => {
                let most = self.open_at_most(instance, sent.at);
                if most >= self.config.max_sessions { Ok(()) } else { Err(format!("at most {most} sessions are open")) }
            }
            _ => expect(answer, &[201]),
        }
    }

    /// Judges the ID of a session. It is new, unless the request repeats the key of an open session.
    fn created(&mut self, open: &Open, instance: u32, sent: &Sent, answer: &Answer) -> Result<(), Violation> {
        let idle = self.config.session_idle;
        let created: wire::CreatedController = answer.read()?;
        let location = format!("/v1/controllers/{}", created.id);
        if answer.header("location") != Some(&location) {
            return Err(format!("the header `location` is not {location}"));
        }
        if let Some(known) = self.sessions.get(&created.id) {
            let is_repeated = known.instance == instance && open.key.is_some() && known.key == open.key;
            let is_right = is_repeated && known.is_opened_by(open);
            return if is_right { Ok(()) } else { Err(format!("session {} was opened twice", created.id)) };
        }
        if let Some(first) = self.with_key(open, instance).find(|session| session.must_be_open(instance, idle)) {
            return Err(format!("the key {:?} opened a second session", first.key));
        }
        let was_open = |session: &&Session| session.known_at <= sent.at && session.must_be_open(instance, idle);
        if self.sessions.values().filter(was_open).count() >= self.config.max_sessions {
            return Err(format!("{} sessions were open already", self.config.max_sessions));
        }
        self.explain_lost(open);
        self.sessions.insert(created.id, Session::new(open, instance, sent.at));
        Ok(())
    }

    /// Returns the sessions that the same key opened.
    fn with_key(&self, open: &Open, instance: u32) -> impl Iterator<Item = &Session> {
        let key = open.key.clone();
        let has_key = move |session: &&Session| session.instance == instance && key.is_some() && session.key == key;
        self.sessions.values().filter(has_key)
    }

    /// Notes that a lost request with the same key opened this session, if any did.
    fn explain_lost(&mut self, open: &Open) {
        for opening in &mut self.openings {
            if open.key.is_some() && opening.key == open.key && opening.state == OpeningState::Lost {
                opening.state = OpeningState::Done;
            }
        }
    }

    fn shown(&mut self, id: &str, instance: u32, sent: &Sent, answer: &Answer) -> Result<(), Violation> {
        let idle = self.config.session_idle;
        let Some(session) = self.sessions.get_mut(id) else { return expect(answer, &[404]) };
        check_found(session, instance, sent, answer, idle)?;
        if answer.status != 200 {
            return expect(answer, &[404]);
        }
        let status: wire::SessionStatus = answer.read()?;
        if status.id != id || status.controller != *session.design.wire {
            return Err("another controller is shown".to_owned());
        }
        if status.last_sequence < sent.floor || status.steps > session.sent.len() as u64 {
            return Err(format!("{status:?}, the last answered state was {:?}", sent.floor));
        }
        if session.in_flight == 0 {
            session.reported_steps = Some(status.steps);
            if status.retries < session.retries {
                return Err(format!("{} retries, not {}", status.retries, session.retries));
            }
        }
        Ok(())
    }

    fn deleted(
        &mut self,
        (id, owner): (&str, Option<&String>),
        instance: u32,
        sent: &Sent,
        answer: &Answer,
    ) -> Result<(), Violation> {
        let idle = self.config.session_idle;
        let Some(session) = self.sessions.get_mut(id) else { return expect(answer, &[404]) };
        match answer.status {
            403 if !session.allows(owner) => Ok(()),
            204 if !session.allows(owner) => Err("a stranger deleted the session".to_owned()),
            204 if session.deleted_at.is_some() || session.instance != instance => Err("deleted twice".to_owned()),
            204 => {
                session.deleted_at = Some(Instant::now());
                Ok(())
            }
            404 if sent.was_gone || session.may_be_gone_without(idle) => Ok(()),
            404 if !session.allows(owner) && session.may_be_gone(idle) => Ok(()),
            _ => expect(answer, &[204]),
        }
    }
}

/// Judges the answer to a state.
fn stepped(
    session: &mut Session,
    call: &Call,
    instance: u32,
    sent: &Sent,
    answer: &Answer,
    idle: Duration,
) -> Result<(), Violation> {
    let Call::Step { state, owner, fault, .. } = call else { return Ok(()) };
    if let Some(fault) = fault {
        return expect(answer, &[fault.status()]);
    }
    check_found(session, instance, sent, answer, idle)?;
    if answer.status == 404 {
        return Ok(());
    }
    if !session.allows(owner.as_ref()) {
        return expect(answer, &[403]);
    }
    if !is_plausible(state, &session.design) {
        return expect(answer, &[422]);
    }
    session.called_at_least = session.called_at_least.max(sent.at);
    session.called_at_most = session.called_at_most.max(Instant::now());
    match answer.status {
        200 => accepted(session, state, sent, answer.read()?),
        409 if answer.problem() == "sequence" => {
            if session.may_be_late(state) {
                Ok(())
            } else {
                Err("no state has such a sequence number".to_owned())
            }
        }
        _ => expect(answer, &[200]),
    }
}

/// Judges a joint velocity.
fn accepted(
    session: &mut Session,
    state: &Arc<wire::State>,
    sent: &Sent,
    answer: wire::StepAnswer,
) -> Result<(), Violation> {
    if sent.floor.is_some_and(|floor| state.sequence < floor) {
        return Err(format!("sequence {} was accepted after {:?}", state.sequence, sent.floor));
    }
    if let Some((known, first)) = session.accepted.get(&state.sequence) {
        if **known != **state {
            return Err(format!("two states were accepted with the sequence number {}", state.sequence));
        }
        if *first != answer {
            return Err(format!("the repeated state got another answer: {answer:?}, first {first:?}"));
        }
        session.retries += 1;
        return Ok(());
    }
    check_command(&session.design, state, &answer)?;
    session.lost.retain(|lost| **lost != **state);
    session.accepted.insert(state.sequence, (Arc::clone(state), answer));
    Ok(())
}

/// Checks a command against the limits of the robot.
fn check_command(design: &Design, state: &wire::State, answer: &wire::StepAnswer) -> Result<(), Violation> {
    let joints = design.robot.joints();
    if answer.sequence != state.sequence || answer.joint_velocity.len() != joints.len() {
        return Err(format!("the answer belongs to another state: {answer:?}"));
    }
    if answer.valid_for_ms > design.wire.valid_for_ms || answer.memory.is_some() {
        return Err(format!("valid for {} ms", answer.valid_for_ms));
    }
    let obeys = design.wire.solver != wire::Solver::ClosedForm;
    for (joint, &velocity) in joints.iter().zip(&answer.joint_velocity) {
        let limit = joint.limits.velocity * (1.0 + 1e-9);
        if !velocity.is_finite() || (obeys && velocity.abs() > limit) {
            return Err(format!("joint {} gets {velocity}, its limit is {}", joint.name, joint.limits.velocity));
        }
    }
    Ok(())
}

/// Checks that a session is found if it must be, and not if it must not be.
fn check_found(
    session: &Session,
    instance: u32,
    sent: &Sent,
    answer: &Answer,
    idle: Duration,
) -> Result<(), Violation> {
    match answer.status {
        404 if sent.was_gone || session.may_be_gone(idle) || session.instance != instance => {
            if answer.problem() == "unknown-controller" { Ok(()) } else { Err(answer.problem()) }
        }
        404 => Err("the session is open".to_owned()),
        _ if sent.was_gone => Err(format!("the session has ended, but the status is {}", answer.status)),
        _ => Ok(()),
    }
}

fn expect(answer: &Answer, statuses: &[u16]) -> Result<(), Violation> {
    if statuses.contains(&answer.status) {
        return Ok(());
    }
    Err(format!("status {} instead of {statuses:?}: {}", answer.status, String::from_utf8_lossy(&answer.body)))
}
