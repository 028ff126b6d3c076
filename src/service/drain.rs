//! The orderly shutdown.
//!
//! The service first announces its end, then asks connections and streams to end, and waits until all of them have.

use tokio::sync::watch;

/// Phase of the shutdown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Serving,
    Announced,
    Ending,
}

/// Controls the shutdown.
#[derive(Debug)]
pub struct Drain(watch::Sender<Phase>);

/// Held by each connection and stream. The service waits until all are dropped.
#[derive(Debug, Clone)]
pub struct Draining(watch::Receiver<Phase>);

impl Drain {
    /// Creates the control of a service that is not shutting down.
    pub fn new() -> Self {
        Self(watch::Sender::new(Phase::Serving))
    }

    /// Announces the shutdown: from now on `/readyz` answers 503.
    pub fn announce(&self) {
        self.0.send_replace(Phase::Announced);
    }

    /// Returns whether the shutdown was announced.
    pub fn is_announced(&self) -> bool {
        *self.0.borrow() != Phase::Serving
    }

    /// Adds a connection or stream to wait for.
    pub fn subscribe(&self) -> Draining {
        Draining(self.0.subscribe())
    }

    /// Asks all subscribers to end, and waits until they have.
    pub async fn finish(&self) {
        self.0.send_replace(Phase::Ending);
        self.0.closed().await;
    }
}

impl Draining {
    /// Waits until the subscriber has to end.
    pub async fn begun(&mut self) {
        // An error means that the service has ended already.
        let _ = self.0.wait_for(|phase| *phase == Phase::Ending).await;
    }
}
