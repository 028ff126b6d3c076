//! Errors of reading and writing reports.

use std::io;
use std::path::PathBuf;

use plotters::drawing::DrawingAreaErrorKind;

use crate::simulator::recording::ReadError;

/// Why a report cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or the directory cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file or directory.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A directory has no description of its recordings.
    #[error(
        "cannot read {}: {source}; give a directory that `simulate`, `demo` or `compare` wrote with --out",
        path.display()
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The description of the recordings is not valid.
    #[error("{}: {source}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// The error.
        source: serde_json::Error,
    },
    /// A recording cannot be read.
    #[error("{}: {source}", path.display())]
    Trace {
        /// The file.
        path: PathBuf,
        /// The error.
        source: Box<ReadError>,
    },
    /// The embedded font cannot be read.
    #[error("the embedded font cannot be read")]
    Font,
    /// The drawing library reported an error.
    #[error("cannot draw {figure}: {source}")]
    Draw {
        /// Name of the figure.
        figure: String,
        /// The error.
        source: DrawingAreaErrorKind<io::Error>,
    },
    /// A figure cannot be rendered as PNG.
    #[error("cannot render {figure} as PNG: {source}")]
    Png {
        /// Name of the figure.
        figure: String,
        /// The error.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}
