//! Figures of growth curves and histograms.

use revprio_lab::report::figure::{Colour, Curve, Figure, Panel, Stroke};

use super::pacing::Paced;
use super::series::Growth;

const COLOURS: [Colour; 5] = [Colour::Orange, Colour::Blue, Colour::Green, Colour::Vermillion, Colour::Black];

/// Returns the figure of growth curves, with the slope in the legend.
pub fn growth(growth: &Growth) -> Figure {
    let curves = growth.series.iter();
    let curves = curves.map(|series| (format!("{}: slope {:.2}", series.name, series.slope), series.points.clone()));
    figure(growth.name, growth.title, growth.size, growth.value, curves)
}

/// Returns the histogram of round trips.
pub fn latency(paced: &[Paced]) -> Figure {
    let name = |paced: &Paced| format!("{} Hz: {} of {} missed", paced.rate_hz, paced.missed, paced.periods);
    let curves = paced.iter().map(|paced| (name(paced), paced.histogram.clone()));
    figure("latency", "Round trips of a control loop", "round trip (s)", "share of the answers", curves)
}

/// Label and points of a curve.
type Labelled = (String, Vec<(f64, f64)>);

fn figure(name: &str, title: &str, x_label: &str, y_label: &str, curves: impl Iterator<Item = Labelled>) -> Figure {
    let curve =
        |((label, points), colour): (Labelled, &Colour)| Curve { label, colour: *colour, stroke: Stroke::Thin, points };
    let panel = Panel {
        heading: String::new(),
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        window: (0.0, f64::INFINITY),
        y_covers: Vec::new(),
        curves: curves.zip(COLOURS.iter().cycle()).map(curve).collect(),
    };
    Figure { name: name.to_owned(), title: title.to_owned(), caption: String::new(), panels: vec![panel] }
}
