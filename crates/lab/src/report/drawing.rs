//! Draws a [`Figure`] as SVG: a title, then per panel a heading, a legend and the axes.

use std::io;

use plotters::backend::SVGBackend;
use plotters::chart::ChartBuilder;
use plotters::coord::ranged1d::Ranged;
use plotters::coord::{CoordTranslate, Shift};
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{DashedPathElement, PathElement};
use plotters::style::{Color, FontStyle, RGBColor, ShapeStyle, TextStyle, WHITE};

use super::axis::Axis;
use super::decimation::{extremes_per_bucket, within};
use super::error::Error;
use super::figure::{Colour, Curve, Figure, Panel, Stroke};
use super::{legend, markup, typeface};

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

const TITLE_HEIGHT: u32 = 36;
const HEADING_HEIGHT: u32 = 24;
const PLOT_HEIGHT: u32 = 190;
const X_LABELS_HEIGHT: u32 = 42;
const GAP: u32 = 14;
const Y_LABELS_WIDTH: u32 = 76;
const TICK: u32 = 4;
/// Buckets of a curve, with two points each. A higher resolution than a quarter of a pixel is not visible.
const BUCKETS: usize = 600;
/// Tolerance of a curve, as a fraction of the height of its axes: half a unit.
const TOLERANCE: f64 = 0.5 / (PLOT_HEIGHT * UNITS_PER_PIXEL) as f64;

/// Colour of axes and text.
pub const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Colour of grid lines.
pub const GRID: RGBColor = RGBColor(0xdd, 0xdd, 0xdd);

type Area<'a, C = Shift> = DrawingArea<SVGBackend<'a>, C>;
type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<io::Error>>;

/// A figure as SVG, with the positions of its axes.
pub struct Drawing {
    /// The document, `WIDTH` pixels wide.
    pub svg: String,
    /// The axes of each panel.
    pub frames: Vec<Frame>,
}

/// Position of the axes of a panel in the units of the SVG, and range of the vertical axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Left and right end.
    pub x: (i32, i32),
    /// Upper and lower end.
    pub y: (i32, i32),
    /// Values at the lower and upper end, unit of the panel.
    pub y_range: (f64, f64),
}

/// Draws a figure as SVG, `WIDTH` pixels wide.
///
/// # Errors
///
/// [`Error::Font`] when the embedded font cannot be read, [`Error::Draw`] when the drawing fails.
pub fn svg(figure: &Figure) -> Result<String, Error> {
    drawing(figure).map(|drawing| drawing.svg)
}

/// Draws a figure as SVG and returns the positions of its axes.
///
/// # Errors
///
/// As [`svg`].
pub fn drawing(figure: &Figure) -> Result<Drawing, Error> {
    typeface::register()?;
    let mut elements = String::new();
    let height = figure_height(figure);
    let frames = {
        let size = (WIDTH * UNITS_PER_PIXEL, height * UNITS_PER_PIXEL);
        let page = SVGBackend::with_string(&mut elements, size).into_drawing_area();
        draw(&page, figure).map_err(|source| Error::Draw { figure: figure.name.clone(), source })?
    };
    Ok(Drawing { svg: markup::finished(&elements, figure, height), frames })
}

/// Converts pixels to units of the drawing library.
#[must_use]
pub fn units(pixels: u32) -> i32 {
    (pixels * UNITS_PER_PIXEL).cast_signed()
}

/// Returns each panel and whether it shows a legend. It does not if the panel above has all of its curves.
fn with_legends(panels: &[Panel]) -> impl Iterator<Item = (&Panel, bool)> {
    let has = |panel: &Panel, curve: &Curve| panel.curves.iter().any(|other| other.label == curve.label);
    let repeats = move |i: usize| i > 0 && panels[i].curves.iter().all(|curve| has(&panels[i - 1], curve));
    panels.iter().enumerate().map(move |(i, panel)| (panel, !repeats(i)))
}

fn figure_height(figure: &Figure) -> u32 {
    let panels = with_legends(&figure.panels).map(|(panel, with_legend)| panel_height(panel, with_legend));
    TITLE_HEIGHT + panels.sum::<u32>() + MARGIN
}

fn panel_height(panel: &Panel, with_legend: bool) -> u32 {
    let legend = if with_legend { legend::height(&panel.curves) } else { 0 };
    HEADING_HEIGHT + legend + PLOT_HEIGHT + X_LABELS_HEIGHT + GAP
}

fn draw(page: &Area, figure: &Figure) -> Drawn<Vec<Frame>> {
    page.fill(&WHITE)?;
    page.draw_text(&figure.title, &text(TITLE_EM, FontStyle::Bold), (units(MARGIN), units(MARGIN)))?;
    let (_, mut rest) = page.split_vertically(units(TITLE_HEIGHT));
    let mut frames = Vec::with_capacity(figure.panels.len());
    for (panel, with_legend) in with_legends(&figure.panels) {
        let (area, below) = rest.split_vertically(units(panel_height(panel, with_legend)));
        frames.push(draw_panel(&area, panel, with_legend)?);
        rest = below;
    }
    page.present()?;
    Ok(frames)
}

fn draw_panel(area: &Area, panel: &Panel, with_legend: bool) -> Drawn<Frame> {
    area.draw_text(&panel.heading, &text(13.0, FontStyle::Normal), (units(MARGIN), units(4)))?;
    let (_, below) = area.split_vertically(units(HEADING_HEIGHT));
    if !with_legend {
        return draw_axes(&below, panel);
    }
    let (strip, below) = below.split_vertically(units(legend::height(&panel.curves)));
    legend::draw(&strip, &panel.curves)?;
    draw_axes(&below, panel)
}

fn draw_axes(area: &Area, panel: &Panel) -> Drawn<Frame> {
    let y_axis = Axis::around(panel.y_extent());
    let y_range = y_axis.range();
    let mut chart = ChartBuilder::on(area)
        .margin_left(units(MARGIN))
        .margin_right(units(RIGHT_MARGIN))
        .margin_bottom(units(GAP))
        .x_label_area_size(units(X_LABELS_HEIGHT))
        .y_label_area_size(units(Y_LABELS_WIDTH))
        .build_cartesian_2d(Axis::exactly(panel.window), y_axis)?;
    chart
        .configure_mesh()
        .axis_style(INK.stroke_width(UNITS_PER_PIXEL))
        .bold_line_style(GRID.stroke_width(3))
        .light_line_style(GRID.mix(0.0))
        .max_light_lines(0)
        .set_all_tick_mark_size(units(TICK))
        .label_style(text(12.0, FontStyle::Normal))
        .axis_desc_style(text(13.0, FontStyle::Normal))
        .x_desc(&panel.x_label)
        .y_desc(panel.y_label.as_str())
        .draw()?;
    for curve in &panel.curves {
        let points = extremes_per_bucket(&panel.visible(curve), BUCKETS);
        trace(chart.plotting_area(), within(&points, TOLERANCE * (y_range.end - y_range.start)), curve)?;
    }
    let (x, y) = chart.plotting_area().get_pixel_range();
    Ok(Frame { x: (x.start, x.end), y: (y.start, y.end), y_range: (y_range.start, y_range.end) })
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
