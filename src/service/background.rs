//! Long work in a thread of its own, so that the steps of others do not wait.

use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::available_parallelism;

use super::problem::Problem;

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

/// Runs `work` in another thread and waits for it.
pub async fn background<T: Send + 'static>(work: impl FnOnce(&Abandoned) -> T + Send + 'static) -> Result<T, Problem> {
    let abandoned = Abandoned::default();
    let _guard = AbandonOnDrop(abandoned.clone());
    tokio::task::spawn_blocking(move || work(&abandoned)).await.map_err(|error| {
        tracing::error!(%error, "work in the background failed");
        Problem::internal()
    })
}

/// Threads that long work may keep busy: all cores but the one that serves steps.
pub fn spare_cores() -> usize {
    available_parallelism().map_or(1, NonZero::get).saturating_sub(1).max(1)
}
