//! revprio
pub mod cli;
pub mod client;
pub mod controller;
pub mod kinematics;
pub mod law;
pub mod limits;
pub mod linalg;
pub mod report;
pub mod resolution;
pub mod robot;
pub mod service;
pub mod simulator;
pub mod task;
pub mod wire;
