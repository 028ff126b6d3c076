//! Times over the number of sessions and the size of a batch.

use serde_json::{Value, json};

use crate::error::BenchError;
use crate::http::connection::{Connection, Request};
use crate::http::subject::{Call, UnderTest};
use crate::plan::Plan;
use crate::series::{Growth, Series};
use crate::timing::{Subject, side_by_side};

const SESSIONS: [usize; 7] = [1, 3, 10, 30, 100, 300, 1000];
const ITEMS: [usize; 9] = [1, 3, 10, 30, 100, 300, 1000, 3000, 10_000];

/// One problem: about 0.4 KB.
const RESOLVE: &str = include_str!("../../../../api/examples/resolve.json");

/// Varies the number of sessions, called in turn on one connection.
pub fn sessions(plan: &Plan) -> Result<Growth, BenchError> {
    let service = UnderTest::start()?;
    let mut connection = Connection::open(service.address, service.request(Call::Session))?;
    let (mut requests, mut points) = (Vec::new(), Vec::new());
    for count in plan.sizes(&SESSIONS) {
        while requests.len() < count {
            requests.push(service.request_of(&service.another_session()?));
        }
        let mut next = (0..count).cycle();
        let step = || {
            let i = next.next().unwrap_or(0);
            Ok(connection.call_with(&mut requests[i])?)
        };
        let times = side_by_side(plan.points().stretched(2), vec![Subject::fallible("", step)])?;
        points.push((count as f64, times[0].median()));
    }
    Ok(Growth {
        name: "growth_sessions",
        title: "Step over HTTP over number of sessions, called in turn",
        size: "sessions",
        value: "round trip (s)",
        series: vec![Series::new("POST /v1/controllers/{id}/step", points)],
    })
}

/// Varies the number of problems, sent in one batch and in separate requests.
pub fn batch(plan: &Plan) -> Result<Growth, BenchError> {
    let service = UnderTest::start()?;
    let problem: Value = serde_json::from_str(RESOLVE).map_err(BenchError::defect)?;
    let single = Request::post("/v1/resolve", &problem.to_string());
    let mut one_by_one = Connection::open(service.address, single)?;
    let (mut batches, mut requests) = (Vec::new(), Vec::new());
    for count in plan.sizes(&ITEMS) {
        let body = json!({"items": vec![&problem; count]}).to_string();
        let mut connection = Connection::open(service.address, Request::post("/v1/resolve/batch", &body))?;
        let times = side_by_side(
            plan.points(),
            vec![
                Subject::fallible("", || Ok(connection.call()?)),
                Subject::fallible("", || (0..count).try_for_each(|_| Ok(one_by_one.call().map(drop)?))),
            ],
        )?;
        batches.push((count as f64, times[0].median()));
        requests.push((count as f64, times[1].median()));
    }
    Ok(Growth {
        name: "growth_batch",
        title: "Problems in one batch and in separate requests",
        size: "problems",
        value: "time until all are answered (s)",
        series: vec![
            Series::new("POST /v1/resolve/batch", batches),
            Series::new("POST /v1/resolve, one connection", requests),
        ],
    })
}
