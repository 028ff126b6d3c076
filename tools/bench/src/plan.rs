//! What is measured, and for how long.

use std::time::Duration;

use clap::ValueEnum;

use super::timing::Budget;

/// What belongs together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Group {
    /// The mathematics, in process
    Core,
    /// Round trips and requests per second, WebSocket, kinds of runtime
    Http,
    /// A control loop at 100 Hz, 500 Hz and 1 kHz
    Pacing,
    /// How cost grows with joints, tasks, sessions, items of a batch and simulations
    Growth,
}

impl Group {
    /// All of them, in the order of the report.
    pub const ALL: [Self; 4] = [Self::Core, Self::Http, Self::Pacing, Self::Growth];
}

/// What to measure.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Which parts.
    pub groups: Vec<Group>,
    /// As little as shows that all of it works.
    pub quick: bool,
    /// Length of each paced loop, s.
    pub pacing_s: f64,
}

impl Plan {
    /// For one row and its peers.
    pub fn rows(&self) -> Budget {
        let (turns, milliseconds) = if self.quick { (2, 1) } else { (15, 20) };
        Budget { turns, turn: Duration::from_millis(milliseconds) }
    }

    /// For one point of a curve.
    pub(super) fn points(&self) -> Budget {
        let (turns, milliseconds) = if self.quick { (1, 1) } else { (5, 20) };
        Budget { turns, turn: Duration::from_millis(milliseconds) }
    }

    /// Simulated time of a run for its speed, s.
    pub(super) fn simulated_s(&self) -> f64 {
        if self.quick { 0.05 } else { 20.0 }
    }

    /// As many of these sizes as the plan has time for: the first ones of a quick plan.
    pub(super) fn sizes(&self, sizes: &[usize]) -> Vec<usize> {
        sizes.iter().copied().take(if self.quick { 2 } else { sizes.len() }).collect()
    }
}
