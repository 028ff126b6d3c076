//! One service thread for all connections compared with one per core, without pinning.

use revprio::service::{RunningServer, router};

use super::connection::Connection;
use super::subject::{Call, UnderTest, state_without_load_shedding};
use super::throughput::in_turns;
use crate::error::BenchError;
use crate::row::Row;
use crate::timing::{Budget, Subject, side_by_side};

/// Number of connections for the throughput.
const CONNECTIONS: usize = 64;

pub fn rows(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let one = UnderTest::start()?;
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let all = UnderTest::on(RunningServer::start_on(cores, &router(state_without_load_shedding()))?)?;
    let mut single = Connection::open(one.address, one.request(Call::Session))?;
    let mut spread = Connection::open(all.address, all.request(Call::Session))?;
    let times = side_by_side(
        budget,
        vec![
            Subject::fallible("session step, one service thread, anywhere", || Ok(single.call()?)),
            Subject::fallible("a service thread per core", || Ok(spread.call()?)),
        ],
    )?;
    let (mut single, mut spread) =
        (one.connections(CONNECTIONS, one.address)?, all.connections(CONNECTIONS, all.address)?);
    let [single, spread] = in_turns(budget, [&mut single, &mut spread])?;
    let name = format!("session steps, {CONNECTIONS} connections, one service thread, anywhere");
    let mut rows = Row::against_each(&times);
    rows.push(Row::of_rates(&name, single, "a service thread per core", spread));
    Ok(rows)
}
