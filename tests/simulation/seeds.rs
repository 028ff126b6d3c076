//! Runs many seeds, in all threads of the machine.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use crate::coverage::Coverage;
use crate::run::run;

/// Seeds of an ordinary run: four times as many as the rarest planted defect of docs/simulation.md needed.
const ORDINARY: Range<u64> = 0..2_000;

/// A run of milliseconds that takes this long hangs without letting the simulated time pass.
const HANGS: Duration = Duration::from_mins(2);

/// Which seeds to run, from the environment.
pub struct Seeds {
    next: AtomicU64,
    end: u64,
    until: Option<Instant>,
    has_failed: AtomicBool,
    coverage: Coverage,
}

impl Seeds {
    /// Reads `REVPRIO_SIMULATION_SEEDS` (`7`, `0..500`) and `REVPRIO_SIMULATION_MINUTES`.
    pub fn from_environment() -> Self {
        let minutes = std::env::var("REVPRIO_SIMULATION_MINUTES").ok();
        let minutes = minutes.map(|text| text.parse().expect("REVPRIO_SIMULATION_MINUTES is a whole number"));
        let seeds = std::env::var("REVPRIO_SIMULATION_SEEDS").ok().map(|text| range(&text));
        let seeds = seeds.unwrap_or(if minutes.is_some() { ORDINARY.end..u64::MAX } else { ORDINARY });
        let until = minutes.map(|minutes: u64| Instant::now() + Duration::from_secs(60 * minutes));
        Self {
            next: AtomicU64::new(seeds.start),
            end: seeds.end,
            until,
            has_failed: AtomicBool::new(false),
            coverage: Coverage::new(),
        }
    }

    fn next(&self) -> Option<u64> {
        let is_over = self.has_failed.load(Ordering::Relaxed) || self.until.is_some_and(|until| Instant::now() > until);
        let seed = self.next.fetch_add(1, Ordering::Relaxed);
        (!is_over && seed < self.end).then_some(seed)
    }

    /// Runs a seed, and returns what failed, with the transcript and the command that repeats it.
    fn report(&self, seed: u64) -> Option<String> {
        let outcome = run(seed);
        self.coverage.note(&outcome.transcript);
        let failure = outcome.failure?;
        Some(format!(
            "seed {seed}: {failure}\n\n{}\n\nseed {seed}: {failure}\nTo repeat it:\n  REVPRIO_SIMULATION_SEEDS={seed} cargo test \
             --test simulation seeds\n",
            outcome.transcript.lines().join("\n")
        ))
    }

    /// Runs all seeds. Panics with the transcript of the first one that fails.
    pub fn run_all(self) {
        let seeds = Arc::new(self);
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let (sender, ended) = mpsc::channel();
        for _ in 0..threads {
            let (seeds, sender) = (Arc::clone(&seeds), sender.clone());
            std::thread::spawn(move || {
                while let Some(seed) = seeds.next() {
                    let failure = seeds.report(seed);
                    seeds.has_failed.fetch_or(failure.is_some(), Ordering::Relaxed);
                    let _ = sender.send(failure);
                }
            });
        }
        drop(sender);
        let count = wait(&ended);
        let missing = seeds.coverage.missing();
        assert!(count < ORDINARY.end || missing.is_empty(), "no seed reached {missing:?}");
        println!("{count} seeds, the next one is {}", seeds.next.load(Ordering::Relaxed).min(seeds.end));
    }
}

/// Waits until all threads have ended, and returns the number of seeds.
fn wait(ended: &mpsc::Receiver<Option<String>>) -> u64 {
    let mut count = 0;
    loop {
        match ended.recv_timeout(HANGS) {
            Ok(None) => count += 1,
            Ok(Some(failure)) => panic!("after {count} seeds: {failure}"),
            Err(mpsc::RecvTimeoutError::Disconnected) => return count,
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("a seed soon after number {count} hangs"),
        }
    }
}

fn range(text: &str) -> Range<u64> {
    let number = |text: &str| text.parse().expect("REVPRIO_SIMULATION_SEEDS is a number or a range such as 0..500");
    match text.split_once("..") {
        Some((start, end)) => number(start)..number(end),
        None => number(text)..number(text) + 1,
    }
}
