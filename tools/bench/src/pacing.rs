//! A control loop with one call per period, and the number of missed periods.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::error::BenchError;
use super::http::connection::Connection;
use super::http::subject::UnderTest;
use super::row::Row;
use super::timing::Times;

const RATES_HZ: [u32; 3] = [100, 500, 1000];

/// Histogram classes per decade.
const CLASSES: f64 = 10.0;

/// One paced loop.
#[derive(Debug, Clone, Serialize)]
pub struct Paced {
    /// Periods per second.
    pub rate_hz: u32,
    /// Number of periods.
    pub periods: u64,
    /// Periods without an answer at their end, including skipped ones.
    pub missed: u64,
    /// Longest time from sending to the complete answer, s.
    pub longest_s: f64,
    /// Histogram of the round trips: middle of the class (s) and share; without empty classes.
    pub histogram: Vec<(f64, f64)>,
    #[serde(skip)]
    round_trips: Times,
    /// Delay of the wake-up of the loop.
    #[serde(skip)]
    wake_ups: Times,
}

/// Runs each rate for the given time (s).
pub fn run(seconds: f64) -> Result<Vec<Paced>, BenchError> {
    let service = UnderTest::start()?;
    let one = |rate_hz| {
        let request = service.request_of(&service.another_session()?);
        paced(&mut Connection::open(service.address, request)?, rate_hz, seconds)
    };
    RATES_HZ.into_iter().map(one).collect()
}

fn paced(connection: &mut Connection, rate_hz: u32, seconds: f64) -> Result<Paced, BenchError> {
    let period = Duration::from_secs(1) / rate_hz;
    let periods = Duration::from_secs_f64(seconds).as_nanos() / period.as_nanos();
    let periods = u64::try_from(periods).unwrap_or(u64::MAX).max(1);
    let (mut round_trips, mut wake_ups, mut missed) = (Vec::new(), Vec::new(), 0);
    let mut due = Instant::now() + period;
    for _ in 0..periods {
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        let sent = Instant::now();
        wake_ups.push(sent.duration_since(due).as_secs_f64());
        connection.call()?;
        let answered = Instant::now();
        round_trips.push(answered.duration_since(sent).as_secs_f64());
        due += period;
        while due < answered {
            missed += 1;
            due += period;
        }
    }
    let periods = periods + missed;
    let round_trips =
        Times::of(format!("session step at {rate_hz} Hz, {missed} of {periods} periods missed"), round_trips);
    Ok(Paced {
        rate_hz,
        periods,
        missed,
        longest_s: round_trips.quantile(1.0),
        histogram: histogram(&round_trips),
        round_trips,
        wake_ups: Times::of("wake-up delay of the loop", wake_ups),
    })
}

impl Paced {
    /// Returns the round trips, compared with the wake-up delays, which show the load of the machine.
    pub fn row(&self) -> Row {
        Row::of_times(&self.round_trips, Some(&self.wake_ups))
    }
}

fn histogram(times: &Times) -> Vec<(f64, f64)> {
    let mut classes: std::collections::BTreeMap<i32, u64> = std::collections::BTreeMap::new();
    for time in times.samples() {
        #[expect(clippy::cast_possible_truncation, reason = "between -90 and 20")]
        let class = (CLASSES * time.max(1e-9).log10()).floor() as i32;
        *classes.entry(class).or_default() += 1;
    }
    let all = times.samples().len() as f64;
    classes
        .into_iter()
        .map(|(class, count)| (10_f64.powf((f64::from(class) + 0.5) / CLASSES), count as f64 / all))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histogram_contains_every_answer_once() {
        let histogram = histogram(&Times::of("", vec![1.1e-4, 1.2e-4, 3e-3, 0.0]));
        assert_eq!(histogram.iter().map(|(_, share)| share).sum::<f64>(), 1.0);
        assert!(histogram.iter().any(|(middle, share)| (1e-4..1.26e-4).contains(middle) && *share == 0.5));
    }
}
