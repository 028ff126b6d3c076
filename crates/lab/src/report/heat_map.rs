//! Heat maps: a quantity as colour over two other quantities.

use plotters::backend::SVGBackend;
use plotters::drawing::IntoDrawingArea;
use plotters::element::Rectangle;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, RGBColor, TextStyle, WHITE};

use super::error::Error;
use super::figure::Figure;
use super::sheet::{Area, Drawn, MARGIN, TITLE_EM, UNITS_PER_PIXEL, WIDTH, text, units};
use super::{markup, number, typeface};

/// A heat map. All cells have the same size, also if the values on an axis are not equidistant.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// File name without extension.
    pub name: String,
    /// Title inside the picture.
    pub title: String,
    /// Quantity and values from left to right.
    pub x: Scale,
    /// Quantity and values from bottom to top.
    pub y: Scale,
    /// Quantity and unit of the colours.
    pub label: String,
    /// Value of each cell, row by row from the bottom; `None` if a cell has no value.
    pub cells: Vec<Vec<Option<f64>>>,
}

/// One axis of a heat map.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// Quantity and unit.
    pub label: String,
    /// Values, in order.
    pub values: Vec<f64>,
}

const TOP: u32 = 44;
const LEFT: u32 = 96;
const FIELD_HEIGHT: u32 = 340;
const BOTTOM: u32 = 56;
const BAR_LEFT: u32 = WIDTH - 110;
const BAR_WIDTH: u32 = 16;
const FIELD_WIDTH: u32 = BAR_LEFT - 24 - LEFT;
const HEIGHT: u32 = TOP + FIELD_HEIGHT + BOTTOM;
const BAR_STEPS: u32 = 64;
const MAX_LABELS: usize = 8;
const EM: f64 = 12.0;

/// Colour of cells without a value.
const MISSING: RGBColor = RGBColor(0xe4, 0xe4, 0xe4);

/// The colour map viridis, from dark to light. It is perceptually uniform, also with colour vision deficiency.
const COLOURS: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];

/// Draws a heat map as SVG.
///
/// # Errors
///
/// [`Error::Font`] when the embedded font cannot be read, [`Error::Draw`] when the drawing fails.
pub fn svg(map: &HeatMap) -> Result<String, Error> {
    typeface::register()?;
    let mut elements = String::new();
    {
        let size = (WIDTH * UNITS_PER_PIXEL, HEIGHT * UNITS_PER_PIXEL);
        let page = SVGBackend::with_string(&mut elements, size).into_drawing_area();
        draw(&page, map).map_err(|source| Error::Draw { figure: map.name.clone(), source })?;
    }
    let figure =
        Figure { name: map.name.clone(), title: map.title.clone(), caption: String::new(), panels: Vec::new() };
    Ok(markup::finished(&elements, &figure, HEIGHT))
}

fn draw(page: &Area, map: &HeatMap) -> Drawn {
    page.fill(&WHITE)?;
    let has_gaps = map.cells.iter().flatten().any(Option::is_none);
    let title = format!("{}{}", map.title, if has_gaps { " (grey: no value)" } else { "" });
    page.draw_text(&title, &text(TITLE_EM, FontStyle::Bold), (units(MARGIN), units(MARGIN)))?;
    let colours = Colours::of(map);
    #[expect(clippy::cast_possible_truncation, reason = "within the picture")]
    let edge = |i: usize, count: usize, length: u32| {
        (f64::from(units(length)) * i as f64 / count.max(1) as f64).round() as i32
    };
    let (nx, ny) = (map.x.values.len(), map.y.values.len());
    let (left, bottom) = (units(LEFT), units(TOP + FIELD_HEIGHT));
    for (j, row) in map.cells.iter().enumerate() {
        for (i, value) in row.iter().enumerate() {
            let from = (left + edge(i, nx, FIELD_WIDTH), bottom - edge(j + 1, ny, FIELD_HEIGHT));
            let to = (left + edge(i + 1, nx, FIELD_WIDTH), bottom - edge(j, ny, FIELD_HEIGHT));
            let colour = value.map_or(MISSING, |value| colours.of_value(value));
            page.draw(&Rectangle::new([from, to], colour.filled()))?;
        }
    }
    let below = anchored(HPos::Center, VPos::Top);
    for i in labelled(nx) {
        let middle = left + i32::midpoint(edge(i, nx, FIELD_WIDTH), edge(i + 1, nx, FIELD_WIDTH));
        page.draw_text(&number::significant(map.x.values[i], 3), &below, (middle, bottom + units(6)))?;
    }
    let left_label = anchored(HPos::Right, VPos::Center);
    for j in labelled(ny) {
        let middle = bottom - i32::midpoint(edge(j, ny, FIELD_HEIGHT), edge(j + 1, ny, FIELD_HEIGHT));
        page.draw_text(&number::significant(map.y.values[j], 3), &left_label, (left - units(6), middle))?;
    }
    page.draw_text(&map.x.label, &below, (left + units(FIELD_WIDTH / 2), bottom + units(28)))?;
    let upwards = anchored(HPos::Center, VPos::Top).transform(FontTransform::Rotate270);
    page.draw_text(&map.y.label, &upwards, (units(MARGIN), units(TOP + FIELD_HEIGHT / 2)))?;
    draw_bar(page, map, &colours)?;
    page.present()
}

