//! Errors in the fields of a scenario.

use std::fmt;

use revprio_api::wire::PerAxis;

/// Largest absolute value in a scenario: far above any quantity of an arm, and its square does not overflow.
const MAX_VALUE: f64 = 1e9;

/// A value that is not valid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldError {
    /// JSON pointer of the field.
    pub pointer: String,
    /// Why it is not valid.
    pub problem: String,
}

impl FieldError {
    /// Returns an error of the field at a JSON pointer.
    pub fn new(pointer: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), problem: problem.into() }
    }
}

impl fmt::Display for FieldError {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "`{}` {}", self.pointer.trim_start_matches('/').replace('/', "."), self.problem)
    }
}

/// Checks that a number is not too large.
pub fn number(value: f64, pointer: &str) -> Result<f64, FieldError> {
    if value.abs() <= MAX_VALUE {
        Ok(value)
    } else {
        Err(FieldError::new(pointer, format!("is {value:e}; it must be between -1e9 and 1e9")))
    }
}

/// Checks that a number is not negative and not too large.
pub fn not_negative(value: f64, pointer: &str) -> Result<f64, FieldError> {
    if value < 0.0 {
        return Err(FieldError::new(pointer, format!("must not be negative, but is {value}")));
    }
    number(value, pointer)
}

/// Checks that a number is positive and not too large.
pub fn positive(value: f64, pointer: &str) -> Result<f64, FieldError> {
    if !(value > 0.0) {
        return Err(FieldError::new(pointer, format!("must be positive, but is {value}")));
    }
    number(value, pointer)
}

/// Checks that an integer is in a range.
pub fn between(value: usize, min: usize, max: usize, pointer: &str) -> Result<usize, FieldError> {
    if (min..=max).contains(&value) {
        Ok(value)
    } else {
        Err(FieldError::new(pointer, format!("is {value}; it must be between {min} and {max}")))
    }
}

/// Returns one checked number per row.
pub fn per_row(
    values: &PerAxis<f64>,
    rows: usize,
    pointer: &str,
    check: impl Fn(f64, &str) -> Result<f64, FieldError>,
) -> Result<Vec<f64>, FieldError> {
    match values {
        PerAxis::All(value) => Ok(vec![check(*value, pointer)?; rows]),
        PerAxis::Each(values) if values.len() == rows => {
            values.iter().enumerate().map(|(i, value)| check(*value, &format!("{pointer}/{i}"))).collect()
        }
        PerAxis::Each(values) => Err(FieldError::new(
            pointer,
            format!("has {} values; give {rows} values, or one number for all", values.len()),
        )),
    }
}
