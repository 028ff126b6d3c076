//! Numbers of the command line.

/// Reads a number that is neither infinite nor NaN.
pub fn finite(text: &str) -> Result<f64, &'static str> {
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or("give a finite number")
}

/// Reads a number that is neither negative nor infinite nor NaN.
pub fn not_negative(text: &str) -> Result<f64, &'static str> {
    finite(text).ok().filter(|value| *value >= 0.0).ok_or("give a finite number from 0 on")
}
