//! The HTTP requests of a run.

use serde::{Deserialize, Serialize};

use crate::simulator::recording::Timing;

/// Number of the HTTP requests of a run, and times of its control periods from the state to the answer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Requests {
    /// Requests that were answered: one per control period, and those that open and close the session.
    pub count: u64,
    /// Median of the round trips, µs.
    pub median_us: f64,
    /// 99th percentile of the round trips, µs.
    pub p99_us: f64,
}

impl Requests {
    /// Computes the times from the timings of one or several runs. Periods without a call do not count. `count` is counted
    /// where requests are sent or answered.
    #[must_use]
    pub fn new<'a>(count: u64, timings: impl IntoIterator<Item = &'a Timing>) -> Self {
        let times = timings.into_iter().map(|timing| timing.round_trip_us).filter(|time| *time > 0.0);
        let mut times: Vec<f64> = times.collect();
        times.sort_by(f64::total_cmp);
        Self { count, median_us: quantile(&times, 50), p99_us: quantile(&times, 99) }
    }
}

/// Returns the smallest value that at least `percent` of the sorted values do not exceed; 0 without values.
fn quantile(sorted: &[f64], percent: usize) -> f64 {
    let rank = (sorted.len() * percent).div_ceil(100);
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_the_median_and_the_99th_percentile_of_the_calls() {
        let timings = (0..=200).rev().map(|time| Timing { round_trip_us: f64::from(time), elapsed_us: 1.0 });
        let timings: Vec<Timing> = timings.collect();
        assert_eq!(Requests::new(7, &timings), Requests { count: 7, median_us: 100.0, p99_us: 198.0 });
        assert_eq!(Requests::new(7, &timings[199..]), Requests { count: 7, median_us: 1.0, p99_us: 1.0 });
        assert_eq!(Requests::new(0, []), Requests { count: 0, median_us: 0.0, p99_us: 0.0 });
    }
}
