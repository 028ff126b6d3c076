//! A control loop over HTTP, with everything that goes wrong between a client and the service.

use std::sync::Arc;
use std::time::Duration;

use super::pilot::{Measured, Pilot};
use crate::call::{Call, Fault};
use crate::exchange::{Client, Fate, Link};
use crate::http::Answer;

/// What the client does in one period.
#[derive(Debug, Clone, Copy)]
enum Act {
    Step,
    /// Sends the state on two connections at the same time.
    StepTwice,
    /// Sends two states on two connections, so that the second may overtake the first.
    Overtake,
    /// Sends the state between other requests, without waiting for their answers.
    Pipeline,
    /// The connection dies.
    Die(Fate),
    /// Reads the answer late.
    ReadLate,
    /// Sends a state that must be refused.
    Refused,
    /// Sends a body that cannot be read.
    Broken,
    /// Sends a state that nobody measured.
    Wild,
    /// Asks for the session, for all sessions, for readiness.
    Look,
    OpenAgain,
    Delete,
    /// Does nothing for seconds.
    Sleep,
}

const ACTS: [(u32, Act); 14] = [
    (16, Act::Step),
    (3, Act::StepTwice),
    (3, Act::Overtake),
    (3, Act::Pipeline),
    (2, Act::Die(Fate::DiesSending)),
    (3, Act::Die(Fate::DiesWaiting)),
    (1, Act::ReadLate),
    (5, Act::Refused),
    (2, Act::Broken),
    (1, Act::Wild),
    (2, Act::Look),
    (1, Act::OpenAgain),
    (1, Act::Delete),
    (1, Act::Sleep),
];

pub async fn run(client: &mut Client) {
    let (mut pilot, mut link) = (Pilot::new(&mut client.random), None);
    client.pause(0, 30).await;
    for _ in 0..client.random.from(4, 16) {
        if pilot.session.is_none() && !pilot.open(client, &mut link).await {
            client.pause(100, 3000).await;
            continue;
        }
        let act = client.random.weighted(&ACTS);
        perform(client, &mut pilot, &mut link, act).await;
        client.pause(0, 8).await;
    }
}

async fn perform(client: &mut Client, pilot: &mut Pilot, link: &mut Option<Link>, act: Act) {
    match act {
        Act::Step => step(client, pilot, link, Fate::Undisturbed).await,
        Act::StepTwice => step_twice(client, pilot, link).await,
        Act::Overtake => overtake(client, pilot, link).await,
        Act::Pipeline => pipeline(client, pilot, link).await,
        Act::Die(fate) => step(client, pilot, link, fate).await,
        Act::ReadLate => {
            let pause =
                client.random.pick(&[Duration::from_millis(5), Duration::from_secs(3), Duration::from_secs(20)]);
            step(client, pilot, link, Fate::ReadsLate(pause)).await;
        }
        Act::Refused => refused(client, pilot, link).await,
        Act::Broken => broken(client, pilot, link).await,
        Act::Wild => {
            let state = pilot.wild_state(&mut client.random);
            let call = pilot.step(&state);
            client.call(link, call).await;
        }
        Act::Look => look(client, pilot, link).await,
        Act::OpenAgain => pilot.open_again(client, link).await,
        Act::Delete => {
            let (session, owner) = (pilot.session.clone().unwrap_or_default(), pilot.owner());
            client.call(link, Call::Delete { session, owner }).await;
            if client.random.one_in(2) {
                pilot.forget();
            }
        }
        Act::Sleep => client.pause(500, 4000).await,
    }
}

/// Sends a measured state. If the answer is lost, sends the same state again.
async fn step(client: &mut Client, pilot: &mut Pilot, link: &mut Option<Link>, fate: Fate) {
    let measured = pilot.measure(client).await;
    let answer = client.exchange(link, vec![pilot.step(&measured.state)], fate).await.pop().flatten();
    settle(client, pilot, link, &measured, answer).await;
}

