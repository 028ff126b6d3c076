//! What is wrong with a scenario, and where.

use std::fmt;

use revprio_api::wire::PerAxis;

/// Largest number that a scenario may hold: far above any quantity of an arm, far below what overflows when squared.
const LARGEST: f64 = 1e9;

/// A quantity that makes no sense.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldError {
    /// JSON pointer of the field.
    pub pointer: String,
    /// What is wrong with it.
    pub problem: String,
}

impl FieldError {
    /// A flaw of the field at a JSON pointer.
    pub fn new(pointer: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), problem: problem.into() }
    }
}

impl fmt::Display for FieldError {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "`{}` {}", self.pointer.trim_start_matches('/').replace('/', "."), self.problem)
    }
}

/// A number of sensible size.
pub fn number(value: f64, pointer: &str) -> Result<f64, FieldError> {
    if value.abs() <= LARGEST {
        Ok(value)
    } else {
        Err(FieldError::new(pointer, format!("is out of range; {value:e} does not lie between -1e9 and 1e9")))
    }
}

/// A number of sensible size that is not negative.
pub fn not_negative(value: f64, pointer: &str) -> Result<f64, FieldError> {
    if value < 0.0 {
        return Err(FieldError::new(pointer, format!("must not be negative, but is {value}")));
    }
    number(value, pointer)
}

/// A number of sensible size above zero.
pub fn positive(value: f64, pointer: &str) -> Result<f64, FieldError> {
    if !(value > 0.0) {
        return Err(FieldError::new(pointer, format!("must be positive, but is {value}")));
    }
    number(value, pointer)
}

/// A whole number in a range.
pub fn between(value: usize, least: usize, most: usize, pointer: &str) -> Result<usize, FieldError> {
    if (least..=most).contains(&value) {
        Ok(value)
    } else {
        Err(FieldError::new(pointer, format!("is out of range; {value} does not lie between {least} and {most}")))
    }
}

/// One number per row that the check lets pass.
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
            format!("has {} values where {rows} belong; or give one for all", values.len()),
        )),
    }
}
