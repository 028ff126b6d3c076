//! placeholder
pub mod cli;
mod dashboard;
pub mod service;
