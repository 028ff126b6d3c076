//! revprio
pub mod controller;
pub mod kinematics;
pub mod law;
pub mod limits;
pub mod linalg;
pub mod resolution;
pub mod robot;
pub mod task;
