//! Searches for the dearest requests of the serving thread: valid problems whose answer takes long for their price or size.
//!
//! ```sh
//! cargo run --release -p revprio-fuzz --example dearest -- --seconds 60 --solver auto
//! ```
//!
//! `--bodies FILE` writes their bodies, one per line.
//!
//! It begins with random problems, then changes the dearest of them again and again, and prints a table of the dearest that the
//! serving thread solves itself; without `--solver`, all solvers. Times are those of this machine, the least of three runs.

use std::time::{Duration, Instant};

use revprio::service::{LocalService, Robots};
use serde_json::{Value, json};

/// Number of problems that survive a round.
const KEPT: usize = 24;

/// The shape of a problem.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::struct_excessive_bools, reason = "the options of a request")]
struct Shape {
    joints: usize,
    tasks: usize,
    rows: usize,
    inequalities: usize,
    /// Parts out of 8 of the rows that are bounds, and that contradict each other.
    bounds: usize,
    conflict: usize,
    method: usize,
    solver: usize,
    damped: bool,
    boxed: bool,
    certificate: bool,
    why: bool,
    seed: u64,
}

const METHODS: [&str; 6] = [
    "strict_reverse_priority",
    "reverse_priority",
    "task_priority",
    "singularity_robust",
    "damped_least_squares",
    "pseudoinverse",
];
const SOLVERS: [&str; 3] = ["auto", "qp", "closed_form"];

impl Shape {
    fn random(random: &mut fastrand::Rng) -> Self {
        let joints = random.usize(1..=12);
        Self {
            joints,
            tasks: random.usize(1..=8),
            rows: 1 << random.usize(0..=9),
            inequalities: if random.bool() { 0 } else { 1 << random.usize(0..=9) },
            bounds: random.usize(0..=8),
            conflict: random.usize(0..=8),
            method: random.usize(..METHODS.len()),
            solver: random.usize(..SOLVERS.len()),
            damped: random.bool(),
            boxed: random.bool(),
            certificate: random.bool(),
            why: random.bool(),
            seed: random.u64(..),
        }
    }

    fn changed(self, random: &mut fastrand::Rng) -> Self {
        let other = Self::random(random);
        let scaled = |value: usize, least: usize, most: usize, random: &mut fastrand::Rng| {
            (value * random.usize(6..=15) / 10).clamp(least, most)
        };
        let mut next = self;
        match random.usize(..9) {
            0 => next.joints = scaled(self.joints, 1, 32, random),
            1 => next.tasks = scaled(self.tasks, 1, 64, random),
            2 => next.rows = scaled(self.rows, 1, 512, random),
            3 => next.inequalities = scaled(self.inequalities, 0, 512, random),
            4 => (next.bounds, next.conflict) = (other.bounds, other.conflict),
            5 => (next.method, next.solver) = (other.method, other.solver),
            6 => (next.damped, next.boxed) = (other.damped, other.boxed),
            7 => (next.certificate, next.why) = (other.certificate, other.why),
            _ => next.seed = other.seed,
        }
        next
    }

    fn body(self) -> Value {
        let mut random = fastrand::Rng::with_seed(self.seed);
        let mut number = || (random.f64() * 200.0 - 100.0).round() / 100.0;
        let mut rows_left = self.rows.max(self.tasks);
        let mut tasks = Vec::new();
        for k in 0..self.tasks {
            let rows = (rows_left / (self.tasks - k)).max(1);
            rows_left -= rows.min(rows_left);
            let jacobian: Vec<Vec<f64>> = (0..rows).map(|_| (0..self.joints).map(|_| number()).collect()).collect();
            let bounds = (k * 8) / self.tasks < self.bounds;
            let centre: Vec<f64> =
                (0..rows).map(|_| if self.conflict > 0 { number() * self.conflict as f64 } else { 0.0 }).collect();
            tasks.push(if bounds {
                json!({"jacobian": jacobian, "lower": centre, "upper": centre.iter().map(|c| c + 0.01).collect::<Vec<_>>()})
            } else {
                json!({"jacobian": jacobian, "velocity": centre})
            });
        }
        let inequalities: Vec<Value> = (0..self.inequalities)
            .map(|i| {
                let coefficients: Vec<f64> = (0..self.joints).map(|_| number()).collect();
                let upper = if i % 8 < self.conflict { -0.1 } else { 0.1 };
                json!({"kind": "joints", "name": format!("{i}"), "coefficients": coefficients, "upper": upper})
            })
            .collect();
        let mut body = json!({"tasks": tasks, "inequalities": inequalities, "method": METHODS[self.method],
            "solver": SOLVERS[self.solver], "why": self.why, "certificate": self.certificate});
        for (k, task) in body["tasks"].as_array_mut().into_iter().flatten().enumerate() {
            task["name"] = json!(format!("t{k}"));
        }
        if self.damped {
            body["damping"] = json!({"threshold": 0.15, "max_factor": 0.15});
        }
        if self.boxed {
            body["limits"] = json!({"lower": vec![-0.1; self.joints], "upper": vec![0.1; self.joints]});
        }
        body
    }
}

/// A problem that the serving thread solves.
#[derive(Debug, Clone, Copy)]
struct Found {
    shape: Shape,
    us: f64,
    bytes: usize,
    price: usize,
}

fn measure(service: &LocalService, shape: Shape) -> Option<Found> {
    let body = serde_json::to_vec(&shape.body()).ok()?;
    let price = service.price(&body).ok().filter(|price| price.is_within_budget)?;
    let mut us = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        service.call("POST", "/v1/resolve", &body).ok()?;
        us = us.min(start.elapsed().as_secs_f64() * 1e6);
    }
    Some(Found { shape, us, bytes: body.len(), price: price.units })
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let value = |name: &str| arguments.iter().skip_while(|given| *given != name).nth(1);
    let seconds = value("--seconds").and_then(|seconds| seconds.parse().ok()).unwrap_or(60.0);
    let solver = value("--solver").and_then(|name| SOLVERS.iter().position(|known| known == name));
    let (service, start) = (LocalService::new(Robots::built_in()), Instant::now());
    let mut random = fastrand::Rng::with_seed(1);
    let mut best: Vec<Found> = Vec::new();
    let mut count = 0_u64;
    while start.elapsed() < Duration::from_secs_f64(seconds) {
        let shape = if best.len() < KEPT || random.usize(..4) == 0 {
            Shape::random(&mut random)
        } else {
            best[random.usize(..best.len())].shape.changed(&mut random)
        };
        let shape = Shape { solver: solver.unwrap_or(shape.solver), ..shape };
        count += 1;
        best.extend(measure(&service, shape));
        best.sort_by(|a, b| b.us.total_cmp(&a.us));
        best.dedup_by(|a, b| a.price == b.price && a.bytes == b.bytes);
        best.truncate(KEPT);
    }
    println!("{count} problems; the dearest on the serving thread:");
    println!("{:>9} {:>8} {:>8} {:>9} {:>11}  shape", "µs", "bytes", "price", "µs/price", "µs/kB");
    if let Some(file) = value("--bodies") {
        let lines: Vec<String> = best.iter().map(|found| found.shape.body().to_string()).collect();
        if let Err(error) = std::fs::write(file, lines.join("\n")) {
            eprintln!("{file}: {error}");
        }
    }
    for Found { shape, us, bytes, price } in best {
        let (per_price, per_kb) = (us / price as f64, us * 1e3 / bytes as f64);
        println!("{us:9.0} {bytes:8} {price:8} {per_price:9.3} {per_kb:11.1}  {shape:?}");
    }
}
