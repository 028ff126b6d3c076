//! `revprio-bench load --beside`: one 100 Hz control loop next to clients that keep the server busy.
//!
//! The loop steps a session. A state whose answer arrives after its `valid_for_ms`, or is not a command, counts as late.
//! Clients and server share the machine, so the computing time of the clients is a part of the result.

use std::io::{Read as _, Write as _, stdout};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::client::{Request, parse_answer};
use super::requests::{STEP, half_requests};
use super::server::Server;
use crate::error::BenchError;
use crate::timing::quantile;

const CONTROLLER: &str = include_str!("../../../../api/examples/controller.json");
const STATE: &str = include_str!("../../../../api/examples/state.json");

/// Period of the loop.
const PERIOD: Duration = Duration::from_millis(10);

/// Time between the start of the busy clients and that of the loop.
const WARM_UP: Duration = Duration::from_millis(500);

const TIMEOUT: Duration = Duration::from_secs(10);

const HEADING: &str = "| beside the loop | states | p50 ms | p99 ms | longest ms | late % | answers/s of the others |\n\
                       |---|---|---|---|---|---|---|";

/// Measures the loop alone and next to each kind of busy clients. Prints a Markdown table.
pub fn run(duration: Duration) -> Result<(), BenchError> {
    let (hard, large, step) = (hard_problem(), large_body(), Request::post("/v1/step", STEP));
    writeln!(stdout(), "{HEADING}")?;
    let row = |name: &str, clients: usize, attack: &Attack| {
        let server = Server::start()?;
        let row = beside(&server, clients, attack, duration)?;
        writeln!(stdout(), "| {name} {row}").map_err(BenchError::from)
    };
    row("nothing", 0, &Attack::Slow(0))?;
    row("8 clients with problems of 63 kB", 8, &Attack::Repeat(hard))?;
    row("1 client that pipelines steps", 1, &Attack::Pipeline(step))?;
    row("4 clients with JSON of 1 MB", 4, &Attack::Repeat(large))?;
    row("1000 clients that stop in a request", 1, &Attack::Slow(1000))
}

/// What busy clients do.
#[derive(Clone)]
enum Attack {
    /// Each sends the request again after each answer.
    Repeat(Request),
    /// Sends the request without waiting for answers.
    Pipeline(Request),
    /// Opens this many connections and sends half a request on each.
    Slow(usize),
}

fn beside(server: &Server, clients: usize, attack: &Attack, duration: Duration) -> Result<String, BenchError> {
    let (answers, ended) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
    let _slow = if let Attack::Slow(count) = attack { half_requests(server, *count)? } else { Vec::new() };
    for _ in 0..clients {
        let (address, attack, answers, ended) =
            (server.address, attack.clone(), Arc::clone(&answers), Arc::clone(&ended));
        // A client ends with its server.
        std::thread::spawn(move || attack.run(address, &answers, &ended));
    }
    std::thread::sleep(WARM_UP);
    let before = answers.load(Ordering::Relaxed);
    let row = control_loop(server.address, duration);
    ended.store(true, Ordering::Relaxed);
    let rate = (answers.load(Ordering::Relaxed) - before) as f64 / duration.as_secs_f64();
    Ok(format!("{} {rate:.0} |", row?))
}

impl Attack {
    /// Runs until the end of the measurement or of the connection.
    fn run(&self, address: SocketAddr, answers: &AtomicU64, ended: &AtomicBool) {
        while !ended.load(Ordering::Relaxed) {
            let connected = TcpStream::connect(address);
            let _ = connected.and_then(|stream| match self {
                Self::Repeat(request) => repeat(stream, request, answers),
                Self::Pipeline(request) => pipeline(stream, request, answers),
                Self::Slow(_) => {
                    std::thread::sleep(WARM_UP);
                    Ok(())
                }
            });
        }
    }
}

fn repeat(mut stream: TcpStream, request: &Request, answers: &AtomicU64) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    loop {
        call(&mut stream, request.bytes())?;
        answers.fetch_add(1, Ordering::Relaxed);
    }
}

/// Writes requests in one thread, and counts the status lines of the answers in another.
fn pipeline(mut stream: TcpStream, request: &Request, answers: &AtomicU64) -> std::io::Result<()> {
    let (mut writer, many) = (stream.try_clone()?, request.bytes().repeat(64));
    std::thread::scope(|scope| {
        scope.spawn(move || while writer.write_all(&many).is_ok() {});
        let mut part = vec![0; 64 << 10];
        loop {
            let read = stream.read(&mut part)?;
            if read == 0 {
                return Ok(());
            }
            let found = part[..read].windows(9).filter(|window| window == b"HTTP/1.1 ").count();
            answers.fetch_add(found as u64, Ordering::Relaxed);
        }
    })
}

