//! The content of a figure, independent of how it is drawn.

/// A figure of the report.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// File name without extension, and anchor in the page: `figure5_nominal`.
    pub name: String,
    /// Title inside the picture. In this and all other texts, `F_x` prints x as an index.
    pub title: String,
    /// Text below the picture; only the page shows it.
    pub caption: String,
    /// Panels from top to bottom.
    pub panels: Vec<Panel>,
}

/// Horizontal axis of a panel over the simulated time.
pub const TIME: &str = "time (s)";

/// One set of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Heading above the axes.
    pub heading: String,
    /// Quantity and unit of the horizontal axis, usually [`TIME`].
    pub x_label: String,
    /// Quantity and unit of the vertical axis.
    pub y_label: String,
    /// Range of the horizontal axis; points outside are not drawn.
    pub window: (f64, f64),
    /// Values (unit of `y_label`) that the vertical axis also covers, so that two figures can share a scale.
    pub y_covers: Vec<f64>,
    /// Curves; the first one is drawn first.
    pub curves: Vec<Curve>,
}

impl Panel {
    /// Returns the points of a curve inside the window.
    #[must_use]
    pub fn visible(&self, curve: &Curve) -> Vec<(f64, f64)> {
        let (from, to) = self.window;
        let shown = |&(x, value): &(f64, f64)| x >= from && x <= to && value.is_finite();
        curve.points.iter().copied().filter(shown).collect()
    }

    /// Returns the smallest and largest value that the vertical axis must cover; (0, 0) if there are none.
    #[must_use]
    pub fn y_extent(&self) -> (f64, f64) {
        let values = self.curves.iter().flat_map(|c| self.visible(c)).map(|(_, value)| value);
        let covered = values.chain(self.y_covers.iter().copied());
        covered.map(|value| (value, value)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default()
    }
}

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Legend text.
    pub label: String,
    /// Colour of the line.
    pub colour: Colour,
    /// Shape of the line.
    pub stroke: Stroke,
    /// Abscissa and value, in the units of the panel, in ascending order.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// Returns the largest vertical distance to another curve with the same abscissas (unit of the panel).
    #[must_use]
    pub fn largest_distance(&self, other: &Self) -> f64 {
        let distances = self.points.iter().zip(&other.points).map(|(a, b)| (a.1 - b.1).abs());
        distances.fold(0.0, f64::max)
    }
}

/// Line shapes that stay distinguishable where curves coincide: a wide line is visible on both sides of a thin one and
/// through the gaps of a dashed one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// A wide line; draw it first.
    Wide,
    /// A thin line.
    Thin,
    /// A thin dashed line; draw it last.
    Dashed,
}

/// Colours of Okabe and Ito, distinguishable with every kind of colour vision. Orange and blue also differ in lightness,
/// so they stay distinguishable in a black-and-white print.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    /// Black.
    Black,
    /// Orange, light.
    Orange,
    /// Blue, dark.
    Blue,
    /// Bluish green.
    Green,
    /// Vermillion.
    Vermillion,
    /// Sky blue, light.
    SkyBlue,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(points: Vec<(f64, f64)>) -> Panel {
        let curve = Curve { label: String::new(), colour: Colour::Blue, stroke: Stroke::Thin, points };
        Panel {
            heading: String::new(),
            x_label: TIME.to_owned(),
            y_label: String::new(),
            window: (0.0, 1.0),
            y_covers: vec![],
            curves: vec![curve],
        }
    }

    #[test]
    fn points_outside_the_window_do_not_stretch_the_axis() {
        let panel = panel(vec![(-0.1, 50.0), (0.0, 1.0), (1.0, 3.0), (1.1, -50.0), (0.5, f64::NAN)]);
        assert_eq!(panel.y_extent(), (1.0, 3.0));
    }

    #[test]
    fn shared_scale_covers_the_values_of_the_other_figure() {
        let panel = Panel { y_covers: vec![-2.0, 9.0], ..panel(vec![(0.0, 1.0)]) };
        assert_eq!(panel.y_extent(), (-2.0, 9.0));
    }
}
