//! The HTTP service.

mod accept;
mod app;
mod background;
mod body;
mod convert;
mod drain;
mod events;
mod format;
mod handlers;
mod problem;
mod resolve;
mod robots;
mod segment;
mod server;
mod sessions;
mod simulations;
mod stream;

pub use app::{App, router};
pub use robots::Robots;
pub use server::{RunningServer, ServeError, bind, serve};
