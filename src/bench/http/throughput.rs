//! Requests per second from several connections, each of which waits for its answers; server and load have a core each.

use std::time::{Duration, Instant};

use super::affinity::Pinned;
use super::connection::Connection;
use super::peers::Echo;
use super::subject::{Call, UnderTest};
use crate::bench::BenchError;
use crate::bench::row::Row;
use crate::bench::timing::{Budget, Times};

const CONNECTIONS: [usize; 3] = [1, 8, 64];

/// Turns are this many times as long as those of a single call.
const STRETCH: u32 = 5;

/// Session steps per second beside the bare route, and stateless ones.
pub fn rates(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let pinned = Pinned::to(0);
    let service = UnderTest::start()?;
    let echo = Echo::start(service.parsed_answer(Call::Stateless)?, service.parsed_answer(Call::Session)?)?;
    drop(pinned);
    let _pinned = Pinned::to(1);
    let mut rows = Vec::new();
    for count in CONNECTIONS {
        let requests = (0..count).map(|_| Ok(service.request_of(&service.another_session()?)));
        let requests = requests.collect::<Result<Vec<_>, BenchError>>()?;
        let open = |address| {
            let open = |request| Ok(Connection::open(address, request)?);
            requests.iter().cloned().map(open).collect::<Result<Vec<_>, BenchError>>()
        };
        let (mut ours, mut bare) = (open(service.address)?, open(echo.address)?);
        let (mut own_turns, mut bare_turns) = (Vec::new(), Vec::new());
        for _ in 0..budget.turns {
            own_turns.push(rate(&mut ours, budget.turn * STRETCH)?);
            bare_turns.push(rate(&mut bare, budget.turn * STRETCH)?);
        }
        let (ours, bare) = (Times::of("", own_turns).median(), Times::of("", bare_turns).median());
        let name = format!("session steps, {count} connection{}", if count == 1 { "" } else { "s" });
        rows.push(Row::of_rates(&name, ours, "axum + serde_json", bare));
    }
    Ok(rows)
}

/// Answers per second: one request of every connection is under way all the time.
pub fn rate(connections: &mut [Connection], length: Duration) -> Result<f64, BenchError> {
    connections.iter_mut().try_for_each(Connection::send)?;
    let start = Instant::now();
    let mut answers = 0_u32;
    while start.elapsed() < length {
        for connection in connections.iter_mut() {
            connection.receive()?;
            connection.send()?;
            answers += 1;
        }
    }
    let elapsed = start.elapsed();
    connections.iter_mut().try_for_each(|connection| connection.receive().map(drop))?;
    Ok(f64::from(answers) / elapsed.as_secs_f64())
}
