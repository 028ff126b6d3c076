//! Measures how fast the program is, side by side with what else does the same.
//!
//! ```text
//! core, http, pacing ─→ rows ────┐
//! growth ────────────→ series ───┴→ Report ─→ text, JSON, Markdown in documents, figures
//! ```
//!
//! Times say little without a peer in the same run: the machine, its load and its clock differ from day to day. Peers
//! that are Rust (nalgebra, faer, Clarabel, a bare axum route, a bare TCP connection) run here; those in C++ and Python
//! run in `benches/peers`. No result passes or fails.

mod core;
mod document;
mod growth;
mod http;
mod pacing;
mod plan;
mod plot;
mod problems;
mod repeat;
mod report;
mod row;
mod series;
mod timing;

pub use plan::{Group, Plan};
pub use problems::lines as problem_lines;
pub use repeat::{Repeated, repeat};
pub use report::Report;

use std::path::PathBuf;

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// What was to be measured refused its input: a defect of the measurement.
    #[error("the measurement is wrong: {0}")]
    Defect(String),
    /// A server or a connection failed.
    #[error("a connection of the measurement failed: {0}")]
    Connection(#[from] std::io::Error),
    /// The service did not start.
    #[error(transparent)]
    Serve(#[from] crate::service::ServeError),
    /// The service refused a request.
    #[error(transparent)]
    Client(#[from] crate::client::ClientError),
    /// A simulation ended early.
    #[error(transparent)]
    Simulation(#[from] crate::simulator::RunError),
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] crate::report::Error),
    /// A file cannot be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

impl BenchError {
    fn defect(error: impl std::fmt::Debug) -> Self {
        Self::Defect(format!("{error:?}"))
    }
}
