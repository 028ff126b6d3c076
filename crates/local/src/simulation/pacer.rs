//! When the next control period of an interactive run begins.

use std::time::Duration;

use revprio_api::clock::Instant;

use super::run_control::Commands;

/// A run that is more than this behind the clock does not catch up.
const MAX_LAG: Duration = Duration::from_millis(100);

/// What the run does now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// It computes a period.
    Period,
    /// It waits for this time.
    Wait(Duration),
    /// It waits for a command.
    Paused,
}

/// Paces a run by the clock.
#[derive(Debug)]
pub struct Pacer {
    period_s: f64,
    /// Start of the next period.
    due: Instant,
}

impl Pacer {
    /// Starts the clock of a run with this control period, s.
    pub fn new(period_s: f64) -> Self {
        Self { period_s, due: Instant::now() }
    }

    /// Returns what to do at this time, and counts the period if it begins now.
    pub fn turn(&mut self, commands: &mut Commands, now: Instant) -> Turn {
        if commands.pace.paused {
            self.due = now;
            if commands.steps == 0 {
                return Turn::Paused;
            }
            commands.steps -= 1;
            return Turn::Period;
        }
        match self.due.checked_duration_since(now) {
            Some(left) if !left.is_zero() => Turn::Wait(left),
            _ => {
                let start = if now.duration_since(self.due) > MAX_LAG { now } else { self.due };
                self.due = start + Duration::from_secs_f64(self.period_s / commands.pace.speed);
                Turn::Period
            }
        }
    }
}
