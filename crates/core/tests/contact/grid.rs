//! The grid of conditions, and what counts as good.

use crate::laws::{bound, press};
use crate::plant::{Conditions, Outcome};

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

/// The worst of some seeds in one cell.
#[derive(Debug, Clone, Copy)]
pub struct Worst {
    pub terms: Conditions,
    pub unsettled: bool,
    /// Peak over max(1.2 F_d, 1.1 × the unavoidable peak).
    pub peak: f64,
    /// Largest force, N.
    pub force: f64,
    /// Settling time over 0.5 s and the travel.
    pub settling: f64,
    pub error: f64,
    pub losses: usize,
    pub fault: bool,
    pub settling_after: f64,
}

/// Runs the contact law with seeds from 1 on.
pub fn measure(terms: Conditions, seeds: u64) -> Worst {
    measure_with(terms, seeds, press)
}

/// Runs a controller with seeds from 1 on.
pub fn measure_with(terms: Conditions, seeds: u64, press: impl Fn(&Conditions) -> Outcome) -> Worst {
    let empty = Worst {
        terms,
        unsettled: false,
        peak: 0.0,
        force: 0.0,
        settling: 0.0,
        error: 0.0,
        losses: 0,
        fault: false,
        settling_after: 0.0,
    };
    (1..=seeds).fold(empty, |worst, seed| {
        let terms = terms.seeded(seed);
        let found = press(&terms);
        let allowed = (1.2 * terms.target).max(1.1 * bound(&terms));
        let peak = if found.peak < 1e7 { found.peak / allowed } else { f64::INFINITY };
        Worst {
            terms: worst.terms,
            unsettled: worst.unsettled || !found.settled,
            peak: worst.peak.max(peak),
            force: worst.force.max(found.peak),
            settling: worst.settling.max(found.settling / (0.5 + terms.travel())),
            error: worst.error.max(found.error.abs()),
            losses: worst.losses.max(found.losses),
            fault: worst.fault || found.fault,
            settling_after: worst.settling_after.max(found.settling_after),
        }
    })
}

/// The cells that miss each goal, and the worst values.
#[derive(Debug, Clone, Copy, Default)]
pub struct Summary {
    pub cells: usize,
    pub unsettled: usize,
    pub peaks: (usize, f64),
    pub late: (usize, f64),
    pub errors: (usize, f64),
    pub losses: usize,
    pub faults: usize,
}

impl Summary {
    pub const HEAD: &str = "| drive | cells | not settled | peak above allowed, worst | late, worst | error > 0.1 N, worst N | losses | faults |\n|---|---|---|---|---|---|---|---|";

    pub fn of(results: &[Worst]) -> Self {
        let over = |value: fn(&Worst) -> f64, bound: f64| {
            let values = results.iter().map(value);
            (values.clone().filter(|value| *value > bound).count(), values.fold(0.0, f64::max))
        };
        Self {
            cells: results.len(),
            unsettled: results.iter().filter(|worst| worst.unsettled).count(),
            peaks: over(|worst| worst.peak, 1.0),
            late: over(|worst| worst.settling, 1.0),
            errors: over(|worst| worst.error, 0.1),
            losses: results.iter().map(|worst| worst.losses).max().unwrap_or(0),
            faults: results.iter().filter(|worst| worst.fault).count(),
        }
    }

    /// Returns a row of the table.
    pub fn row(&self, name: &str) -> String {
        let Self { cells, unsettled, peaks, late, errors, losses, faults } = self;
        format!(
            "| {name} | {cells} | {unsettled} | {}, {:.2} | {}, {:.2} | {}, {:.2} | {losses} | {faults} |",
            peaks.0, peaks.1, late.0, late.1, errors.0, errors.1
        )
    }
}
