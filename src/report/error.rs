//! What can go wrong while a report is written.

use std::io;
use std::path::PathBuf;

use plotters::drawing::DrawingAreaErrorKind;

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
