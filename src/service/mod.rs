//! The HTTP service.
//!
//! One thread answers all requests: a step takes microseconds, less than handing it to another thread. What keeps that
//! safe and steady, from the outside in:
//!
//! - `server`: listening and ending. Told to end, the service first says so at `/readyz`, then stops listening, then
//!   answers what is in flight.
//! - `connection`: at most [`ServiceConfig::max_connections`]; for one more, the connection without an answer for the
//!   longest time is closed, which is never that of a control loop. Headers, handshakes and answers that are not taken
//!   have their timeouts, after which a connection just ends. Bytes that are no HTTP, and headers beyond 64 KiB, get a
//!   bare 400, 414 or 431 from hyper, without a body; every other error is a problem (RFC 9457).
//! - `gate`: every request gets a name (`x-request-id`), is counted and logged. Those without the token get 401, those
//!   of a foreign web page 403.
//! - `line`: requests that stand too far back get 503 and Retry-After at once instead of a late answer. `/healthz`,
//!   `/readyz` and `/metrics` need not stand in line.
//! - `body`: size and time of bodies are bounded, and how many large ones are read at a time, so that memory is.
//!
//! On any but a loopback address [`serve`] wants a [`Token`].

mod access;
mod app;
mod body;
mod config;
mod connection;
mod convert;
mod gate;
mod handlers;
mod line;
mod metrics;
mod problem;
mod robots;
mod segment;
mod server;
mod sessions;
mod tls;

pub use access::{Token, TokenError};
pub use app::{App, Service, router};
pub use config::ServiceConfig;
pub use robots::Robots;
pub use server::{RunningServer, ServeError, bind, serve};
pub use tls::{Tls, TlsError};
