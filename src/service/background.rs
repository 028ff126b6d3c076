//! Long work in a thread of its own, so that the steps of others do not wait.

use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::available_parallelism;

use tokio::sync::Semaphore;

use super::error::ApiError;

/// Tells long work that nobody waits for it any more: the client is gone, or the service ends.
#[derive(Debug, Clone, Default)]
pub struct Abandoned(Arc<AtomicBool>);

impl Abandoned {
    /// Whether to stop.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Sets the flag when dropped: with the future that waits for the work.
struct AbandonOnDrop(Abandoned);

impl Drop for AbandonOnDrop {
    fn drop(&mut self) {
        self.0.0.store(true, Ordering::Relaxed);
    }
}

/// Quota for long work of one kind: one piece at work, some waiting, no more.
pub struct Quota {
    places: Arc<Semaphore>,
    turn: Arc<Semaphore>,
    most: usize,
}

impl Quota {
    /// Quota for `most` pieces at a time.
    pub fn new(most: usize) -> Self {
        Self { places: Arc::new(Semaphore::new(most)), turn: Arc::new(Semaphore::new(1)), most }
    }

    /// Runs `work` in another thread when its turn comes; without a place, refuses it at once.
    ///
    /// `what`: the pieces, in the plural.
    pub async fn run<T: Send + 'static>(
        &self,
        what: &str,
        work: impl FnOnce(&Abandoned) -> T + Send + 'static,
    ) -> Result<T, ApiError> {
        let busy = |_| ApiError::busy(format!("{} {what} are at work already; try again in a second", self.most));
        let place = Arc::clone(&self.places).try_acquire_owned().map_err(busy)?;
        let turn = Arc::clone(&self.turn).acquire_owned().await.map_err(|_| ApiError::internal())?;
        background(move |abandoned| {
            // Held by the work itself: when its client is gone, it still takes a while to end.
            let _held = (place, turn);
            work(abandoned)
        })
        .await
    }
}

/// Runs `work` in another thread and waits for it.
pub async fn background<T: Send + 'static>(work: impl FnOnce(&Abandoned) -> T + Send + 'static) -> Result<T, ApiError> {
    let abandoned = Abandoned::default();
    let _guard = AbandonOnDrop(abandoned.clone());
    tokio::task::spawn_blocking(move || work(&abandoned)).await.map_err(|error| {
        tracing::error!(%error, "work in the background failed");
        ApiError::internal()
    })
}

/// Runs `work` in up to `most` threads at a time, as many as may be kept busy, and waits for them.
pub fn on_all_cores(most: usize, work: impl Fn() + Sync) {
    let threads = busy_threads().min(most);
    if threads <= 1 {
        return work();
    }
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                step_back();
                work();
            });
        }
    });
}

/// All cores, as the thread that serves steps goes first.
#[cfg(target_os = "linux")]
fn busy_threads() -> usize {
    available_parallelism().map_or(1, NonZero::get)
}

/// All cores but the one that serves steps.
#[cfg(not(target_os = "linux"))]
fn busy_threads() -> usize {
    available_parallelism().map_or(1, NonZero::get).saturating_sub(1)
}

/// Lets all threads of ordinary priority go first. On Linux the number belongs to the calling thread alone, which cannot
/// take it back: not for threads that do other work later.
#[cfg(target_os = "linux")]
fn step_back() {
    const LAST: i32 = 19;
    if let Err(error) = rustix::process::setpriority_process(None, LAST) {
        tracing::warn!(%error, "long work competes with steps");
    }
}

#[cfg(not(target_os = "linux"))]
fn step_back() {}
