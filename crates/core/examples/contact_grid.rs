//! Prints how the contact law presses against walls of unknown stiffness: 756 conditions, for several drives.
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

use grid::{Summary, cells, measure};

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
        let results: Vec<_> = cells().into_iter().map(|cell| measure(plant::Conditions { soft, ..cell }, 3)).collect();
        if only.is_some() {
            for w in results.iter().filter(|w| w.peak > 1.0) {
                println!(
                    "{} K {} v {} T {} D {} L {} peak {}",
                    w.peak, w.terms.stiffness, w.terms.speed, w.terms.period, w.terms.delay, w.terms.lag, w.force
                );
            }
        }
        println!("{}", Summary::of(&results).row(name));
    }
}
