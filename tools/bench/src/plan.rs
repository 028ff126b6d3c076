//! The parts to measure, and the time for each.

use std::time::Duration;

use clap::ValueEnum;

use super::timing::Budget;

/// A part of the benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Group {
    /// The mathematics, in one process
    Core,
    /// Round trips, requests per second, WebSocket, number of threads
    Http,
    /// A control loop at 100 Hz, 500 Hz and 1 kHz
    Pacing,
    /// Growth of times with joints, tasks, sessions, items of a batch and simulations
    Growth,
}

impl Group {
    /// All parts, in the order of the report.
    pub const ALL: [Self; 4] = [Self::Core, Self::Http, Self::Pacing, Self::Growth];
}

/// What to measure.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The parts.
    pub groups: Vec<Group>,
    /// Whether to measure as little as possible.
    pub quick: bool,
    /// Length of each paced loop, s.
    pub pacing_s: f64,
}

impl Plan {
    /// Returns the budget for one row and its peers.
    pub fn rows(&self) -> Budget {
        let (turns, milliseconds) = if self.quick { (2, 1) } else { (15, 20) };
        Budget { turns, turn: Duration::from_millis(milliseconds) }
    }

    /// Returns the budget for one point of a curve.
    pub(super) fn points(&self) -> Budget {
        let (turns, milliseconds) = if self.quick { (1, 1) } else { (5, 20) };
        Budget { turns, turn: Duration::from_millis(milliseconds) }
    }

    /// Returns the simulated time of a run, s.
    pub(super) fn simulated_s(&self) -> f64 {
        if self.quick { 0.05 } else { 20.0 }
    }

    /// Returns the sizes to measure: the first two for a quick plan.
    pub(super) fn sizes(&self, sizes: &[usize]) -> Vec<usize> {
        sizes.iter().copied().take(if self.quick { 2 } else { sizes.len() }).collect()
    }
}
