//! A client that uses the sessions of others: with a wrong owner token, or next to their own client.

use std::sync::Arc;

use super::pilot::wild_state;
use crate::call::Call;
use crate::exchange::{Client, Fate};

pub async fn run(client: &mut Client) {
    let mut link = None;
    client.pause(5, 80).await;
    for _ in 0..client.random.from(2, 10) {
        client.pause(0, 40).await;
        let instance = client.world.instance().number;
        let mut sessions = client.world.oracle().known(instance);
        sessions.push(client.random.word());
        let session = client.random.pick(&sessions);
        let call = match client.random.below(12) {
            0 => {
                let owner = owner(client, &session);
                Call::Delete { session, owner }
            }
            1 => Call::Show { session },
            2 => Call::List,
            _ => step(client, session),
        };
        let fate = if client.random.one_in(8) { Fate::DiesWaiting } else { Fate::Undisturbed };
        client.exchange(&mut link, vec![call], fate).await;
    }
}

/// Returns no owner token, a wrong one, or the right one.
fn owner(client: &mut Client, session: &str) -> Option<String> {
    let owner = client.world.oracle().sessions.get(session).and_then(|known| known.owner.clone());
    match client.random.below(6) {
        0 => owner,
        1 => Some(client.random.word()),
        // Almost the right one.
        2 => owner.map(|owner| owner[..owner.len() - 1].to_owned()),
        _ => None,
    }
}

/// A step with some owner token.
fn step(client: &mut Client, session: String) -> Call {
    let (design, last) = {
        let oracle = client.world.oracle();
        let last = oracle.last_state(&session).map_or(0, |state| state.sequence);
        (oracle.sessions.get(&session).map(|known| known.design.clone()), last)
    };
    let owner = owner(client, &session);
    let random = &mut client.random;
    let design = design.unwrap_or_else(|| crate::controllers::Design::random(random));
    let sequence = last.saturating_add(random.from(0, 3)).saturating_sub(1);
    let state = Arc::new(wild_state(&design, sequence, random));
    Call::Step { session, owner, state, fault: None }
}
