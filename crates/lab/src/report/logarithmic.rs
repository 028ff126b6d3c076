//! Figures with two logarithmic axes, in which a power law is a straight line.

use std::ops::Range;

use plotters::backend::SVGBackend;
use plotters::chart::ChartBuilder;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::IntoDrawingArea;
use plotters::element::Circle;
use plotters::style::{Color, FontStyle, WHITE};

use super::error::Error;
use super::figure::{Figure, Panel};
use super::sheet::{
    Area, Drawn, GRID, INK, MARGIN, PLOT_LEFT, RIGHT_MARGIN, TITLE_EM, UNITS_PER_PIXEL, WIDTH, rgb, text, trace, units,
};
use super::{legend, markup, typeface};

const TITLE_HEIGHT: u32 = 36;
const PLOT_HEIGHT: u32 = 300;
const BOTTOM: u32 = 14;
/// Space for the ascenders of the label of the vertical axis.
const LEFT_MARGIN: u32 = 8;
/// Radius of the mark at a point (pixels).
const MARK: u32 = 3;
/// An axis over more decades than this has labels at powers of ten only.
const MAX_DECADES_WITH_STEPS: f64 = 2.5;

/// Draws the first panel of a figure as SVG, with a mark at each point. All values must be positive.
pub fn svg(figure: &Figure) -> Result<String, Error> {
    typeface::register()?;
    let mut elements = String::new();
    let strip = figure.panels.first().map_or(0, |panel| legend::height(&panel.curves));
    let height = TITLE_HEIGHT + strip + PLOT_HEIGHT + MARGIN;
    {
        let size = (WIDTH * UNITS_PER_PIXEL, height * UNITS_PER_PIXEL);
        let page = SVGBackend::with_string(&mut elements, size).into_drawing_area();
        draw(&page, figure, strip).map_err(|source| Error::Draw { figure: figure.name.clone(), source })?;
    }
    Ok(markup::finished(&elements, figure, height))
}

fn draw(page: &Area, figure: &Figure, strip: u32) -> Drawn {
    page.fill(&WHITE)?;
    page.draw_text(&figure.title, &text(TITLE_EM, FontStyle::Bold), (units(MARGIN), units(MARGIN)))?;
    let (_, rest) = page.split_vertically(units(TITLE_HEIGHT));
    if let Some(panel) = figure.panels.first() {
        let (above, below) = rest.split_vertically(units(strip));
        legend::draw(&above, &panel.curves)?;
        draw_axes(&below, panel)?;
    }
    page.present()
}

fn draw_axes(area: &Area, panel: &Panel) -> Drawn {
    let logarithms = |(x, y): (f64, f64)| (x.log10(), y.log10());
    let curves = panel.curves.iter().map(|curve| curve.points.iter().copied().map(logarithms).collect::<Vec<_>>());
    let curves: Vec<_> = curves.collect();
    let points = || curves.iter().flatten();
    let mut chart = ChartBuilder::on(area)
        .margin_left(units(LEFT_MARGIN))
        .margin_right(units(RIGHT_MARGIN))
        .margin_bottom(units(BOTTOM))
        .x_label_area_size(units(42))
        .y_label_area_size(units(PLOT_LEFT))
        .build_cartesian_2d(
            Decades::around(points().map(|point| point.0)),
            Decades::around(points().map(|point| point.1)),
        )?;
    chart
        .configure_mesh()
        .axis_style(INK.stroke_width(UNITS_PER_PIXEL))
        .bold_line_style(GRID.stroke_width(3))
        .light_line_style(GRID.mix(0.0))
        .max_light_lines(0)
        .label_style(text(12.0, FontStyle::Normal))
        .axis_desc_style(text(13.0, FontStyle::Normal))
        .x_desc(&panel.x_label)
        .y_desc(panel.y_label.as_str())
        .draw()?;
    for (curve, points) in panel.curves.iter().zip(&curves) {
        trace(chart.plotting_area(), points.clone(), curve)?;
        let mark = |&point: &(f64, f64)| Circle::new(point, units(MARK), rgb(curve.colour).filled());
        chart.draw_series(points.iter().map(mark))?;
    }
    Ok(())
}

/// A logarithmic axis; the ends are decimal logarithms.
struct Decades {
    low: f64,
    high: f64,
}

impl Decades {
    /// Returns an axis around these logarithms, with a margin of a tenth of a decade.
    fn around(logarithms: impl Iterator<Item = f64>) -> Self {
        let ends = logarithms.map(|value| (value, value)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (low, high) = ends.unwrap_or_default();
        Self { low: low - 0.1, high: high + 0.1 }
    }
}

impl Ranged for Decades {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        RangedCoordf64::from(self.low..self.high).map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        let digits: &[f64] = if self.high - self.low > MAX_DECADES_WITH_STEPS { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let decades = std::iter::successors(Some(self.low.floor()), |decade| Some(decade + 1.0));
        let ticks = decades.take_while(|decade| *decade <= self.high);
        let ticks = ticks.flat_map(|decade| digits.iter().map(move |digit| decade + digit.log10()));
        ticks.filter(|tick| (self.low..=self.high).contains(tick)).collect()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Decades {
    fn format_ext(&self, tick: &f64) -> String {
        // Ticks are 1, 2 and 5 times a power of ten, so one digit is enough.
        let value = 10_f64.powf(*tick);
        let digits = format!("{value:.0e}").parse::<f64>().unwrap_or(value);
        if (-3.1..5.9).contains(tick) { digits.to_string() } else { format!("{digits:e}").replace('-', "−") }
    }
}

#[cfg(test)]
mod tests {
    use plotters::coord::ranged1d::KeyPointWeight;

    use super::*;

    struct Bold;
    impl KeyPointHint for Bold {
        fn max_num_points(&self) -> usize {
            100
        }

        fn weight(&self) -> KeyPointWeight {
            KeyPointWeight::Bold
        }
    }

    fn labels(values: &[f64]) -> Vec<String> {
        let axis = Decades::around(values.iter().map(|value| value.log10()));
        axis.key_points(Bold).into_iter().map(|tick| axis.format_ext(&tick)).collect()
    }

    #[test]
    fn ticks_are_round_numbers_inside_the_axis() {
        assert_eq!(labels(&[3.0, 30.0]), ["5", "10", "20"]);
        assert_eq!(labels(&[1.0, 10_000.0]), ["1", "10", "100", "1000", "10000"]);
        assert_eq!(labels(&[1e-7, 1e-4]), ["1e−7", "1e−6", "1e−5", "1e−4"]);
    }
}
