//! The values of a varied quantity: `log:1e3..1e6:20`, `lin:0..0.01:5`, `0,0.001,0.005`, `auto,qp`.

use std::fmt;
use std::str::FromStr;

use serde_json::Value;

/// Largest number of values of one quantity.
const MAX_VALUES: usize = 1_000_000;

/// A quantity and its values: `PATH=VALUES`.
#[derive(Debug, Clone, PartialEq)]
pub struct Variation {
    /// Path in the scenario.
    pub path: String,
    /// Values, in order.
    pub values: Vec<Value>,
    text: String,
}

impl Variation {
    /// Returns a quantity with these values; `text` is their notation.
    pub fn new(path: &str, values: Vec<Value>, text: &str) -> Self {
        Self { path: path.to_owned(), values, text: format!("{path}={text}") }
    }

    /// Returns the values if all of them are numbers and there are at least two.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        let numbers: Vec<f64> = self.values.iter().map(Value::as_f64).collect::<Option<_>>()?;
        (numbers.len() > 1).then_some(numbers)
    }

    /// Returns whether the values are spaced logarithmically.
    pub fn is_logarithmic(&self) -> bool {
        self.text.contains("=log:")
    }
}

impl fmt::Display for Variation {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.text)
    }
}

impl FromStr for Variation {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (path, values) = text.split_once('=').ok_or("write PATH=VALUES, for example loop.lag_s=0,0.001")?;
        if path.is_empty() {
            return Err("the path before `=` is missing".to_owned());
        }
        let parsed = match values.split_once(':') {
            Some(("lin", range)) => spaced(range, |from, to, t| from + (to - from) * t)?,
            Some(("log", range)) => {
                let values = spaced(range, |from, to, t| from * (to / from).powf(t))?;
                if values.iter().any(|value| value.as_f64().is_none_or(|value| value == 0.0)) {
                    return Err(format!(
                        "`{range}`: the ends of a logarithmic range must have the same sign and must not be 0"
                    ));
                }
                values
            }
            _ => values.split(',').map(value).collect::<Result<_, _>>()?,
        };
        Ok(Self::new(path, parsed, values))
    }
}

/// Parses `from..to:count`; the values include both ends.
fn spaced(range: &str, between: impl Fn(f64, f64, f64) -> f64) -> Result<Vec<Value>, String> {
    let wrong = || format!("`{range}` is not a range; write FROM..TO:COUNT, for example 1e3..1e6:20");
    let (ends, count) = range.rsplit_once(':').ok_or_else(wrong)?;
    let (from, to) = ends.split_once("..").ok_or_else(wrong)?;
    let number = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(wrong);
    let (from, to) = (number(from)?, number(to)?);
    if count.is_empty() || !count.bytes().all(|digit| digit.is_ascii_digit()) {
        return Err(wrong());
    }
    // A number that is too large to parse is above the maximum too.
    let count = count.parse().ok().filter(|count| (1..=MAX_VALUES).contains(count));
    let count = count.ok_or_else(|| format!("`{range}`: COUNT must be from 1 to {MAX_VALUES}"))?;
    let at = |i: usize| match i {
        0 => from,
        i if i + 1 == count => to,
        i => between(from, to, i as f64 / (count - 1) as f64),
    };
    Ok((0..count).map(|i| Value::from(at(i))).collect())
}

/// Parses a number, `true`, `false`, `null`, or a word.
fn value(text: &str) -> Result<Value, String> {
    if text.is_empty() {
        return Err("a value between two commas is missing".to_owned());
    }
    let is_plain = |value: &Value| !(value.is_array() || value.is_object() || value.is_string());
    let plain = serde_json::from_str(text).ok().filter(is_plain);
    // Words, and numbers that are not valid JSON: `.5`, `1.`.
    let number = || text.parse().ok().filter(|number: &f64| number.is_finite()).map(Value::from);
    Ok(plain.or_else(number).unwrap_or_else(|| Value::from(text)))
}

/// A range of seeds `0..99`, including both ends, or one seed `3`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seeds {
    first: u64,
    last: u64,
}

impl Seeds {
    /// Returns the seeds as a quantity.
    pub fn variation(self) -> Variation {
        let values = (self.first..=self.last).map(Value::from).collect();
        Variation::new("seed", values, &format!("{}..{}", self.first, self.last))
    }
}

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (first, last) = text.split_once("..").unwrap_or((text, text));
        let number = |text: &str| text.parse().map_err(|_| format!("`{text}` is not a seed; write 0..99 or 3"));
        let seeds = Self { first: number(first)?, last: number(last)? };
        if seeds.first > seeds.last {
            return Err(format!("`{text}` is not a range of seeds; write 0..99"));
        }
        if seeds.last - seeds.first >= MAX_VALUES as u64 {
            return Err(format!("`{text}` has too many seeds; give at most {MAX_VALUES}"));
        }
        Ok(seeds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str) -> Vec<f64> {
        text.parse::<Variation>().unwrap().numbers().unwrap()
    }

    #[test]
    fn ranges_include_both_ends_exactly() {
        assert_eq!(numbers("a=lin:0..1:5"), [0.0, 0.25, 0.5, 0.75, 1.0]);
        let stiffness = numbers("environment.stiffness=log:1e3..1e6:4");
        assert_eq!((stiffness[0], stiffness[3]), (1e3, 1e6));
        assert!((stiffness[1] / 1e4 - 1.0).abs() < 1e-14);
    }

    #[test]
    fn lists_contain_numbers_and_words() {
        let values = "solver=auto,qp,1,.5,true".parse::<Variation>().unwrap().values;
        assert_eq!(values, [Value::from("auto"), "qp".into(), 1.into(), 0.5.into(), true.into()]);
        assert_eq!("0..2".parse::<Seeds>().unwrap().variation().values, [0, 1, 2]);
    }

    #[test]
    fn too_many_values_are_refused_with_the_maximum() {
        for count in ["0", "1000001", "1000000000", "99999999999999999999999"] {
            let refusal = format!("a=lin:0..1:{count}").parse::<Variation>().unwrap_err();
            assert_eq!(refusal, format!("`0..1:{count}`: COUNT must be from 1 to 1000000"));
        }
        assert_eq!("a=lin:0..1:1000000".parse::<Variation>().unwrap().values.len(), 1_000_000);
        let refusal = "0..99999999999".parse::<Seeds>().unwrap_err();
        assert_eq!(refusal, "`0..99999999999` has too many seeds; give at most 1000000");
    }

    #[test]
    fn invalid_values_are_refused() {
        for wrong in
            ["a", "=1", "a=log:0..1:3", "a=log:-1..1:3", "a=lin:0..1", "a=lin:0..1:0", "a=lin:0..inf:3", "a=1,,2"]
        {
            assert!(wrong.parse::<Variation>().is_err(), "{wrong}");
        }
        for wrong in ["", "a", "5..3", "0..", "-1..2"] {
            assert!(wrong.parse::<Seeds>().is_err(), "{wrong}");
        }
    }
}
