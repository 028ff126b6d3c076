//! The settings of the service.

use std::time::Duration;

use super::tls::Tls;
use super::token::Token;

/// Limits, timeouts and secrets of the service. The defaults suit a controller on the same machine.
#[derive(Debug, Clone)]
pub struct ServiceConfig {
    /// The token that requests must send. Required on every address that is not a loopback address.
    pub token: Option<Token>,
    /// Certificate and key. Without them the service uses plain HTTP.
    pub tls: Option<Tls>,
    /// Origins of web pages that may call, such as `https://panel.example`. The service's own pages always may.
    pub allowed_origins: Vec<String>,
    /// Names of the service in the header `Host`, in addition to its address and `localhost`: its name in the network, or
    /// the name of a proxy.
    pub allowed_hosts: Vec<String>,
    /// Maximum size of a body, bytes. The default is enough for 512 rows of 128 joints with all digits. A state has about a
    /// four-thousandth of it.
    pub max_body_bytes: usize,
    /// Maximum size of the body of a batch, bytes.
    pub max_batch_bytes: usize,
    /// Maximum number of bodies above 64 KiB that are read at a time. A body of n MiB counts n times.
    pub max_large_bodies: usize,
    /// Maximum number of open sessions. Each uses a few kilobytes.
    pub max_sessions: usize,
    /// A session ends when it gets no state for this long. Reading the session does not count. A registered robot ends
    /// when it is not used for this long.
    pub session_idle: Duration,
    /// Maximum number of connections. One more connection closes the connection without an answer for the longest time.
    pub max_connections: usize,
    /// Maximum waiting time of a request. Requests that would wait longer are refused at once.
    pub max_lag: Duration,
    /// Deadline of work in other threads, waiting included. Batches have ten times as long.
    pub work_timeout: Duration,
    /// A service that has answered nothing for this long, although it runs, is stuck. `revprio serve` then ends.
    pub stuck_after: Duration,
    /// Timeout for the headers of a request and for an idle connection. Clients commonly close idle connections after
    /// about 15 s.
    pub header_timeout: Duration,
    /// Timeout for a whole body. A client therefore cannot hold a connection by sending slowly.
    pub body_timeout: Duration,
    /// Timeout for a client that reads no byte of its answer.
    pub write_timeout: Duration,
    /// Timeout for the TLS handshake.
    pub handshake_timeout: Duration,
    /// Time between the shutdown signal and the end of listening. During this time `/readyz` answers 503.
    pub drain_delay: Duration,
    /// Timeout for requests in flight after the end of listening. A request that has arrived completely is answered
    /// within milliseconds. A request that is still open after this time waits for a stopped client.
    pub drain_timeout: Duration,
}

impl Default for ServiceConfig {
    fn default() -> Self {
        Self {
            token: None,
            tls: None,
            allowed_origins: Vec::new(),
            allowed_hosts: Vec::new(),
            max_body_bytes: 4 << 20,
            max_batch_bytes: 16 << 20,
            // Enough for the maximum number of batches, each of maximum size.
            max_large_bodies: 64,
            max_sessions: 1024,
            session_idle: Duration::from_mins(15),
            // Below the common limit of 1024 open files.
            max_connections: 1000,
            max_lag: Duration::from_millis(10),
            work_timeout: Duration::from_mins(1),
            stuck_after: Duration::from_secs(5),
            header_timeout: Duration::from_secs(30),
            body_timeout: Duration::from_secs(10),
            write_timeout: Duration::from_secs(10),
            handshake_timeout: Duration::from_secs(10),
            drain_delay: Duration::ZERO,
            drain_timeout: Duration::from_secs(1),
        }
    }
}
