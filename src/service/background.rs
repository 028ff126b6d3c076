//! Long work in other threads, so that steps do not wait.

use std::num::NonZero;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::available_parallelism;

use super::error::ApiError;

/// Tells long work that nobody waits for it any more: the client is gone, or the service shuts down.
#[derive(Debug, Clone, Default)]
pub struct Abandoned(Arc<AtomicBool>);

impl Abandoned {
    /// Returns whether to stop.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Sets the flag when it is dropped together with the future that waits for the work.
pub struct AbandonOnDrop(Abandoned);

impl AbandonOnDrop {
    /// Sets this flag when it is dropped.
    pub fn of(abandoned: &Abandoned) -> Self {
        Self(abandoned.clone())
    }
}

impl Drop for AbandonOnDrop {
    fn drop(&mut self) {
        self.0.0.store(true, Ordering::Relaxed);
    }
}

/// Runs `work` in another thread, and waits for it.
pub async fn background<T: Send + 'static>(work: impl FnOnce(&Abandoned) -> T + Send + 'static) -> Result<T, ApiError> {
    let abandoned = Abandoned::default();
    let _guard = AbandonOnDrop::of(&abandoned);
    tokio::task::spawn_blocking(move || work(&abandoned)).await.map_err(|error| {
        tracing::error!(%error, "background work failed");
        ApiError::internal()
    })
}

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

#[cfg(not(target_os = "linux"))]
pub fn lower_priority() {}
