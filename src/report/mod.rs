//! From recordings to something to read: metrics, a table, the paper's figures, and one page.
//!
//! ```text
//! recordings ─→ metrics ─→ table (rows) ─┐
//!            └→ paper_figures (figures) ─┴→ Report ─→ write: index.html, *.svg, *.png
//! ```
//!
//! A figure is data ([`figure::Figure`]) until `drawing` turns it into SVG; the PNG is that same SVG
//! rendered, and the page carries it inline, so the three are one picture.

mod axis;
mod decimation;
mod document;
mod drawing;
mod error;
pub mod figure;
mod index;
mod legend;
mod markup;
pub mod metrics;
pub mod notes;
mod number;
pub mod paper_figures;
mod png;
pub mod run_figure;
pub mod table;
mod typeface;

use std::fs;
use std::path::{Path, PathBuf};

use document::Drawn;
use figure::Figure;
use table::Row;

pub use drawing::svg;
pub use error::Error;

/// Everything that the page says. In its texts, `F_x` sets an index.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Title of the page.
    pub title: String,
    /// Paragraphs before the table.
    pub introduction: Vec<String>,
    /// Rows of the table, from [`table::rows`].
    pub rows: Vec<Row>,
    /// What to know about each scenario.
    pub notes: Vec<Note>,
    /// Figures, as from [`paper_figures::of_posture`].
    pub figures: Vec<Figure>,
    /// File names of the traces, in the directory of the page.
    pub traces: Vec<String>,
    /// The command that made the report.
    pub command: String,
}

/// A remark on a scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// Name of the scenario.
    pub scenario: String,
    /// The remark.
    pub text: String,
}

/// Writes every figure as `.svg` and `.png`, and `index.html`, into a directory that is made when
/// missing. Returns what was written, the page last.
///
/// # Errors
///
/// [`Error::Write`] when a file cannot be written; the other variants when a figure cannot be
/// drawn.
pub fn write(directory: &Path, report: &Report) -> Result<Vec<PathBuf>, Error> {
    fs::create_dir_all(directory).map_err(|source| Error::Write { path: directory.to_owned(), source })?;
    let mut written = Vec::new();
    let mut figures = Vec::new();
    for figure in &report.figures {
        let svg = drawing::svg(figure)?;
        let png = png::render(&figure.name, &svg)?;
        for (extension, bytes) in [("svg", svg.as_bytes()), ("png", &png)] {
            let name = format!("{}.{extension}", figure.name);
            written.push(write_file(directory, &name, bytes)?);
        }
        figures.push(Drawn { figure, svg });
    }
    let page = document::html(report, &figures);
    written.push(write_file(directory, "index.html", page.as_bytes())?);
    Ok(written)
}

fn write_file(directory: &Path, name: &str, bytes: &[u8]) -> Result<PathBuf, Error> {
    let path = directory.join(name);
    match fs::write(&path, bytes) {
        Ok(()) => Ok(path),
        Err(source) => Err(Error::Write { path, source }),
    }
}

#[cfg(test)]
mod tests;
