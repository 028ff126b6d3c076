//! Prints the energy that the contact law gives to walls that leave, push, move and change their stiffness at random.
//!
//! `cargo run --release -p revprio-core --example contact_passivity` prints the table of docs/contact.md.

#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/contact/laws.rs"]
mod laws;
#[path = "../tests/contact/passivity.rs"]
mod passivity;
#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/contact/plant.rs"]
mod plant;

use passivity::{Energy, energy};

/// Number of runs.
const RUNS: u64 = 10_000;

/// Prints the quantiles of a share.
fn print(name: &str, runs: &[&Energy], share: impl Fn(&Energy) -> f64) {
    let mut shares: Vec<f64> = runs.iter().map(|run| share(run)).collect();
    shares.sort_by(f64::total_cmp);
    let at = |permille: usize| shares[(shares.len() - 1) * permille / 1000];
    let above = shares.iter().filter(|share| **share > 1.0).count();
    let [median, most, nearly_all, worst] = [500, 950, 999, 1000].map(at);
    println!("| {name} | {} | {median:.3} | {most:.3} | {nearly_all:.3} | {worst:.3} | {above} |", shares.len());
}

fn main() {
    let runs: Vec<Energy> =
        (0..std::env::args().nth(1).map_or(RUNS, |runs| runs.parse().expect("a number of runs"))).map(energy).collect();
    let of = |is_soft: bool| runs.iter().filter(|run| run.terms.soft.is_some() == is_soft).collect::<Vec<_>>();
    println!("| energy over | runs | median | 95 % | 99.9 % | worst | above 1 |\n|---|---|---|---|---|---|---|");
    for (name, is_soft) in [("rigid", false), ("100 to 400 rad/s", true)] {
        let runs = of(is_soft);
        print(&format!("{name}, since the start"), &runs, |run| run.given[0] / run.tank.max(run.impact));
        print(&format!("{name}, any time"), &runs, Energy::share);
        let moving = |run: &Energy| run.given[1] / run.tank.max(run.moving_impact);
        print(&format!("{name}, any time, impact on a wall that comes"), &runs, moving);
    }
    let losses: usize = runs.iter().map(|run| run.losses).sum();
    let faults = runs.iter().filter(|run| run.fault).count();
    println!("\n{losses} losses, {faults} faults");
    let mut worst: Vec<&Energy> = runs.iter().collect();
    worst.sort_by(|a, b| b.share().total_cmp(&a.share()));
    for run in worst.iter().take(5) {
        println!("{:.3}: {:.3} J of {:.3} J, {:?}", run.share(), run.given[1], run.tank.max(run.impact), run.terms);
    }
}
