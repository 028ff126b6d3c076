//! The reference: a controller of the library that gets the accepted states of a session in order, without a service.
//!
//! Each answer must be equal to the last bit. This finds states that were stepped twice, refused states that changed the
//! controller, and sessions that share memory. A state whose answer was lost may have been stepped or not: one choice must
//! explain all answers.

use std::sync::Arc;

use revprio_api::wire;
use revprio_core::controller::Memory;

use super::session::Session;
use crate::reference::Reference;
use crate::violation::Violation;

/// Maximum number of steps of one search.
const MAX_STEPS: u32 = 100_000;

/// The search for the states that were stepped.
struct Search<'a> {
    reference: Reference,
    accepted: Vec<&'a (Arc<wire::State>, wire::StepAnswer)>,
    lost: Vec<&'a wire::State>,
    /// Number of all steps, if the service reported it.
    steps: Option<u64>,
    work: u32,
    /// Difference at the last accepted state that was reached.
    difference: (usize, Violation),
}

/// Where a search is.
#[derive(Clone)]
struct Place {
    accepted: usize,
    lost: usize,
    sequence: Option<u64>,
    steps: u64,
    memory: Option<Memory>,
}

/// Repeats a session.
pub fn check(id: &str, session: &Session) -> Result<(), Violation> {
    let mut lost: Vec<&wire::State> = session.lost.iter().map(|state| &**state).collect();
    lost.sort_by_key(|state| state.sequence);
    lost.dedup();
    let mut search = Search {
        reference: Reference::new(&session.design),
        accepted: session.accepted.values().collect(),
        lost,
        steps: session.reported_steps,
        work: 0,
        difference: (0, format!("{:?} steps were reported", session.reported_steps)),
    };
    let start = Place { accepted: 0, lost: 0, sequence: None, steps: 0, memory: None };
    if search.explains(start) {
        return Ok(());
    }
    let (_, difference) = search.difference;
    Err(format!("session {id} differs from the reference ({} lost states): {difference}", search.lost.len()))
}

impl Search<'_> {
    /// Returns whether some choice of lost states explains the rest of the answers.
    fn explains(&mut self, place: Place) -> bool {
        let next_lost = self.lost.get(place.lost).copied();
        let next = self.accepted.get(place.accepted).copied();
        if let Some(state) = next_lost.filter(|lost| next.is_none_or(|(state, _)| lost.sequence <= state.sequence)) {
            let skipped = Place { lost: place.lost + 1, ..place.clone() };
            let is_possible = place.sequence < Some(state.sequence);
            return self.explains(skipped) || (is_possible && self.explains_with(&place, state));
        }
        let Some((state, answer)) = next else { return self.steps.is_none_or(|steps| steps == place.steps) };
        if place.sequence >= Some(state.sequence) {
            return false;
        }
        let mut memory = place.memory;
        if let Err(difference) = self.step(&mut memory, state, Some(answer)) {
            if place.accepted >= self.difference.0 {
                self.difference = (place.accepted, format!("sequence {}: {difference}", state.sequence));
            }
            return false;
        }
        let sequence = Some(state.sequence);
        self.explains(Place { accepted: place.accepted + 1, sequence, steps: place.steps + 1, memory, ..place })
    }

    /// Returns whether the rest is explained if this lost state was stepped.
    fn explains_with(&mut self, place: &Place, state: &wire::State) -> bool {
        let mut memory = place.memory.clone();
        if self.step(&mut memory, state, None).is_err() {
            return false;
        }
        let sequence = Some(state.sequence);
        self.explains(Place {
            accepted: place.accepted,
            lost: place.lost + 1,
            sequence,
            steps: place.steps + 1,
            memory,
        })
    }

    fn step(
        &mut self,
        memory: &mut Option<Memory>,
        state: &wire::State,
        answer: Option<&wire::StepAnswer>,
    ) -> Result<(), Violation> {
        self.work += 1;
        assert!(self.work < MAX_STEPS, "too many lost states");
        self.reference.step(memory, state, answer)
    }
}
