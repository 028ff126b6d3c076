//! Prints how the contact law presses against walls of unknown stiffness: 20 runs under each of 756 conditions, for several
//! drives.
//!
//! `cargo run --release -p revprio-core --example contact_grid` prints the tables of docs/contact.md.

#[path = "../tests/contact/grid.rs"]
mod grid;
#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/contact/laws.rs"]
mod laws;
#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/contact/plant.rs"]
mod plant;

use grid::{Summary, measure, runs};

/// Runs under each of the conditions.
const RUNS: usize = 20;

fn main() {
    let drives: [(&str, Option<(f64, f64)>); 6] = [
        ("rigid", None),
        ("400 rad/s, 2 kg", Some((2.0, 400.0))),
        ("150 rad/s, 2 kg", Some((2.0, 150.0))),
        ("150 rad/s, 5 kg", Some((5.0, 150.0))),
        ("100 rad/s, 5 kg", Some((5.0, 100.0))),
        ("75 rad/s, 5 kg", Some((5.0, 75.0))),
    ];
    println!("{}", Summary::HEAD);
    let only = std::env::args().nth(1);
    let drives = drives.into_iter().filter(|(name, _)| only.as_ref().is_none_or(|only| name.contains(only.as_str())));
    for (name, soft) in drives {
        let results: Vec<_> = runs(RUNS).map(|terms| measure(plant::Conditions { soft, ..terms })).collect();
        if only.is_some() {
            for run in results.iter().filter(|run| run.peak > 1.0) {
                let plant::Conditions { stiffness, speed, period, delay, lag, .. } = run.terms;
                println!("{:.2} K {stiffness} v {speed} T {period} D {delay} L {lag} peak {:.1}", run.peak, run.force);
            }
        }
        println!("{}", Summary::of(&results).row(name));
    }
}
