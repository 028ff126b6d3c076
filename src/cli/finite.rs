//! Numbers of the command line.

/// Reads a number that is neither infinite nor NaN.
pub fn finite(text: &str) -> Result<f64, &'static str> {
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or("give a finite number")
}
