//! Growth curves.

use serde::Serialize;

/// One curve.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// What was measured.
    pub name: String,
    /// Size and value.
    pub points: Vec<(f64, f64)>,
    /// Exponent of the growth: the slope of a straight line through the logarithms.
    pub slope: f64,
}

impl Series {
    /// Returns a curve through these points, ascending in size.
    pub fn new(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        let slope = slope(&points);
        Self { name: name.into(), points, slope }
    }
}

/// Curves that share their axes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Growth {
    /// File name of the figure without extension.
    pub name: &'static str,
    /// Title of the figure.
    pub title: &'static str,
    /// Quantity and unit of the sizes.
    pub size: &'static str,
    /// Quantity and unit of the values.
    pub value: &'static str,
    /// The curves.
    pub series: Vec<Series>,
}

/// Fits a straight line to the logarithms by least squares; 0 for fewer than two sizes.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logarithms: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logarithms.len().max(1) as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logarithms.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let (mut covariance, mut variance) = (0.0, 0.0);
    for point in &logarithms {
        covariance += (point.0 - x) * (point.1 - y);
        variance += (point.0 - x).powi(2);
    }
    if variance > 0.0 { covariance / variance } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_is_the_exponent() {
        let cubic = Series::new("", [1.0, 2.0, 5.0].map(|x: f64| (x, 7.0 * x.powi(3))).to_vec());
        assert!((cubic.slope - 3.0).abs() < 1e-12);
        assert_eq!(Series::new("", vec![(2.0, 1.0)]).slope, 0.0);
    }
}
