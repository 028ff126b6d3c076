//! What became of requests.

use std::time::Duration;

/// Counts and times of one client, or of many.
#[derive(Debug, Default)]
pub struct Tally {
    /// Time from sending a request to its whole answer, of those that were accepted.
    pub accepted: Vec<Duration>,
    /// Requests that got 503.
    pub shed: u64,
    /// Periods in which nothing was sent, because the last answer had not come.
    pub missed: u64,
    /// As above, of `/healthz`.
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

    /// One line of the table.
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

/// The time that a share of all stays below, ms; zero without any.
fn quantile_ms(times: &[Duration], share: f64) -> f64 {
    let mut times = times.to_vec();
    times.sort_unstable();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let place = (share * times.len().saturating_sub(1) as f64).round() as usize;
    times.get(place).map_or(0.0, |time| time.as_secs_f64() * 1e3)
}
