//! `revprio load`: what a server does with more requests than it can answer.
//!
//! A server of its own, as a child process, is first asked by a few clients as fast as it answers: that is what it
//! takes. Then ever more clients, each with a connection and a pace of its own, like control loops, offer that rate and
//! multiples of it, and at last the single rate again beside clients that stop in the middle of a request. A client
//! sends nothing before the answer to its last request has come; the periods that pass meanwhile are missed.

mod client;
mod server;
mod tally;

use std::io::{Write as _, stdout};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use self::client::{Pace, Request, send_until};
use self::server::Server;
use self::tally::Tally;
use crate::BenchError;

/// One control period, about 1 KB.
const STEP: &str = include_str!("../../../../api/examples/step.json");

const HALF_A_REQUEST: &[u8] = b"POST /v1/step HTTP/1.1\r\nhost: load\r\ncontent-ty";

/// Growth of the server's memory that any of this may cause, MiB: connections with their buffers and a few histograms.
const MEMORY_BOUND_MIB: f64 = 128.0;

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Length of each run, s, at most 60
    #[arg(long, default_value_t = 5)]
    seconds: u64,
    /// Clients that together offer what the server takes, at most 100
    #[arg(long, default_value_t = 50)]
    clients: usize,
    /// Clients that send half a request and nothing more, at most 4000
    #[arg(long, default_value_t = 1000)]
    slow: usize,
    /// Multiples of what the server takes, at most 20
    #[arg(long, value_delimiter = ',', default_values_t = [1, 2, 10])]
    times: Vec<usize>,
}

/// Runs it; fails if any answer is neither 200 nor 503 with Retry-After, `/healthz` is silent, or memory grows.
pub fn run(options: &Options) -> Result<(), BenchError> {
    let duration = Duration::from_secs(options.seconds.clamp(1, 60));
    let (clients, slow) = (options.clients.clamp(1, 100), options.slow.min(4000));
    let server = Server::start()?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let before = server.memory_mib();
    let load = |clients, pace| runtime.block_on(loaded(&server, clients, pace, duration));
    let capacity = load(clients, Pace::AsFastAsAnswered)?.answers_per_second(duration);
    writeln!(
        stdout(),
        "{clients} clients as fast as they are answered: {capacity:.0} answers/s\n\n{}",
        Tally::HEADING
    )?;
    // Each client's share of the single load.
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
        if after > before + MEMORY_BOUND_MIB {
            return Err(BenchError::Load(format!("memory grew from {before:.1} to {after:.1} MiB")));
        }
    }
    Ok(())
}

/// So many clients for a while, and one that asks for `/healthz` all the time.
async fn loaded(server: &Server, clients: usize, pace: Pace, duration: Duration) -> Result<Tally, BenchError> {
    let start = Instant::now();
    let until = start + duration;
    let step = Request::post("/v1/step", STEP);
    let tasks: Vec<_> = (0..clients)
        .map(|i| tokio::spawn(send_until(server.address, step.clone(), pace.begun(start, i, clients), until)))
        .collect();
    let probe = Pace::Every(Duration::from_millis(50)).begun(start, 0, 1);
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

fn half_requests(server: &Server, count: usize) -> Result<Vec<TcpStream>, BenchError> {
    let half = |_| {
        let mut stream = TcpStream::connect(server.address)?;
        stream.write_all(HALF_A_REQUEST)?;
        Ok(stream)
    };
    (0..count).map(half).collect()
}
