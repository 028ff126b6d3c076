//! Sizes, colours and strokes that all figures share.

use std::io;

use plotters::backend::SVGBackend;
use plotters::coord::{CoordTranslate, Shift};
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::element::{DashedPathElement, PathElement};
use plotters::style::{Color, FontStyle, RGBColor, ShapeStyle, TextStyle};

use super::figure::{Colour, Curve, Stroke};
use super::typeface;

/// Units per pixel. The backend rounds every coordinate to a whole unit, so a unit is a quarter of a pixel.
pub const UNITS_PER_PIXEL: u32 = 4;
/// Width of a figure (pixels).
pub const WIDTH: u32 = 680;

/// Margin around the figure (pixels).
pub const MARGIN: u32 = 12;
/// Margin right of the axes, wide enough for half a tick label (pixels).
pub const RIGHT_MARGIN: u32 = 18;
/// Left end of the axes (pixels).
pub const PLOT_LEFT: u32 = MARGIN + Y_LABELS_WIDTH;
/// Text size of a title (pixels).
pub const TITLE_EM: f64 = 14.0;
/// Width of the labels left of the axes (pixels).
pub const Y_LABELS_WIDTH: u32 = 76;

/// Colour of axes and text.
pub const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Colour of grid lines.
pub const GRID: RGBColor = RGBColor(0xdd, 0xdd, 0xdd);

/// Part of a sheet.
pub type Area<'a, C = Shift> = DrawingArea<SVGBackend<'a>, C>;
/// Result of drawing.
pub type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<io::Error>>;

/// Converts pixels to units of the drawing library.
#[must_use]
pub fn units(pixels: u32) -> i32 {
    (pixels * UNITS_PER_PIXEL).cast_signed()
}

/// Draws a line through the points in the colour and stroke of a curve.
///
/// # Errors
///
/// Errors of the drawing library.
pub fn trace<C: CoordTranslate>(area: &Area<'_, C>, points: Vec<C::From>, curve: &Curve) -> Drawn
where
    C::From: Clone,
{
    let style = line(curve);
    match curve.stroke {
        Stroke::Wide | Stroke::Thin => area.draw(&PathElement::new(points, style)),
        Stroke::Dashed => area.draw(&DashedPathElement::new(points, units(6), units(4), style)),
    }
}

/// Returns a text style with an em of the given size (pixels).
#[must_use]
pub fn text(em: f64, weight: FontStyle) -> TextStyle<'static> {
    let size = em * f64::from(UNITS_PER_PIXEL) * typeface::SIZE_PER_EM;
    TextStyle::from((typeface::FAMILY, size, weight)).color(&INK)
}

fn line(curve: &Curve) -> ShapeStyle {
    rgb(curve.colour).stroke_width(stroke_width(curve.stroke))
}

/// Returns the width of a line in units.
#[must_use]
pub const fn stroke_width(stroke: Stroke) -> u32 {
    match stroke {
        Stroke::Wide => 17,
        Stroke::Thin | Stroke::Dashed => 5,
    }
}

/// Returns the RGB value of a colour.
#[must_use]
pub const fn rgb(colour: Colour) -> RGBColor {
    match colour {
        Colour::Black => RGBColor(0, 0, 0),
        Colour::Orange => RGBColor(0xe6, 0x9f, 0x00),
        Colour::Blue => RGBColor(0x00, 0x72, 0xb2),
        Colour::Green => RGBColor(0x00, 0x9e, 0x73),
        Colour::Vermillion => RGBColor(0xd5, 0x5e, 0x00),
        Colour::SkyBlue => RGBColor(0x56, 0xb4, 0xe9),
    }
}
