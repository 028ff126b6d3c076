//! The legend, in a strip above the axes, so that it never covers a curve.

use plotters::style::FontStyle;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::figure::Curve;
use super::sheet::{self, Area, Drawn, PLOT_LEFT, RIGHT_MARGIN, UNITS_PER_PIXEL, WIDTH, units};
use super::typeface;

const ROW_HEIGHT: u32 = 20;
const SAMPLE: u32 = 30;
const GAP: u32 = 7;
const SPACING: u32 = 22;
const EM: f64 = 12.0;

/// Position of an entry: left end (units) and row.
struct Place {
    x: i32,
    row: u32,
}

/// Returns the height of the strip (pixels).
#[must_use]
pub fn height(curves: &[Curve]) -> u32 {
    places(curves).last().map_or(0, |place| (place.row + 1) * ROW_HEIGHT)
}

/// Draws the strip at the top of `area`.
///
/// # Errors
///
/// Errors of the drawing library.
pub fn draw(area: &Area<'_>, curves: &[Curve]) -> Drawn {
    let style = sheet::text(EM, FontStyle::Normal).pos(Pos::new(HPos::Left, VPos::Center));
    for (curve, place) in curves.iter().zip(places(curves)) {
        let y = units(place.row * ROW_HEIGHT + ROW_HEIGHT / 2);
        sheet::trace(area, vec![(place.x, y), (place.x + units(SAMPLE), y)], curve)?;
        area.draw_text(&curve.label, &style, (place.x + units(SAMPLE + GAP), y))?;
    }
    Ok(())
}

/// Places the entries from left to right and starts a new row if an entry does not fit.
fn places(curves: &[Curve]) -> Vec<Place> {
    let right = units(WIDTH - RIGHT_MARGIN);
    let mut next = Place { x: units(PLOT_LEFT), row: 0 };
    let mut places = Vec::with_capacity(curves.len());
    for curve in curves {
        let width = units(SAMPLE + GAP) + typeface::width(&curve.label, EM * f64::from(UNITS_PER_PIXEL));
        if next.x + width > right && next.x > units(PLOT_LEFT) {
            next = Place { x: units(PLOT_LEFT), row: next.row + 1 };
        }
        let following = Place { x: next.x + width + units(SPACING), row: next.row };
        places.push(std::mem::replace(&mut next, following));
    }
    places
}
