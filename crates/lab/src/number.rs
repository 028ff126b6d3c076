//! Numbers as text.

use std::fmt;

/// Formats `value` with the given number of significant digits: between 10⁻³ and 10⁵ without an exponent, outside with
/// one; `∞` if infinite.
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "not a number".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "-∞" }.to_owned();
    }
    let fraction = digits.saturating_sub(1);
    match exponent(value, fraction) {
        _ if value == 0.0 => "0".to_owned(),
        e if (-3..5).contains(&e) => format!("{value:.0$}", decimals(digits, e)),
        _ => format!("{value:.fraction$e}"),
    }
}

/// Returns the decimal exponent of `value` after rounding to `fraction` digits after the leading one. It uses the exact
/// formatting of the standard library, because a logarithm is not exact near powers of ten.
#[must_use]
pub fn exponent(value: f64, fraction: usize) -> i32 {
    let text = format!("{value:.fraction$e}");
    text.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0)
}

/// A number with all its digits: between 10⁻⁴ and 10⁶ without an exponent, outside with one.
#[derive(Debug, Clone, Copy)]
pub struct Exact(pub f64);

impl fmt::Display for Exact {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self(value) = self;
        match value.abs() {
            0.0 => write!(f, "0"),
            size if (1e-4..1e6).contains(&size) || !size.is_finite() => write!(f, "{value}"),
            _ => write!(f, "{value:e}"),
        }
    }
}

/// Formats `value` like [`Exact`], with at most six significant digits.
#[must_use]
pub fn plain(value: f64) -> String {
    Exact(format!("{value:.5e}").parse().unwrap_or(value)).to_string()
}

/// Formats `value` like [`plain`]. The minus sign is U+2212.
#[must_use]
pub fn trimmed(value: f64) -> String {
    plain(value).replace('-', "−")
}

fn decimals(digits: usize, exponent: i32) -> usize {
    digits.saturating_add_signed(-1 - exponent as isize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_any_size_keep_their_significant_digits() {
        let cases = [
            (0.0, "0"),
            (0.167_34, "0.167"),
            (-0.001_234, "-0.00123"),
            (0.000_999_9, "0.00100"),
            (9.999, "10.0"),
            (213.9, "214"),
            (19_876.0, "19876"),
            (1.234e-10, "1.23e-10"),
            (123_456.0, "1.23e5"),
            (f64::INFINITY, "∞"),
            (f64::NAN, "not a number"),
        ];
        for (value, expected) in cases {
            assert_eq!(significant(value, 3), expected);
        }
    }

    #[test]
    fn numbers_of_any_size_are_short() {
        let cases = [
            (0.0, "0"),
            (-0.0, "0"),
            (29_950.0, "29950"),
            (300_997.668_3, "300998"),
            (-0.000_1, "-0.0001"),
            (0.000_099, "9.9e-5"),
            (999_999.7, "1e6"),
            (1e-200, "1e-200"),
            (-1.5e300, "-1.5e300"),
            (f64::INFINITY, "inf"),
        ];
        for (value, expected) in cases {
            assert_eq!(plain(value), expected);
        }
        assert_eq!(trimmed(-0.5), "−0.5");
        assert_eq!(Exact(999_999.7).to_string(), "999999.7");
    }
}
