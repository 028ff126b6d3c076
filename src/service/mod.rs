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
pub use convert::robot_answer;
pub use robots::{Robots, RobotsError};
pub use server::{RunningServer, ServeError, bind, serve};
