//! Why a measurement failed.

use std::path::PathBuf;

/// Why a measurement failed.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The measured code rejected its input; this is a defect of the benchmark.
    #[error("defect of the benchmark: {0}")]
    Defect(String),
    /// A server or a connection failed.
    #[error("a connection of the benchmark failed: {0}")]
    Connection(#[from] std::io::Error),
    /// The service did not start.
    #[error(transparent)]
    Serve(#[from] revprio::service::ServeError),
    /// The service refused a request.
    #[error(transparent)]
    Client(#[from] revprio_api::ClientError),
    /// A simulation ended early.
    #[error(transparent)]
    Simulation(#[from] revprio_lab::simulator::RunError),
    /// A figure cannot be drawn.
    #[error(transparent)]
    Figure(#[from] revprio_lab::report::Error),
    /// The server under load did not behave as required.
    #[error("the server under load failed: {0}")]
    Load(String),
    /// The server under load did not start.
    #[error(transparent)]
    Program(#[from] revprio::cli::CliError),
    /// A file cannot be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
}

impl BenchError {
    /// Returns the defect that a rejected input shows.
    pub fn defect(error: impl std::fmt::Debug) -> Self {
        Self::Defect(format!("{error:?}"))
    }
}
