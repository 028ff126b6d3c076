//! Results of requests.

use std::time::Duration;

use crate::timing::quantile;

/// Counts and times of one client, or of many.
#[derive(Debug, Default)]
pub struct Tally {
    /// Time from sending an accepted request to its complete answer.
    pub accepted: Vec<Duration>,
    /// Number of requests with status 503.
    pub shed: u64,
    /// Number of periods without a request, because the last answer was missing.
    pub missed: u64,
    /// Times of `/healthz`.
    pub probes: Vec<Duration>,
}

impl Tally {
    /// Columns of [`Self::row`].
    pub const HEADING: &str = "load            clients  offered/s  accepted/s   p50 ms   p99 ms   shed %  missed %  \
                               healthz p99 ms";

    pub fn add(&mut self, other: Self) {
        self.accepted.extend(other.accepted);
        self.shed += other.shed;
        self.missed += other.missed;
    }

    pub fn answers_per_second(&self, duration: Duration) -> f64 {
        self.accepted.len() as f64 / duration.as_secs_f64()
    }

    /// Formats one line of the table.
    pub fn row(&self, load: &str, clients: usize, duration: Duration) -> String {
        let sent = self.accepted.len() as f64 + self.shed as f64;
        let offered = (sent + self.missed as f64).max(1.0);
        format!(
            "{load:<14} {clients:>8} {:>10.0} {:>11.0} {:>8.2} {:>8.2} {:>8.1} {:>9.1} {:>15.2}",
            offered / duration.as_secs_f64(),
            self.answers_per_second(duration),
            quantile_ms(&self.accepted, 0.5),
            quantile_ms(&self.accepted, 0.99),
            100.0 * self.shed as f64 / sent.max(1.0),
            100.0 * self.missed as f64 / offered,
            quantile_ms(&self.probes, 0.99),
        )
    }
}

/// Returns a quantile, ms; zero if there are no times.
fn quantile_ms(times: &[Duration], share: f64) -> f64 {
    let mut times: Vec<f64> = times.iter().map(|time| time.as_secs_f64() * 1e3).collect();
    times.sort_by(f64::total_cmp);
    quantile(&times, share)
}
