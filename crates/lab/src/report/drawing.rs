//! Draws a [`Figure`] as SVG: a title, then per panel a heading, a legend and the axes.

use plotters::backend::SVGBackend;
use plotters::chart::ChartBuilder;
use plotters::coord::ranged1d::Ranged;
use plotters::drawing::IntoDrawingArea;
use plotters::style::{Color, FontStyle, WHITE};

use super::axis::Axis;
use super::decimation::{extremes_per_bucket, within};
use super::error::Error;
use super::figure::{Curve, Figure, Panel};
use super::sheet::{
    Area, Drawn, GRID, INK, MARGIN, RIGHT_MARGIN, TITLE_EM, UNITS_PER_PIXEL, WIDTH, Y_LABELS_WIDTH, text, trace, units,
};
use super::{legend, markup, typeface};

const TITLE_HEIGHT: u32 = 36;
const HEADING_HEIGHT: u32 = 24;
const PLOT_HEIGHT: u32 = 190;
const X_LABELS_HEIGHT: u32 = 42;
const GAP: u32 = 14;
const TICK: u32 = 4;
/// Buckets of a curve, with two points each. A higher resolution than a quarter of a pixel is not visible.
const BUCKETS: usize = 600;
/// Tolerance of a curve, as a fraction of the height of its axes: half a unit.
const TOLERANCE: f64 = 0.5 / (PLOT_HEIGHT * UNITS_PER_PIXEL) as f64;

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
