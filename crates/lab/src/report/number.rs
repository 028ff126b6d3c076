//! How the report prints numbers.

/// `value` with so many significant digits: in positional notation between 10⁻³ and 10⁵, with an
/// exponent outside; `∞` when infinite.
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

/// Decimal exponent of `value` after rounding to `fraction` digits behind the leading one, read
/// from the standard library's own exact formatting: a logarithm errs near powers of ten.
#[must_use]
pub fn exponent(value: f64, fraction: usize) -> i32 {
    let text = format!("{value:.fraction$e}");
    text.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0)
}

fn decimals(digits: usize, exponent: i32) -> usize {
    digits.saturating_add_signed(-1 - exponent as isize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_large_and_ordinary_numbers_keep_their_digits() {
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
}
