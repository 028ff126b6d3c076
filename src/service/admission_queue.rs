//! The line of requests that wait for the one thread, and who is sent away from it.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::Notify;

/// Fewer requests than this are no line: if they took long, the machine paused or one of them was hard.
const ALWAYS_SERVED: u32 = 8;

/// Measures how long the line is.
///
/// The thread serves what is ready in order. The first request after a quiet moment sends a marker to the end of that
/// line; until the marker comes back, every request stands behind those before it. One that begins later than `max_lag`
/// after the first has waited for so long already, and is sent away with little work. So what is accepted waited for
/// `max_lag` at most, however many come, and nothing is refused while the thread keeps up.
#[derive(Debug, Default)]
pub struct AdmissionQueue {
    /// When the marker was sent, and how many requests were served since; `None` if it has come back.
    marker: Mutex<Option<(Instant, u32)>>,
    sent: Notify,
}

impl AdmissionQueue {
    /// Whether a request that begins now is served.
    pub fn admits(&self, now: Instant, max_lag: Duration) -> bool {
        let mut marker = self.marker.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut *marker {
            None => {
                *marker = Some((now, 1));
                self.sent.notify_one();
                true
            }
            Some((sent, served)) => {
                let admitted = *served < ALWAYS_SERVED || now.duration_since(*sent) <= max_lag;
                *served += u32::from(admitted);
                admitted
            }
        }
    }

    /// Carries the marker; runs beside the connections, on their thread.
    pub async fn carry_marker(&self) {
        loop {
            // Woken by the first request, this task stands behind all that were ready then.
            self.sent.notified().await;
            *self.marker.lock().unwrap_or_else(PoisonError::into_inner) = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAG: Duration = Duration::from_millis(10);

    #[test]
    fn a_long_line_loses_its_end_and_recovers_with_the_marker() {
        let (line, start) = (AdmissionQueue::default(), Instant::now());
        let at = |ms: u64| start + Duration::from_millis(ms);
        assert!((0..1000).all(|_| line.admits(at(9), LAG)));
        assert!(!line.admits(at(20), LAG));
        *line.marker.lock().unwrap() = None;
        assert!(line.admits(at(20), LAG));
    }

    #[test]
    fn a_pause_of_the_machine_refuses_nobody() {
        let (line, start) = (AdmissionQueue::default(), Instant::now());
        assert!(line.admits(start, LAG));
        let later = start + Duration::from_secs(1);
        assert!((1..ALWAYS_SERVED).all(|_| line.admits(later, LAG)));
        assert!(!line.admits(later, LAG));
    }
}
