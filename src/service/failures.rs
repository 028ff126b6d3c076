//! Requests with a missing or wrong token: how many are logged and answered as such.

use std::sync::{Mutex, PoisonError};

use tokio::time::Instant;

/// Number of failures that are logged and answered with 401 without a pause before them.
const BURST: f64 = 30.0;

/// The limit on failures, for all clients together: a burst, then one failure a second.
///
/// It bounds the log and tells a program in a loop to stop. It never refuses a request with the token: a client that
/// commands an arm may share its address with an attacker, for example behind a proxy. The length of the token protects
/// against guessing.
#[derive(Debug, Default)]
pub struct Failures(Mutex<Option<State>>);

#[derive(Debug)]
struct State {
    tokens: f64,
    updated: Instant,
    /// Number of failures above the limit since the last one within it.
    suppressed: u64,
}

impl Failures {
    /// Counts a failure at `now`. Returns the number of failures above the limit before it, or `None` if this one is above
    /// the limit too.
    pub fn count(&self, now: Instant) -> Option<u64> {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let state = state.get_or_insert(State { tokens: BURST, updated: now, suppressed: 0 });
        let gained = now.saturating_duration_since(state.updated).as_secs_f64();
        (state.tokens, state.updated) = ((state.tokens + gained).min(BURST), now);
        if state.tokens < 1.0 {
            state.suppressed += 1;
            return None;
        }
        state.tokens -= 1.0;
        Some(std::mem::take(&mut state.suppressed))
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_burst_is_within_the_limit_and_then_one_failure_a_second() {
        let (failures, start) = (Failures::default(), Instant::now());
        let at = |ms| failures.count(start + Duration::from_millis(ms));
        assert!((0..30).all(|_| at(0) == Some(0)));
        assert!((0..7).all(|_| at(1).is_none()));
        assert_eq!(at(1100), Some(7));
        assert_eq!((at(1100), at(2100), at(2100)), (None, Some(1), None));
        assert!((0..30).all(|_| at(60_000).is_some()) && at(60_000).is_none());
    }
}
