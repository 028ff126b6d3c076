//! The font of every figure, `DejaVu Sans`. It is embedded in the program, so a figure looks the same on every machine.

use std::sync::{Arc, LazyLock};

use plotters::style::{FontStyle, IntoFont, register_font};
use resvg::usvg::fontdb;

use super::error::Error;

/// Font family in the SVG. The fallback fonts are not wider than `DejaVu Sans`, so no text is cut off.
pub const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// Text size of plotters for an em of one pixel: its SVG backend divides by this number.
pub const SIZE_PER_EM: f64 = 1.24;

static DATABASE: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut database = fontdb::Database::new();
    database.load_font_data(dejavu::sans::regular().to_vec());
    database.load_font_data(dejavu::sans::bold().to_vec());
    Arc::new(database)
});

/// Returns the fonts for rendering as PNG.
#[must_use]
pub fn database() -> Arc<fontdb::Database> {
    Arc::clone(&DATABASE)
}

/// Registers the fonts with the drawing library.
///
/// # Errors
///
/// [`Error::Font`] when the embedded font cannot be read.
pub fn register() -> Result<(), Error> {
    let faces = [(FontStyle::Normal, dejavu::sans::regular()), (FontStyle::Bold, dejavu::sans::bold())];
    faces.into_iter().try_for_each(|(style, bytes)| register_font(FAMILY, style, bytes)).map_err(|_| Error::Font)
}

/// Returns the width of a text with an em of `em` units, in the same units. Call [`register`] first.
#[must_use]
pub fn width(text: &str, em: f64) -> i32 {
    let size = (FAMILY, em * SIZE_PER_EM).into_font().box_size(text);
    size.ok().and_then(|(width, _)| i32::try_from(width).ok()).unwrap_or(0)
}
