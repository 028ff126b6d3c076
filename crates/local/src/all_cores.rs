//! Work on all cores, in threads of a lower priority.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::available_parallelism;

/// Returns `work` of each item, in order, computed on all cores with a low priority. `items_per_thread`: number of items
/// that justify one more thread. Returns `None` if `is_abandoned` ended the work early.
pub fn map_on_all_cores<T: Sync, R: Send>(
    items: &[T],
    items_per_thread: usize,
    is_abandoned: impl Fn() -> bool + Sync,
    work: impl Fn(usize, &T) -> R + Sync,
) -> Option<Vec<R>> {
    let results: Vec<Mutex<Option<R>>> = items.iter().map(|_| Mutex::default()).collect();
    let next = AtomicUsize::new(0);
    on_all_cores(items.len() / items_per_thread, || {
        while !is_abandoned() {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let (Some(item), Some(result)) = (items.get(i), results.get(i)) else { break };
            *result.lock().unwrap_or_else(PoisonError::into_inner) = Some(work(i, item));
        }
    });
    results.into_iter().map(|result| result.into_inner().ok().flatten()).collect()
}

/// Runs `work` in at most `max` threads at a time, and waits for them. The number of cores also limits the threads.
fn on_all_cores(max: usize, work: impl Fn() + Sync) {
    let threads = available_threads().min(max);
    if threads <= 1 {
        return work();
    }
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                lower_priority();
                work();
            });
        }
    });
}

/// All cores: the thread that serves steps has a higher priority.
#[cfg(target_os = "linux")]
fn available_threads() -> usize {
    cores()
}

/// Returns the number of threads for work next to the thread of the steps: one for each other core, and at least one.
pub fn threads_beside_steps() -> usize {
    cores().saturating_sub(1).max(1)
}

fn cores() -> usize {
    available_parallelism().map_or(1, NonZero::get)
}

/// All cores but one, which serves steps.
#[cfg(not(target_os = "linux"))]
fn available_threads() -> usize {
    cores().saturating_sub(1)
}

/// Gives the calling thread the lowest priority. On Linux the priority belongs to one thread, which cannot raise it again.
/// Call this only in threads that do nothing else later.
#[cfg(target_os = "linux")]
pub fn lower_priority() {
    const LOWEST: i32 = 19;
    if let Err(error) = rustix::process::setpriority_process(None, LOWEST) {
        tracing::warn!(%error, "cannot lower the priority of long work; it competes with steps");
    }
}

/// Does nothing: on this system the priority of a thread stays.
#[cfg(not(target_os = "linux"))]
pub fn lower_priority() {}
