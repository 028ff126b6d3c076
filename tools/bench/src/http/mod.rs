//! The service over HTTP and WebSocket, compared with a bare route and a bare TCP connection with the same bytes.

mod affinity;
pub mod connection;
mod peers;
mod service_threads;
pub mod subject;
mod throughput;
mod websocket;

use super::error::BenchError;
use super::row::Row;
use super::timing::{Budget, Subject, side_by_side};
use connection::Connection;
use subject::{Call, UnderTest};

pub use affinity::Pinned;
pub use peers::{Echo, ping_pong};

/// Returns a row per measurement and peer.
pub fn rows(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let mut rows = Vec::new();
    for (cores, client) in [("one core", 0), ("two cores", 1)] {
        for call in [Call::Stateless, Call::Session] {
            rows.extend(round_trips(budget, call, cores, client)?);
        }
    }
    rows.extend(websocket::rows(budget)?);
    rows.extend(throughput::rows(budget)?);
    rows.extend(service_threads::rows(budget)?);
    Ok(rows)
}

/// Measures round trips on one connection.
fn round_trips(budget: Budget, call: Call, cores: &str, client: usize) -> Result<Vec<Row>, BenchError> {
    let pinned = Pinned::to(0);
    let service = UnderTest::start()?;
    let (request, answer) = (service.request(call), service.answer_length(call)?);
    let echo = Echo::start(service.parsed_answer(Call::Stateless)?, service.parsed_answer(Call::Session)?)?;
    let bare = ping_pong(request.length(), answer)?;
    drop(pinned);
    let _pinned = Pinned::to(client);
    let mut ours = Connection::open(service.address, request.clone())?;
    let mut echoed = Connection::open(echo.address, request.clone())?;
    let mut bounced = Connection::open(bare, request)?;
    let times = side_by_side(
        budget,
        vec![
            Subject::fallible(format!("POST {}, {cores}", call.route()), || Ok(ours.call()?)),
            Subject::fallible("axum + serde_json that answers the same bodies", || Ok(echoed.call()?)),
            Subject::fallible("TCP ping-pong of the same bytes", || Ok(bounced.call_bytes(answer)?)),
        ],
    )?;
    Ok(Row::against_each(&times))
}
