//! What an operator can tune.

use std::net::SocketAddr;
use std::time::Duration;

use super::access::Token;
use super::server::ServeError;
use super::tls::Tls;

/// Limits, timeouts and secrets of the service; the default is right for a controller on this machine.
#[derive(Debug, Clone)]
pub struct ServiceConfig {
    /// What requests must show; needed on any address but a loopback one.
    pub token: Option<Token>,
    /// Certificate and key; without them the service speaks plain HTTP.
    pub tls: Option<Tls>,
    /// Origins of web pages that may call, such as `https://panel.example`, besides the service's own.
    pub allowed_origins: Vec<String>,
    /// Largest body in bytes; a state is about one thousandth of the default.
    pub max_body_bytes: usize,
    /// Largest body of a batch in bytes.
    pub max_batch_bytes: usize,
    /// Bodies of more than 64 KiB that may be read at a time; one of several MiB counts as so many.
    pub max_large_bodies: usize,
    /// Sessions at a time; each holds a few kilobytes.
    pub max_sessions: usize,
    /// A session that gets no state for this long ends, and a registered robot that is not used; looking at a session
    /// does not keep it.
    pub session_idle: Duration,
    /// Connections at a time; for one more, the one that got no answer for the longest time is closed.
    pub max_connections: usize,
    /// How long the line of waiting requests may take; those further back are refused at once.
    pub max_lag: Duration,
    /// Time for a request's headers, and for an idle connection. Clients keep idle connections for some 15 s.
    pub header_timeout: Duration,
    /// Time in which a whole body must come in, so that a client cannot hold its connection by trickling.
    pub body_timeout: Duration,
    /// Time after which a client that takes no byte of its answer is dropped.
    pub write_timeout: Duration,
    /// Time for the TLS handshake.
    pub handshake_timeout: Duration,
    /// Time between the signal to end and the end of listening, in which `/readyz` says no.
    pub drain_delay: Duration,
    /// Time for requests in flight when the service ends. One that came in whole is answered within milliseconds; what
    /// is open after this waits for a client that stopped in the middle.
    pub drain_timeout: Duration,
}

impl Default for ServiceConfig {
    fn default() -> Self {
        Self {
            token: None,
            tls: None,
            allowed_origins: Vec::new(),
            max_body_bytes: 1 << 20,
            max_batch_bytes: 16 << 20,
            // As many of the largest batches as are taken in at a time.
            max_large_bodies: 64,
            max_sessions: 1024,
            session_idle: Duration::from_mins(15),
            // Below the 1024 open files that systems commonly allow.
            max_connections: 1000,
            max_lag: Duration::from_millis(10),
            header_timeout: Duration::from_secs(30),
            body_timeout: Duration::from_secs(10),
            write_timeout: Duration::from_secs(10),
            handshake_timeout: Duration::from_secs(10),
            drain_delay: Duration::ZERO,
            drain_timeout: Duration::from_secs(1),
        }
    }
}

impl ServiceConfig {
    /// Refuses an address that others reach, unless requests must show a token.
    pub fn check(&self, address: SocketAddr) -> Result<(), ServeError> {
        if address.ip().to_canonical().is_loopback() || self.token.is_some() {
            return Ok(());
        }
        Err(ServeError::TokenNeeded { address })
    }
}
