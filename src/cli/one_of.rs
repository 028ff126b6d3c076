//! Options whose value is one of some words.

use std::fmt::Display;

use clap::builder::{PossibleValuesParser, TypedValueParser};

/// Returns a parser that accepts each of the values as it is displayed.
pub fn one_of<T: Copy + Display + Send + Sync>(values: &'static [T]) -> impl TypedValueParser<Value = T> {
    let words = PossibleValuesParser::new(values.iter().map(T::to_string));
    words.try_map(|word| values.iter().copied().find(|value| value.to_string() == word).ok_or("not a known value"))
}