async fn settle(
    client: &mut Client,
    pilot: &mut Pilot,
    link: &mut Option<Link>,
    measured: &Measured,
    answer: Option<Answer>,
) {
    let answer = match answer {
        None if client.random.one_in(4) => None,
        None => client.call(link, pilot.step(&measured.state)).await,
        answer => answer,
    };
    match answer {
        Some(answer) => pilot.settle(client, measured, &answer),
        None => pilot.miss(),
    }
}

async fn step_twice(client: &mut Client, pilot: &mut Pilot, link: &mut Option<Link>) {
    let measured = pilot.measure(client).await;
    let (mut twin, mut other) = (client.twin(), None);
    let (first, second) = tokio::join!(
        client.call(link, pilot.step(&measured.state)),
        twin.call(&mut other, pilot.step(&measured.state)),
    );
    settle(client, pilot, link, &measured, first.or(second)).await;
}

/// The service may step both states or only the second one.
async fn overtake(client: &mut Client, pilot: &mut Pilot, link: &mut Option<Link>) {
    let (first, second) = (pilot.measure(client).await, pilot.measure(client).await);
    let (mut twin, mut other) = (client.twin(), None);
    let late = async {
        twin.pause(0, 4).await;
        twin.call(&mut other, pilot.step(&first.state)).await
    };
    let (answer, _) = tokio::join!(client.call(link, pilot.step(&second.state)), late);
    if answer.is_some_and(|answer| answer.status == 404) {
        return pilot.forget();
    }
    pilot.catch_up(client);
}

async fn pipeline(client: &mut Client, pilot: &mut Pilot, link: &mut Option<Link>) {
    let measured = pilot.measure(client).await;
    let session = pilot.session.clone().unwrap_or_default();
    let other = |client: &mut Client| match client.random.below(4) {
        0 => Call::Show { session: session.clone() },
        1 => Call::Other { method: "GET", path: "/healthz", host: "localhost", status: 200 },
        2 => Call::Other { method: "GET", path: "/nothing", host: "localhost", status: 404 },
        _ => pilot.step(&measured.state),
    };
    let before = client.random.below(3);
    let mut calls: Vec<Call> = (0..before).map(|_| other(client)).collect();
    calls.push(pilot.step(&measured.state));
    calls.extend((0..client.random.below(3)).map(|_| other(client)));
    let mut answers = client.exchange(link, calls, Fate::Undisturbed).await;
    let answer = answers.swap_remove(before);
    settle(client, pilot, link, &measured, answer).await;
}

/// The oracle knows whether the state must be refused, and how.
async fn refused(client: &mut Client, pilot: &mut Pilot, link: &mut Option<Link>) {
    let last = client.world.oracle().last_state(pilot.session.as_deref().unwrap_or_default());
    let Some(last) = last else { return step(client, pilot, link, Fate::Undisturbed).await };
    let state = Arc::new(pilot.refused_state(&mut client.random, &last));
    let answer = client.call(link, pilot.step(&state)).await;
    if answer.is_none_or(|answer| answer.status == 200) {
        pilot.catch_up(client);
    }
}

async fn broken(client: &mut Client, pilot: &mut Pilot, link: &mut Option<Link>) {
    let measured = pilot.measure(client).await;
    let fault = client.random.pick(&[Fault::Syntax, Fault::Infinite, Fault::Missing, Fault::MediaType]);
    let call = Call::Step {
        session: pilot.session.clone().unwrap_or_default(),
        owner: pilot.owner(),
        state: measured.state,
        fault: Some(fault),
    };
    client.call(link, call).await;
}

async fn look(client: &mut Client, pilot: &Pilot, link: &mut Option<Link>) {
    let session = pilot.session.clone().unwrap_or_default();
    let call = client.random.pick(&[Call::Show { session }, Call::List, Call::Ready]);
    client.call(link, call).await;
}
