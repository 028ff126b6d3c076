//! A figure's SVG as a PNG: the same picture in pixels.

use resvg::{tiny_skia, usvg};

use super::error::Error;
use super::typeface;

/// Pixels per SVG pixel; a figure of 680 pixels then prints at 300 dpi on 17 cm.
const SCALE: f32 = 3.0;

/// Renders a figure's SVG.
///
/// # Errors
///
/// [`Error::Pixels`] when the SVG does not parse or the image cannot be encoded.
pub fn render(figure: &str, svg: &str) -> Result<Vec<u8>, Error> {
    let options = usvg::Options { fontdb: typeface::database(), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(svg, &options).map_err(|e| pixels(figure, e))?;
    let size = tree.size().to_int_size().scale_by(SCALE);
    let size = size.ok_or_else(|| pixels(figure, "the figure has no area"))?;
    let image = tiny_skia::Pixmap::new(size.width(), size.height());
    let mut image = image.ok_or_else(|| pixels(figure, "the figure is too large"))?;
    let scale = tiny_skia::Transform::from_scale(SCALE, SCALE);
    resvg::render(&tree, scale, &mut image.as_mut());
    image.encode_png().map_err(|e| pixels(figure, e))
}

fn pixels(figure: &str, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Error {
    Error::Pixels { figure: figure.to_owned(), source: source.into() }
}
