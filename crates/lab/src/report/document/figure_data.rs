//! The data of a figure for the script of the page: positions of the axes, and curves.

use serde::Serialize;

use crate::report::decimation::{extremes_per_bucket, within};
use crate::report::drawing::Frame;
use crate::report::figure::{Curve, Figure, Panel, Stroke};
use crate::report::sheet::{rgb, stroke_width};

/// Buckets of a curve, with at most two points each, before points within the tolerance are removed.
const BUCKETS: usize = 4000;
/// Tolerance of a curve, as a fraction of the height of its axes: one pixel of a picture that is enlarged twenty times.
const TOLERANCE: f64 = 1.0 / 4000.0;

#[derive(Serialize)]
struct PanelData<'a> {
    x_label: &'a str,
    x: (i32, i32),
    y: (i32, i32),
    window: (f64, f64),
    y_range: (f64, f64),
    curves: Vec<CurveData<'a>>,
}

#[derive(Serialize)]
struct CurveData<'a> {
    label: &'a str,
    colour: String,
    width: u32,
    dashed: bool,
    /// x0, y0, x1, y1, …
    points: Vec<f64>,
}

/// Returns JSON that is safe inside a `script` element.
pub fn json(figure: &Figure, frames: &[Frame]) -> String {
    let panels: Vec<_> = figure.panels.iter().zip(frames).map(|(panel, frame)| panel_data(panel, frame)).collect();
    // Numbers and texts can always be serialized. A `<` could end the element.
    serde_json::to_string(&panels).unwrap_or_else(|_| "[]".to_owned()).replace('<', "\\u003c")
}

fn panel_data<'a>(panel: &'a Panel, frame: &Frame) -> PanelData<'a> {
    let tolerance = TOLERANCE * (frame.y_range.1 - frame.y_range.0);
    PanelData {
        x_label: &panel.x_label,
        x: frame.x,
        y: frame.y,
        window: panel.window,
        y_range: frame.y_range,
        curves: panel.curves.iter().map(|curve| curve_data(panel, curve, tolerance)).collect(),
    }
}

fn curve_data<'a>(panel: &Panel, curve: &'a Curve, tolerance: f64) -> CurveData<'a> {
    let points = within(&extremes_per_bucket(&panel.visible(curve), BUCKETS), tolerance);
    let colour = rgb(curve.colour);
    CurveData {
        label: &curve.label,
        colour: format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2),
        width: stroke_width(curve.stroke),
        dashed: curve.stroke == Stroke::Dashed,
        points: points.into_iter().flat_map(|(x, y)| [rounded(x), rounded(y)]).collect(),
    }
}

/// Rounds to seven significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::figure::{Colour, TIME};

    #[test]
    fn script_data_keeps_spikes_and_cannot_end_the_script_element() {
        let points = (0..5000).map(|i| (1e-3 * f64::from(i), if i == 2500 { 240.0 } else { 30.0 })).collect();
        let label = "</script>".to_owned();
        let curve = Curve { label, colour: Colour::Blue, stroke: Stroke::Thin, points };
        let panel = Panel {
            heading: String::new(),
            x_label: TIME.to_owned(),
            y_label: String::new(),
            window: (0.0, 5.0),
            y_covers: Vec::new(),
            curves: vec![curve],
        };
        let figure = Figure { name: "a".to_owned(), title: String::new(), caption: String::new(), panels: vec![panel] };
        let frame = Frame { x: (0, 100), y: (0, 100), y_range: (0.0, 250.0) };
        let json = json(&figure, &[frame]);
        assert!(!json.contains("</script>"));
        let data: serde_json::Value = serde_json::from_str(&json).unwrap();
        let points = data[0]["curves"][0]["points"].as_array().unwrap();
        assert_eq!(points.len(), 2 * 5, "two ends, the spike and its two adjacent points");
        assert!(points.chunks(2).any(|point| point[0] == 2.5 && point[1] == 240.0));
        assert_eq!(data[0]["curves"][0]["colour"], "#0072B2");
    }
}
