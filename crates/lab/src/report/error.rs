//! What can go wrong while a report is written.

use std::io;
use std::path::PathBuf;

use plotters::drawing::DrawingAreaErrorKind;

use crate::simulator::recording::ReadError;

/// A report that could not be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or the directory could not be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// Where.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A directory does not say what its traces are.
    #[error("cannot read {}: {source}; `simulate`, `demo` and `compare` leave it in the directory of their --out", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// The description of the traces is something else.
    #[error("{}: {source}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// A trace cannot be used.
    #[error("{}: {source}", path.display())]
    Trace {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<ReadError>,
    },
    /// The embedded font could not be read.
    #[error("the embedded font is unusable")]
    Font,
    /// The drawing library refused a figure.
    #[error("cannot draw {figure}")]
    Draw {
        /// Name of the figure.
        figure: String,
        /// Why.
        source: DrawingAreaErrorKind<io::Error>,
    },
    /// A drawn figure could not be turned into pixels.
    #[error("cannot turn {figure} into pixels")]
    Pixels {
        /// Name of the figure.
        figure: String,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}
