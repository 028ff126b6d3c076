//! Speed of one or more concurrent simulations against one service.

use std::ops::ControlFlow;
use std::time::Instant;

use revprio::service::{AppState, Robots, RunningServer, router};
use revprio_api::Client;
use revprio_lab::simulator::{CallMode, Scenario, run};

use crate::error::BenchError;
use crate::plan::Plan;
use crate::row::Row;
use crate::series::{Growth, Series};
use crate::timing::Times;

const SIMULATIONS: [usize; 4] = [1, 2, 4, 8];

/// Simulated time of each concurrent simulation, as a share of the time of a single one.
const SHARE: f64 = 0.1;

/// Measures 20 s of `force_tracking` at 1 kHz, one call per period.
pub fn row(plan: &Plan) -> Result<Row, BenchError> {
    let simulated = plan.simulated_s();
    let elapsed = together(1, simulated)?;
    let row =
        Row::of_times(&Times::of(format!("{simulated} s of force_tracking at 1 kHz over HTTP"), vec![elapsed]), None);
    Ok(row.with_note(format!("{:.1} × real time, {:.0} calls/s", simulated / elapsed, 1000.0 * simulated / elapsed)))
}

/// Varies the number of simulations, each with its own thread and session.
pub fn side_by_side(plan: &Plan) -> Result<Growth, BenchError> {
    let simulated = SHARE * plan.simulated_s();
    let mut points = Vec::new();
    for count in plan.sizes(&SIMULATIONS) {
        points.push((count as f64, count as f64 * simulated / together(count, simulated)?));
    }
    Ok(Growth {
        name: "growth_simulations",
        title: "Simulated seconds per second over number of simulations",
        size: "simulations",
        value: "simulated seconds per second, all together",
        series: vec![Series::new("force_tracking at 1 kHz over HTTP", points)],
    })
}

/// Runs `count` simulations concurrently and returns the time, s.
fn together(count: usize, simulated_s: f64) -> Result<f64, BenchError> {
    let server = RunningServer::start(router(AppState::new(Robots::built_in())))?;
    let mut scenario = Scenario::find("force_tracking").map_err(BenchError::defect)?;
    scenario.duration_s = simulated_s;
    let (url, scenario, start) = (server.url(), &scenario, Instant::now());
    let simulate = || run(scenario, &Client::new(&url), CallMode::Session, |_| ControlFlow::Continue(())).map(drop);
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..count).map(|_| scope.spawn(simulate)).collect();
        threads.into_iter().try_for_each(|thread| match thread.join() {
            Ok(ended) => Ok(ended?),
            Err(_) => Err(BenchError::Defect("a simulation panicked".to_owned())),
        })
    })?;
    Ok(start.elapsed().as_secs_f64())
}
