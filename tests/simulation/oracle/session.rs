//! What clients know about one session.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use revprio_api::wire::{self, JointVector};
use tokio::time::Instant;

use crate::call::Open;
use crate::controllers::Design;

/// Default of `state_checks.position_tolerance`, with a margin for rounding.
const ROUNDING: f64 = 1e-9;

/// Largest number in a request.
const MAX_MAGNITUDE: f64 = 1e9;

/// One session, as clients know it.
pub struct Session {
    pub design: Design,
    pub instance: u32,
    pub owner: Option<String>,
    pub key: Option<String>,
    /// Plausible states of clients that may step the session, in the order in which they were sent.
    pub sent: Vec<Arc<wire::State>>,
    /// Those of them without an answer.
    pub lost: Vec<Arc<wire::State>>,
    /// The answered steps by sequence number.
    pub accepted: BTreeMap<u64, (Arc<wire::State>, wire::StepAnswer)>,
    /// Number of answers that repeat an earlier one.
    pub retries: u64,
    /// Number of steps on their way.
    pub in_flight: u32,
    /// Number of requests to delete the session.
    pub deletions: u32,
    pub deleted_at: Option<Instant>,
    /// Clients that stepped the session.
    pub clients: BTreeSet<String>,
    /// Time of the answer that opened the session.
    pub known_at: Instant,
    /// Earliest and latest time that may be the session's last call.
    pub called_at_least: Instant,
    pub called_at_most: Instant,
    /// The number of steps that the service reported at the end.
    pub reported_steps: Option<u64>,
}

impl Session {
    /// Creates what is known of a session that a request, sent at a time, has opened.
    pub fn new(open: &Open, instance: u32, sent: Instant) -> Self {
        Self {
            design: open.design.clone(),
            instance,
            owner: open.owner.clone(),
            key: open.key.clone(),
            sent: Vec::new(),
            lost: Vec::new(),
            accepted: BTreeMap::new(),
            retries: 0,
            in_flight: 0,
            deletions: 0,
            deleted_at: None,
            clients: BTreeSet::new(),
            known_at: Instant::now(),
            called_at_least: sent,
            called_at_most: Instant::now(),
            reported_steps: None,
        }
    }

    /// Returns whether a request asks for a session with the same controller and owner.
    pub fn is_opened_by(&self, open: &Open) -> bool {
        self.owner == open.owner && self.design.wire == open.design.wire
    }

    /// Returns whether a client with this owner token may step the session.
    pub fn allows(&self, owner: Option<&String>) -> bool {
        self.owner.is_none() || self.owner.as_ref() == owner
    }

    /// Notes a state that is on its way; `None`: the service will not hear it.
    pub fn send(&mut self, state: Option<&Arc<wire::State>>, client: &str) {
        self.in_flight += 1;
        self.reported_steps = None;
        if let Some(state) = state.filter(|state| is_plausible(state, &self.design)) {
            self.clients.insert(client.to_owned());
            self.sent.push(Arc::clone(state));
        }
    }

    /// Notes that the answer to a state was lost.
    pub fn lose(&mut self, state: &Arc<wire::State>) {
        self.called_at_most = Instant::now() + Duration::from_secs(1);
        if self.sent.iter().any(|sent| Arc::ptr_eq(sent, state)) {
            self.lost.push(Arc::clone(state));
        }
    }

    /// Returns the highest sequence number of the answered steps.
    pub fn floor(&self) -> Option<u64> {
        self.accepted.last_key_value().map(|(sequence, _)| *sequence)
    }

    /// Returns whether requests to an instance cannot find the session any more.
    pub fn must_be_gone(&self, instance: u32, idle: Duration) -> bool {
        let is_idle = self.in_flight == 0 && Instant::now().saturating_duration_since(self.called_at_most) > idle;
        self.instance != instance || self.deleted_at.is_some() || is_idle
    }

    /// Returns whether the session cannot have ended.
    pub fn must_be_open(&self, instance: u32, idle: Duration) -> bool {
        self.instance == instance && !self.may_be_gone(idle)
    }

    /// Returns whether the session may have ended.
    pub fn may_be_gone(&self, idle: Duration) -> bool {
        self.deletions > 0 || Instant::now().saturating_duration_since(self.called_at_least) >= idle
    }

    /// Returns whether the session may have ended for another reason than this one request to delete it.
    pub fn may_be_gone_without(&self, idle: Duration) -> bool {
        self.deletions > 1 || self.called_at_least.elapsed() >= idle
    }

    /// Returns whether another state with at least this sequence number may have been stepped.
    pub fn may_be_late(&self, state: &wire::State) -> bool {
        self.sent.iter().any(|sent| sent.sequence >= state.sequence && **sent != *state)
    }
}

/// Returns whether the service must accept a state if its sequence number increases and no task overflows.
pub fn is_plausible(state: &wire::State, design: &Design) -> bool {
    let JointVector::Ordered(position) = &state.joint_position else { return false };
    let n = design.robot.joint_count();
    let has_velocity = |velocity: &JointVector| matches!(velocity, JointVector::Ordered(values) if values.len() == n);
    let checks = &design.wire.state_checks;
    let tolerance = if design.keeps_positions() { checks.position_tolerance + ROUNDING } else { f64::INFINITY };
    let is_inside = |(joint, &q): (&revprio_robot::Joint, &f64)| {
        (joint.limits.lower - tolerance..=joint.limits.upper + tolerance).contains(&q)
    };
    let is_force = |wrench: &wire::Wrench| {
        let within = |values: [f64; 3], max: f64| values.iter().all(|value| value.abs() <= max);
        within(wrench.force, checks.max_force_n.unwrap_or(MAX_MAGNITUDE)) && within(wrench.torque, MAX_MAGNITUDE)
    };
    state.sequence < 1 << 53
        && state.time_s.abs() <= MAX_MAGNITUDE
        && position.len() == n
        && design.robot.joints().iter().zip(position).all(is_inside)
        && state.joint_velocity.as_ref().is_none_or(has_velocity)
        && state.wrench.as_ref().map_or(!design.needs_wrench(), is_force)
}
