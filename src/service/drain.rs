//! The orderly end: connections and streams learn of it, and the service learns when the last of them is done.

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use tokio::sync::watch;

use super::problem::Problem;

/// Held by the service.
pub struct Drain(watch::Sender<bool>);

/// Held by whatever must come to an end before the service may.
#[derive(Debug, Clone)]
pub struct Draining(watch::Receiver<bool>);

impl Drain {
    /// Both ends.
    pub fn new() -> (Self, Draining) {
        let (sender, receiver) = watch::channel(false);
        (Self(sender), Draining(receiver))
    }

    /// Asks all to end and waits until they have.
    pub async fn finished(self) {
        self.0.send_replace(true);
        self.0.closed().await;
    }
}

impl Draining {
    /// Ready when the service wants to end.
    pub async fn begun(&mut self) {
        // An error means that the service is gone already.
        let _ = self.0.wait_for(|draining| *draining).await;
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Draining {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Problem> {
        parts.extensions.get().cloned().ok_or_else(Problem::internal)
    }
}
