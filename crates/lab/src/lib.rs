//! placeholder
pub mod report;
pub mod simulator;
pub mod sweep;
