//! Computations without the lock of the interpreter that are shorter than the wake-up of a thread.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Whether the last thread that came out of [`without_lock`] still has the lock, as far as this module knows.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Maximum time that a thread waits awake. Ten threads that take turns of a few microseconds wait less.
const AWAKE: Duration = Duration::from_micros(50);

/// Computes without the lock of the interpreter.
///
/// A thread that sleeps until the lock is free needs several times as long to wake up as a step takes, and the interpreter
/// may let it sleep for milliseconds. So a thread first waits awake until no other thread of this module has the lock. It
/// waits asleep, as usual, when that takes long or when the lock is held for other reasons.
pub fn without_lock<T: Send>(py: Python<'_>, compute: impl FnOnce() -> T + Send) -> T {
    let result = py.detach(|| {
        TAKEN.store(false, Ordering::Release);
        let result = compute();
        wait_awake();
        result
    });
    // Also for a thread that waited asleep.
    TAKEN.store(true, Ordering::Release);
    result
}

fn wait_awake() {
    let take = || TAKEN.compare_exchange(false, true, Ordering::AcqRel, Ordering::Relaxed).is_ok();
    if take() {
        return;
    }
    let start = Instant::now();
    while !take() && start.elapsed() < AWAKE {
        std::thread::yield_now();
    }
}
