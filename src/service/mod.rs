//! The HTTP service.

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
