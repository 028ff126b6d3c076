//! From recordings to something to read: metrics, a table, the paper's figures, and one page.
//!
//! ```text
//! runs ─→ metrics ─→ table (rows) ──────────┐
//!      ├→ notes, claims, scenario_words ────┼→ Report ─→ write: index.html, *.svg, *.png
//!      └→ paper_figures, comparison_figure ─┘
//! ```
//!
//! Runs come from the simulator or, with [`experiment::store`], from a directory that an earlier command left.
//!
//! A figure is data ([`figure::Figure`]) until `drawing` turns it into SVG; the PNG is that same SVG
//! rendered, and the page carries it inline, so the three are one picture.

mod axis;
pub mod claims;
pub mod comparison_figure;
mod decimation;
mod document;
mod drawing;
mod error;
pub mod experiment;
pub mod figure;
pub mod heat_map;
mod index;
mod legend;
pub mod logarithmic;
pub mod markdown;
mod markup;
pub mod metrics;
pub mod notes;
mod number;
pub mod paper_figures;
mod png;
pub mod run_figure;
pub mod scenario_words;
pub mod silence;
pub mod table;
mod typeface;

use std::fs;
use std::path::{Path, PathBuf};

use claims::Claim;
use document::Drawn;
use experiment::Program;
use figure::Figure;
use heat_map::HeatMap;
use table::Row;

pub use drawing::svg;
pub use error::Error;

/// Everything that the page says. In its texts, `F_x` sets an index.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// Title of the page.
    pub title: String,
    /// Paragraphs before the table: the question.
    pub introduction: Vec<String>,
    /// Rows of the table, from [`table::rows`].
    pub rows: Vec<Row>,
    /// What the paper claims, beside what was measured.
    pub claims: Vec<Claim>,
    /// What there is to each scenario.
    pub sections: Vec<Section>,
    /// File names of the traces, in the directory of the page.
    pub traces: Vec<String>,
    /// The command that made the runs.
    pub command: String,
    /// The program that made them.
    pub program: Program,
}

/// One scenario.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Section {
    /// Its name.
    pub name: String,
    /// The scenario in words.
    pub words: Vec<String>,
    /// What the runs show.
    pub notes: Vec<String>,
    /// Its runs, side by side.
    pub rows: Vec<Row>,
    /// Figures, as from [`paper_figures::of_posture`].
    pub figures: Vec<Figure>,
}

/// Which files [`write()`] leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// `index.html`.
    Page,
    /// A `.svg` for each figure.
    Svg,
    /// A `.png` for each figure.
    Png,
}

/// Writes every figure as `.svg` and `.png`, and `index.html`, as far as they are wanted, into a directory that is made
/// when missing. Returns what was written, the page last.
///
/// # Errors
///
/// [`Error::Write`] when a file cannot be written; the other variants when a figure cannot be
/// drawn.
pub fn write(directory: &Path, report: &Report, wanted: &[Output]) -> Result<Vec<PathBuf>, Error> {
    fs::create_dir_all(directory).map_err(|source| Error::Write { path: directory.to_owned(), source })?;
    let (svg, png) = (wanted.contains(&Output::Svg), wanted.contains(&Output::Png));
    let mut written = Vec::new();
    let mut drawn = Vec::with_capacity(report.sections.len());
    for section in &report.sections {
        let drawings = section
            .figures
            .iter()
            .map(|figure| Ok(Drawn { figure, drawing: drawing::drawing(figure)?, files: svg && png }));
        drawn.push(drawings.collect::<Result<Vec<_>, Error>>()?);
    }
    for Drawn { figure, drawing, .. } in drawn.iter().flatten() {
        if svg {
            written.push(write_file(directory, &format!("{}.svg", figure.name), drawing.svg.as_bytes())?);
        }
        if png {
            let image = png::render(&figure.name, &drawing.svg)?;
            written.push(write_file(directory, &format!("{}.png", figure.name), &image)?);
        }
    }
    if wanted.contains(&Output::Page) {
        let page = document::html(report, &drawn);
        written.push(write_file(directory, "index.html", page.as_bytes())?);
    }
    Ok(written)
}

/// Writes figures as `.svg` and `.png` into a directory that exists; returns what was written.
///
/// # Errors
///
/// As [`write()`].
pub fn write_figures(directory: &Path, figures: &[Figure]) -> Result<Vec<PathBuf>, Error> {
    let files = figures.iter().map(|figure| write_picture(directory, &figure.name, &drawing::svg(figure)?));
    files.collect::<Result<Vec<_>, _>>().map(|files| files.concat())
}

/// Writes a heat map as `.svg` and `.png` into a directory that exists; returns what was written.
///
/// # Errors
///
/// As [`write()`].
pub fn write_heat_map(directory: &Path, map: &HeatMap) -> Result<Vec<PathBuf>, Error> {
    write_picture(directory, &map.name, &heat_map::svg(map)?)
}

fn write_picture(directory: &Path, name: &str, svg: &str) -> Result<Vec<PathBuf>, Error> {
    let png = png::render(name, svg)?;
    let files = [("svg", svg.as_bytes()), ("png", &png)];
    files.into_iter().map(|(ending, bytes)| write_file(directory, &format!("{name}.{ending}"), bytes)).collect()
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
