//! placeholder
pub mod controller;
pub mod law;
pub mod limits;
pub mod linalg;
pub mod resolution;
pub mod task;

pub use revprio_robot as robot;
