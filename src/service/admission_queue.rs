//! Refuses requests early when too many wait for the one thread.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;
use tokio::time::Instant;

/// Number of requests after a marker that are always admitted. If so few requests take long, the cause is a pause of the
/// machine or one slow request, not overload.
const ALWAYS_ADMITTED: u32 = 8;

/// Measures how long requests wait, and refuses those that have waited too long.
///
/// The thread runs ready tasks in order. The first request after an idle moment puts a marker at the end of the run
/// queue. Until the marker runs, every request is behind the earlier ones. A request that starts more than `max_lag`
/// after the first one has already waited that long and is refused with little work.
///
/// Apart from the first requests after a marker, an admitted request has waited at most `max_lag`. While the thread keeps
/// up, no request is refused.
#[derive(Debug, Default)]
pub struct AdmissionQueue {
    /// The time when the marker was queued and the number of requests admitted since; `None` if the marker has run.
    marker: Mutex<Option<(Instant, u32)>>,
    queued: Notify,
}

impl AdmissionQueue {
    /// Returns whether a request that starts at `now` is admitted.
    pub fn admits(&self, now: Instant, max_lag: Duration) -> bool {
        let mut marker = self.marker.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut *marker {
            None => {
                *marker = Some((now, 1));
                self.queued.notify_one();
                true
            }
            Some((queued, admitted)) => {
                let is_admitted = *admitted < ALWAYS_ADMITTED || now.duration_since(*queued) <= max_lag;
                *admitted += u32::from(is_admitted);
                is_admitted
            }
        }
    }

    /// Runs the marker. This task must run on the thread of the connections.
    pub async fn run_marker(&self) {
        loop {
            // The first request wakes this task, which then runs after all tasks that were ready at that moment.
            self.queued.notified().await;
            *self.marker.lock().unwrap_or_else(PoisonError::into_inner) = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAG: Duration = Duration::from_millis(10);

    #[test]
    fn requests_beyond_the_lag_are_refused_until_the_marker_runs() {
        let (queue, start) = (AdmissionQueue::default(), Instant::now());
        let at = |ms: u64| start + Duration::from_millis(ms);
        assert!((0..1000).all(|_| queue.admits(at(9), LAG)));
        assert!(!queue.admits(at(20), LAG));
        *queue.marker.lock().unwrap() = None;
        assert!(queue.admits(at(20), LAG));
    }

    #[test]
    fn the_first_requests_are_admitted_after_a_pause_of_the_machine() {
        let (queue, start) = (AdmissionQueue::default(), Instant::now());
        assert!(queue.admits(start, LAG));
        let later = start + Duration::from_secs(1);
        assert!((1..ALWAYS_ADMITTED).all(|_| queue.admits(later, LAG)));
        assert!(!queue.admits(later, LAG));
    }
}
