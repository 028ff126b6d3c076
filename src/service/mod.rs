//! The HTTP service.

mod app;
mod body;
mod convert;
mod handlers;
mod problem;
mod robots;
mod segment;
mod server;
mod sessions;

pub use app::{App, router};
pub use robots::Robots;
pub use server::{RunningServer, ServeError, bind, serve};
