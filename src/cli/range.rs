//! Plausible ranges of the numbers on the command line.

use revprio_lab::number::Exact;

use super::error::CliError;

/// The plausible range of an option. It is generous: a number outside has the wrong unit or a wrong exponent.
pub struct Range {
    pub option: &'static str,
    pub unit: &'static str,
    pub lowest: f64,
    pub highest: f64,
}

impl Range {
    /// Refuses a number outside the range.
    pub fn check(&self, value: f64) -> Result<(), CliError> {
        if (self.lowest..=self.highest).contains(&value) { Ok(()) } else { Err(self.refusal(value, "")) }
    }

    /// Refuses a number whose magnitude is outside the range. Its sign is a direction.
    pub fn check_magnitude(&self, value: f64) -> Result<(), CliError> {
        self.check(value.abs()).map_err(|_| self.refusal(value, "; the sign is the direction"))
    }

    fn refusal(&self, value: f64, remark: &str) -> CliError {
        let Self { option, unit, lowest, highest } = self;
        let (value, lowest, highest) = (Exact(value), Exact(*lowest), Exact(*highest));
        let detail = format!("{value} {unit} is out of range; give {lowest} to {highest} {unit}{remark}");
        CliError::Option { option: (*option).to_owned(), detail }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_outside_are_refused_with_option_value_unit_and_range() {
        let range = Range { option: "--way-m", unit: "m", lowest: 1e-5, highest: 2.0 };
        assert!([1e-5, 1.0, 2.0].into_iter().all(|value| range.check(value).is_ok()));
        assert!(range.check_magnitude(-1.0).is_ok());
        for value in [-1.0, 0.0, 1e-200, 2.1, f64::NAN, f64::INFINITY] {
            assert!(range.check(value).is_err(), "{value}");
        }
        let text = |refused: Result<(), CliError>| refused.unwrap_err().to_string();
        assert_eq!(text(range.check(1e-200)), "--way-m: 1e-200 m is out of range; give 1e-5 to 2 m");
        let signed = text(range.check_magnitude(-3.0));
        assert_eq!(signed, "--way-m: -3 m is out of range; give 1e-5 to 2 m; the sign is the direction");
    }
}
