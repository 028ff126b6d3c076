//! The grid of conditions, and what counts as good.

use crate::laws::{bound, press};
use crate::plant::Conditions;

/// K, N/m.
pub const STIFFNESSES: [f64; 7] = [1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6];
/// v, m/s.
pub const SPEEDS: [f64; 3] = [0.01, 0.03, 0.1];

/// Returns the 756 conditions.
pub fn cells() -> Vec<Conditions> {
    let mut cells = Vec::new();
    for stiffness in STIFFNESSES {
        for speed in SPEEDS {
            for lag in [0.0, 0.005, 0.01, 0.02] {
                for delay in 0..3 {
                    for period in [0.001, 0.002, 0.008] {
                        cells.push(Conditions::new(stiffness, speed, (lag, delay, period)));
                    }
                }
            }
        }
    }
    cells
}

/// Returns `count` runs under each of the 756 conditions, each with noise of its own.
pub fn runs(count: usize) -> impl Iterator<Item = Conditions> {
    let runs = cells().into_iter().flat_map(move |cell| std::iter::repeat_n(cell, count));
    (1..).zip(runs).map(|(seed, cell)| cell.seeded(seed))
}

/// What counts of a run.
#[derive(Debug, Clone, Copy)]
pub struct Measured {
    pub terms: Conditions,
    pub settled: bool,
    /// Peak over max(1.2 F_d, 1.1 × the unavoidable peak).
    pub peak: f64,
    /// Largest force, N.
    pub force: f64,
    /// Settling time over 0.5 s and the travel.
    pub settling: f64,
    pub error: f64,
    pub losses: usize,
    pub fault: bool,
}

/// Runs the contact law.
pub fn measure(terms: Conditions) -> Measured {
    let found = press(&terms);
    let allowed = (1.2 * terms.target).max(1.1 * bound(&terms));
    Measured {
        terms,
        settled: found.settled,
        peak: if found.peak < 1e7 { found.peak / allowed } else { f64::INFINITY },
        force: found.peak,
        settling: found.settling / (0.5 + terms.travel()),
        error: found.error.abs(),
        losses: found.losses,
        fault: found.fault,
    }
}

/// The runs that miss each goal, and the worst values.
#[derive(Debug, Clone, Copy, Default)]
pub struct Summary {
    pub runs: usize,
    pub unsettled: usize,
    pub peaks: (usize, f64),
    pub late: (usize, f64),
    pub errors: (usize, f64),
    pub losses: usize,
    pub faults: usize,
}

impl Summary {
    pub const HEAD: &str = "| drive | runs | not settled | peak above allowed, worst | late, worst | error > 0.1 N, worst N | most losses | faults |\n|---|---|---|---|---|---|---|---|";

    pub fn of(results: &[Measured]) -> Self {
        let over = |value: fn(&Measured) -> f64, bound: f64| {
            let values = results.iter().map(value);
            (values.clone().filter(|value| *value > bound).count(), values.fold(0.0, f64::max))
        };
        Self {
            runs: results.len(),
            unsettled: results.iter().filter(|run| !run.settled).count(),
            peaks: over(|run| run.peak, 1.0),
            late: over(|run| run.settling, 1.0),
            errors: over(|run| run.error, 0.1),
            losses: results.iter().map(|run| run.losses).max().unwrap_or(0),
            faults: results.iter().filter(|run| run.fault).count(),
        }
    }

    /// Returns a row of the table.
    pub fn row(&self, name: &str) -> String {
        let Self { runs, unsettled, peaks, late, errors, losses, faults } = *self;
        let share = |(count, worst): (usize, f64)| {
            let percent = 100.0 * count as f64 / runs as f64;
            format!("{percent:.2} %, {worst:.2}")
        };
        let [peaks, late, errors] = [peaks, late, errors].map(share);
        format!("| {name} | {runs} | {unsettled} | {peaks} | {late} | {errors} | {losses} | {faults} |")
    }
}