/// Runs the loop, and returns its columns of the table.
fn control_loop(address: SocketAddr, duration: Duration) -> Result<String, BenchError> {
    let mut stream = TcpStream::connect(address)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(TIMEOUT))?;
    let (_, created) = call(&mut stream, Request::post("/v1/controllers", CONTROLLER).bytes())?;
    let created: Value = parse(&created)?;
    let id = created["id"].as_str().ok_or_else(|| BenchError::Load(format!("no session: {created}")))?;
    let path = format!("/v1/controllers/{id}/step");
    let mut state: Value = parse(STATE)?;
    let (mut times_ms, mut late, mut states) = (Vec::new(), 0, 0_u32);
    let start = Instant::now();
    let mut next = start;
    while start.elapsed() < duration {
        std::thread::sleep(next.saturating_duration_since(Instant::now()));
        state["sequence"] = json!(states + 1);
        state["time_s"] = json!(start.elapsed().as_secs_f64());
        let measured = Instant::now();
        let (status, answer) = call(&mut stream, Request::post(&path, &state.to_string()).bytes())?;
        let elapsed_ms = measured.elapsed().as_secs_f64() * 1e3;
        let answer: Value = parse(&answer)?;
        let valid_ms = answer["valid_for_ms"].as_f64().unwrap_or(0.0);
        states += 1;
        late += u32::from(status != 200 || elapsed_ms > valid_ms);
        times_ms.push(elapsed_ms);
        // A real loop skips the periods that it missed.
        next = (next + PERIOD).max(measured);
    }
    times_ms.sort_by(f64::total_cmp);
    let [p50, p99, longest] = [0.5, 0.99, 1.0].map(|share| quantile(&times_ms, share));
    let late = 100.0 * f64::from(late) / f64::from(states.max(1));
    Ok(format!("| {states} | {p50:.2} | {p99:.2} | {longest:.2} | {late:.2} |"))
}

fn parse(text: &str) -> Result<Value, BenchError> {
    serde_json::from_str(text).map_err(|error| BenchError::Load(format!("{error}: {text}")))
}

/// Sends a request, and returns status and body of its answer.
fn call(stream: &mut TcpStream, request: &[u8]) -> std::io::Result<(u16, String)> {
    stream.write_all(request)?;
    let (mut bytes, mut part) = (Vec::with_capacity(4096), vec![0; 64 << 10]);
    loop {
        let read = stream.read(&mut part)?;
        if read == 0 {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        bytes.extend_from_slice(&part[..read]);
        if let Some(answer) = parse_answer(&bytes) {
            return Ok((answer.status, String::from_utf8_lossy(&bytes[answer.body..]).into_owned()));
        }
    }
}

/// Returns numbers from −1 to 1 with three digits.
fn random_numbers() -> impl FnMut() -> f64 {
    let mut bits = 1_u64;
    move || {
        bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (1e3 * ((bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)).round() / 1e3
    }
}

/// Returns a problem of about 63 kB: 64 tasks of 4 bounded rows for 32 joints, which contradict each other and the limits.
fn hard_problem() -> Request {
    const JOINTS: usize = 32;
    let mut random = random_numbers();
    let mut row = || (0..JOINTS).map(|_| random()).collect::<Vec<f64>>();
    let tasks: Vec<Value> = (0..64)
        .map(|_| json!({"jacobian": [row(), row(), row(), row()], "lower": vec![0.1; 4], "upper": vec![0.5; 4]}))
        .collect();
    let limits = json!({"lower": vec![-0.05; JOINTS], "upper": vec![0.05; JOINTS]});
    let damping = json!({"threshold": 0.3, "max_factor": 0.1});
    let problem = json!({"method": "task_priority", "tasks": tasks, "limits": limits, "damping": damping});
    Request::post("/v1/resolve", &problem.to_string())
}

/// Returns a request of 1 MB with one row of too many numbers, which is found after the whole body has been read.
fn large_body() -> Request {
    let mut random = random_numbers();
    let row: Vec<f64> = (0..150_000).map(|_| random()).collect();
    Request::post("/v1/resolve", &json!({"tasks": [{"jacobian": [row], "velocity": [1.0]}]}).to_string())
}
