//! Prints how the contact law follows walls that leave and return, and that swing.
//!
//! `cargo run --release -p revprio-core --example contact_moving`

#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/contact/laws.rs"]
mod laws;
#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/contact/plant.rs"]
mod plant;

use laws::Pressing;
use plant::{Conditions, Event, SWINGS, run};

fn main() {
    println!(
        "| K, N/m | wall, cm/s | away: mean, least N | back: mean, most N | losses | settled |\n|---|---|---|---|---|---|"
    );
    for stiffness in [1e3, 3e3, 1e4, 3e4, 1e5] {
        for speed in [0.01, 0.02, 0.05] {
            let terms = Conditions::new(stiffness, 0.03, (0.005, 1, 0.002));
            let start = 1.2 + 1.5 * terms.travel();
            let terms = Conditions { event: Event::LeaveAndReturn(start, speed, 1.5), ..terms };
            let (mut away, mut back) = (Vec::new(), Vec::new());
            let found = run(&terms, &mut Pressing::new(&terms), |[time, force, ..]| {
                let since = time - start;
                if (0.5..1.5).contains(&since) {
                    away.push(force);
                } else if (2.0..3.0).contains(&since) {
                    back.push(force);
                }
            });
            let mean = |forces: &[f64]| forces.iter().sum::<f64>() / forces.len() as f64;
            let least = away.iter().copied().fold(f64::INFINITY, f64::min);
            let most = back.iter().copied().fold(0.0, f64::max);
            println!(
                "| {stiffness:.0e} | {} | {:.1}, {least:.1} | {:.1}, {most:.1} | {} | {} |",
                100.0 * speed,
                mean(&away),
                mean(&back),
                found.losses,
                found.settled
            );
        }
    }
    swings();
}

/// Prints how it follows walls that swing.
fn swings() {
    println!("\n| K, N/m | Hz | amplitude, mm | mean, least, most N | losses | settled |\n|---|---|---|---|---|---|");
    for stiffness in [1e3, 1e4, 3e4, 1e5] {
        for (frequency, amplitude) in
            [(0.2, 0.001), (0.2, 0.005), (0.5, 0.002), (1.0, 0.001), (1.0, 0.003), (2.0, 0.002)]
        {
            let terms = Conditions { hold: 3.0, ..Conditions::new(stiffness, 0.03, (0.005, 1, 0.002)) };
            let start = 1.2 + 1.5 * terms.travel();
            let terms = Conditions { event: Event::Swing(start, amplitude, frequency), ..terms };
            let mut forces = Vec::new();
            let found = run(&terms, &mut Pressing::new(&terms), |[time, force, ..]| {
                if (1.0..SWINGS).contains(&(time - start)) {
                    forces.push(force);
                }
            });
            let mean = forces.iter().sum::<f64>() / forces.len() as f64;
            let least = forces.iter().copied().fold(f64::INFINITY, f64::min);
            let most = forces.iter().copied().fold(0.0, f64::max);
            println!(
                "| {stiffness:.0e} | {frequency} | {} | {mean:.1}, {least:.1}, {most:.1} | {} | {} |",
                1e3 * amplitude,
                found.losses,
                found.settled
            );
        }
    }
}
