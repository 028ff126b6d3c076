//! The orderly end: told beforehand, then connections and streams learn of it, and the service learns when the last of
//! them is done.

use std::convert::Infallible;
use std::sync::Arc;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use tokio::sync::watch;

use super::app::AppState;

/// How near the end is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Serving,
    Announced,
    Ending,
}

/// The service's end of it.
#[derive(Debug)]
pub struct Drain(watch::Sender<Phase>);

/// Held by whatever must come to an end before the service may.
#[derive(Debug, Clone)]
pub struct Draining(watch::Receiver<Phase>);

impl Drain {
    /// Of a service that goes on.
    pub fn new() -> Self {
        Self(watch::Sender::new(Phase::Serving))
    }

    /// From now on `/readyz` says no.
    pub fn announce(&self) {
        self.0.send_replace(Phase::Announced);
    }

    /// Whether the service is about to end.
    pub fn is_announced(&self) -> bool {
        *self.0.borrow() != Phase::Serving
    }

    /// For one more that must come to an end.
    pub fn listener(&self) -> Draining {
        Draining(self.0.subscribe())
    }

    /// Asks all to end and waits until they have.
    pub async fn finished(&self) {
        self.0.send_replace(Phase::Ending);
        self.0.closed().await;
    }
}

impl Draining {
    /// Ready when all have to end.
    pub async fn begun(&mut self) {
        // An error means that the service is gone already.
        let _ = self.0.wait_for(|phase| *phase == Phase::Ending).await;
    }
}

impl FromRequestParts<Arc<AppState>> for Draining {
    type Rejection = Infallible;

    async fn from_request_parts(_: &mut Parts, app: &Arc<AppState>) -> Result<Self, Infallible> {
        Ok(app.drain.listener())
    }
}
