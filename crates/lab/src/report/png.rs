//! Renders the SVG of a figure as PNG.

use resvg::{tiny_skia, usvg};

use super::error::Error;
use super::typeface;

/// PNG pixels per SVG pixel. A figure of 680 SVG pixels has 300 dpi on 17 cm of paper.
const SCALE: f32 = 3.0;

/// Renders the SVG of a figure as PNG.
///
/// # Errors
///
/// [`Error::Png`] if the SVG does not parse or the image cannot be encoded.
pub fn render(figure: &str, svg: &str) -> Result<Vec<u8>, Error> {
    let options = usvg::Options { fontdb: typeface::database(), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(svg, &options).map_err(|e| error(figure, e))?;
    let size = tree.size().to_int_size().scale_by(SCALE);
    let size = size.ok_or_else(|| error(figure, "its area is zero"))?;
    let image = tiny_skia::Pixmap::new(size.width(), size.height());
    let mut image = image.ok_or_else(|| error(figure, "it is too large"))?;
    let scale = tiny_skia::Transform::from_scale(SCALE, SCALE);
    resvg::render(&tree, scale, &mut image.as_mut());
    image.encode_png().map_err(|e| error(figure, e))
}

fn error(figure: &str, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Error {
    Error::Png { figure: figure.to_owned(), source: source.into() }
}
