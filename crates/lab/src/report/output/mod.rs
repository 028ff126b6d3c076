//! Writes reports and figures to a directory.

use std::fs;
use std::path::{Path, PathBuf};

use super::document::{self, Drawn};
use super::error::Error;
use super::figure::Figure;
use super::heat_map::{self, HeatMap};
use super::{Report, drawing, png};

/// A kind of file that [`write()`] can write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// `index.html`.
    Page,
    /// A `.svg` for each figure.
    Svg,
    /// A `.png` for each figure.
    Png,
}

/// Writes the requested kinds of files into a directory and creates the directory if necessary. Returns the paths, the
/// page last.
///
/// # Errors
///
/// [`Error::Write`] if a file cannot be written; the other variants if a figure cannot be drawn.
pub fn write(directory: &Path, report: &Report, outputs: &[Output]) -> Result<Vec<PathBuf>, Error> {
    fs::create_dir_all(directory).map_err(|source| Error::Write { path: directory.to_owned(), source })?;
    let (svg, png) = (outputs.contains(&Output::Svg), outputs.contains(&Output::Png));
    let mut written = Vec::new();
    let mut drawn = Vec::with_capacity(report.sections.len());
    let draw = |figure| Ok(Drawn { figure, drawing: drawing::drawing(figure)?, files: svg && png });
    for section in &report.sections {
        drawn.push(section.figures.iter().map(draw).collect::<Result<Vec<_>, Error>>()?);
    }
    let story = report.story.as_ref().map(|story| draw(&story.figure)).transpose()?;
    for Drawn { figure, drawing, .. } in drawn.iter().flatten().chain(&story) {
        if svg {
            written.push(write_file(directory, &format!("{}.svg", figure.name), drawing.svg.as_bytes())?);
        }
        if png {
            let image = png::render(&figure.name, &drawing.svg)?;
            written.push(write_file(directory, &format!("{}.png", figure.name), &image)?);
        }
    }
    if outputs.contains(&Output::Page) {
        let page = document::html(report, story.as_ref(), &drawn);
        written.push(write_file(directory, "index.html", page.as_bytes())?);
    }
    Ok(written)
}

/// Writes figures as `.svg` and `.png` into an existing directory. Returns the paths.
///
/// # Errors
///
/// As [`write()`].
pub fn write_figures(directory: &Path, figures: &[Figure]) -> Result<Vec<PathBuf>, Error> {
    let files = figures.iter().map(|figure| write_picture(directory, &figure.name, &drawing::svg(figure)?));
    files.collect::<Result<Vec<_>, _>>().map(|files| files.concat())
}

/// Writes a heat map as `.svg` and `.png` into an existing directory. Returns the paths.
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
