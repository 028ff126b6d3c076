//! Requests per second over several connections. Server and client have one core each.

use std::time::{Duration, Instant};

use super::affinity::Pinned;
use super::connection::Connection;
use super::peers::Echo;
use super::subject::{Call, UnderTest};
use crate::error::BenchError;
use crate::row::Row;
use crate::timing::{Budget, Times};

const CONNECTIONS: [usize; 3] = [1, 8, 64];

/// Length of a turn relative to turns of single calls.
const STRETCH: u32 = 5;

/// Measures session steps per second, compared with the bare route.
pub fn rows(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let pinned = Pinned::to(0);
    let service = UnderTest::start()?;
    let echo = Echo::start(service.parsed_answer(Call::Stateless)?, service.parsed_answer(Call::Session)?)?;
    drop(pinned);
    let _pinned = Pinned::to(1);
    let mut rows = Vec::new();
    for count in CONNECTIONS {
        let (mut ours, mut bare) =
            (service.connections(count, service.address)?, service.connections(count, echo.address)?);
        let [ours, bare] = in_turns(budget, [&mut ours, &mut bare])?;
        let name = format!("session steps, {count} connection{}", if count == 1 { "" } else { "s" });
        rows.push(Row::of_rates(&name, ours, "axum + serde_json", bare));
    }
    Ok(rows)
}

/// Returns the median rates of two sets of connections, measured alternately.
pub fn in_turns(budget: Budget, both: [&mut [Connection]; 2]) -> Result<[f64; 2], BenchError> {
    let mut turns = [Vec::new(), Vec::new()];
    let [first, second] = both;
    for _ in 0..budget.turns {
        turns[0].push(rate(first, budget.turn * STRETCH)?);
        turns[1].push(rate(second, budget.turn * STRETCH)?);
    }
    Ok(turns.map(|turns| Times::of("", turns).median()))
}

/// Returns answers per second; every connection always has one request in progress.
fn rate(connections: &mut [Connection], length: Duration) -> Result<f64, BenchError> {
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