fn draw_bar(page: &Area, map: &HeatMap, colours: &Colours) -> Drawn {
    let (left, bottom) = (units(BAR_LEFT), units(TOP + FIELD_HEIGHT));
    let height = |step: u32| units(FIELD_HEIGHT * step) / BAR_STEPS.cast_signed();
    for step in 0..BAR_STEPS {
        let colour = blend((f64::from(step) + 0.5) / f64::from(BAR_STEPS));
        let corners = [(left, bottom - height(step + 1)), (left + units(BAR_WIDTH), bottom - height(step))];
        page.draw(&Rectangle::new(corners, colour.filled()))?;
    }
    let right_label = anchored(HPos::Left, VPos::Center);
    for quarter in 0..=4_u32 {
        let value = number::significant(colours.value_at(f64::from(quarter) / 4.0), 3);
        page.draw_text(&value, &right_label, (left + units(BAR_WIDTH + 6), bottom - height(BAR_STEPS * quarter / 4)))?;
    }
    let above = anchored(HPos::Right, VPos::Bottom);
    page.draw_text(&map.label, &above, (units(WIDTH - MARGIN), units(TOP - 6)))
}

fn anchored(horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    text(EM, FontStyle::Normal).pos(Pos::new(horizontal, vertical))
}

/// Returns the indices of the cells that get a label.
fn labelled(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(MAX_LABELS).max(1))
}

/// Maps values to colours over their range; on a logarithmic scale if the range is large.
struct Colours {
    low: f64,
    high: f64,
    is_logarithmic: bool,
}

impl Colours {
    fn of(map: &HeatMap) -> Self {
        let values = || map.cells.iter().flatten().flatten().copied().filter(|value| value.is_finite());
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        if low > high {
            return Self { low: 0.0, high: 1.0, is_logarithmic: false };
        }
        Self { low, high, is_logarithmic: low > 0.0 && high > 100.0 * low }
    }

    fn of_value(&self, value: f64) -> RGBColor {
        let place = if self.is_logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        // NaN if all values are the same.
        blend(if place.is_nan() { 0.5 } else { place.clamp(0.0, 1.0) })
    }

    fn value_at(&self, place: f64) -> f64 {
        if self.is_logarithmic {
            self.low * (self.high / self.low).powf(place)
        } else {
            self.low + (self.high - self.low) * place
        }
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 255, and between 0 and 4")]
fn blend(place: f64) -> RGBColor {
    let along = place * (COLOURS.len() - 1) as f64;
    let below = (along as usize).min(COLOURS.len() - 2);
    let part = along - below as f64;
    let [r, g, b] = [0, 1, 2].map(|i| (COLOURS[below][i] * (1.0 - part) + COLOURS[below + 1][i] * part).round() as u8);
    RGBColor(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(cells: Vec<Vec<Option<f64>>>) -> HeatMap {
        let scale = |label: &str, count: usize| Scale {
            label: label.to_owned(),
            values: (0..count).map(|i| i as f64).collect(),
        };
        HeatMap {
            name: "map".to_owned(),
            title: "A map".to_owned(),
            x: scale("lag (s)", cells[0].len()),
            y: scale("stiffness (N/m)", cells.len()),
            label: "peak (N)".to_owned(),
            cells,
        }
    }

    #[test]
    fn extreme_values_have_the_extreme_colours_and_missing_ones_are_grey() {
        let drawn = svg(&map(vec![vec![Some(1.0), Some(3.0)], vec![None, Some(2.0)]])).unwrap();
        for colour in ["#440154", "#FDE725", "#E4E4E4"] {
            assert!(drawn.to_uppercase().contains(colour), "{colour}");
        }
        assert!(drawn.contains("stiffness (N/m)") && drawn.contains("peak (N)"));
    }

    #[test]
    fn large_ranges_use_a_logarithmic_scale() {
        let colours = Colours::of(&map(vec![vec![Some(1.0), Some(1e4)]]));
        assert_eq!(colours.of_value(100.0), blend(0.5));
        assert!((colours.value_at(0.5) / 100.0 - 1.0).abs() < 1e-12);
        assert_eq!(Colours::of(&map(vec![vec![Some(7.0)]])).of_value(7.0), blend(0.5));
        svg(&map(vec![vec![None]])).unwrap();
    }
}
