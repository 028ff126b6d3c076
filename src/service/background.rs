//! Long work in other threads, so that steps do not wait.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

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
