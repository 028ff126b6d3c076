//! `revprio-bench load`: the behaviour of a server with more requests than it can answer.
//!
//! The server is a child process. Its capacity is the rate at which it answers some unpaced clients. Then more clients, each
//! with its own connection and period like control loops, offer this rate and multiples of it. Last, the capacity is offered
//! again together with clients that stop in the middle of a request. A client waits for an answer before it sends the next
//! request; periods that pass while it waits are missed.

mod beside;
mod client;
mod requests;
mod server;
mod tally;

use std::io::{Write as _, stdout};
use std::time::{Duration, Instant};

use self::client::{Pace, Request, send_until};
use self::requests::{STEP, half_requests};
use self::server::Server;
use self::tally::Tally;
use crate::error::BenchError;

/// Largest growth of the memory of the server, MiB: connections with their buffers, and histograms.
const MAX_MEMORY_GROWTH_MIB: f64 = 128.0;

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Duration of each run, s, at most 60
    #[arg(long, default_value_t = 5)]
    seconds: u64,
    /// Number of clients that together offer the capacity of the server, at most 100
    #[arg(long, default_value_t = 50)]
    clients: usize,
    /// Number of clients that send only half a request, at most 4000
    #[arg(long, default_value_t = 1000)]
    slow: usize,
    /// Multiples of the capacity, at most 20
    #[arg(long, value_delimiter = ',', default_values_t = [1, 2, 10])]
    times: Vec<usize>,
    /// Measure one 100 Hz control loop next to clients that keep the server busy, instead
    #[arg(long)]
    beside: bool,
}

/// Runs the load test. It fails if an answer is neither 200 nor 503 with Retry-After, if `/healthz` does not answer, or if
/// the memory grows too much.
pub fn run(options: &Options) -> Result<(), BenchError> {
    let duration = Duration::from_secs(options.seconds.clamp(1, 60));
    if options.beside {
        return beside::run(duration);
    }
    let (clients, slow) = (options.clients.clamp(1, 100), options.slow.min(4000));
    let server = Server::start()?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let before = server.memory_mib();
    let load = |clients, pace| runtime.block_on(loaded(&server, clients, pace, duration));
    let capacity = load(clients, Pace::Unpaced)?.answers_per_second(duration);
    writeln!(stdout(), "capacity with {clients} unpaced clients: {capacity:.0} answers/s\n\n{}", Tally::HEADING)?;
    // The period of each client at which all together offer the capacity.
    let pace = Pace::Every(Duration::from_secs_f64(clients as f64 / capacity.max(1.0)));
    for times in options.times.iter().map(|times| (*times).clamp(1, 20)) {
        let tally = load(times * clients, pace)?;
        writeln!(stdout(), "{}", tally.row(&format!("{times}x"), times * clients, duration))?;
    }
    let _half_sent = half_requests(&server, slow)?;
    let tally = load(clients, pace)?;
    writeln!(stdout(), "{}", tally.row(&format!("1x, {slow} slow"), clients, duration))?;
    if let (Some(before), Some(after)) = (before, server.memory_mib()) {
        writeln!(stdout(), "\nmemory of the server: {before:.1} MiB before, {after:.1} MiB after")?;
        if after > before + MAX_MEMORY_GROWTH_MIB {
            return Err(BenchError::Load(format!("memory grew from {before:.1} to {after:.1} MiB")));
        }
    }
    Ok(())
}

/// Runs clients for some time, and one more that calls `/healthz`.
async fn loaded(server: &Server, clients: usize, pace: Pace, duration: Duration) -> Result<Tally, BenchError> {
    let start = Instant::now();
    let until = start + duration;
    let step = Request::post("/v1/step", STEP);
    let tasks: Vec<_> = (0..clients)
        .map(|i| tokio::spawn(send_until(server.address, step.clone(), pace.schedule(start, i, clients), until)))
        .collect();
    let probe = Pace::Every(Duration::from_millis(50)).schedule(start, 0, 1);
    let probes = tokio::spawn(send_until(server.address, Request::get("/healthz"), probe, until));
    let mut tally = Tally::default();
    for task in tasks {
        tally.add(task.await.map_err(|error| BenchError::Load(error.to_string()))??);
    }
    tally.probes = probes.await.map_err(|error| BenchError::Load(error.to_string()))??.accepted;
    if tally.probes.is_empty() {
        return Err(BenchError::Load("/healthz did not answer".to_owned()));
    }
    Ok(tally)
}
