//! Functions for `#[serde(deserialize_with = …)]` that read whole numbers which may be written as 214103.0.
//!
//! Languages with one type of numbers, such as Lua or MATLAB, write whole numbers with a fraction of zero.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};

/// Doubles from here on do not represent every whole number, so one of them may have been rounded.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// A whole number.
struct Integer<T>(T);

impl<'de, T: TryFrom<u64>> Deserialize<'de> for Integer<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(IntegerVisitor(PhantomData)).map(Self)
    }
}

struct IntegerVisitor<T>(PhantomData<T>);

impl<T: TryFrom<u64>> Visitor<'_> for IntegerVisitor<T> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a whole number, not negative")
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<T, E> {
        T::try_from(value).map_err(|_| E::invalid_value(Unexpected::Unsigned(value), &self))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<T, E> {
        let unsigned = u64::try_from(value).map_err(|_| E::invalid_value(Unexpected::Signed(value), &self))?;
        self.visit_u64(unsigned)
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the value is whole and in range")]
    fn visit_f64<E: Error>(self, value: f64) -> Result<T, E> {
        if value.fract() == 0.0 && (0.0..MAX_EXACT).contains(&value) {
            self.visit_u64(value as u64)
        } else {
            Err(E::invalid_value(Unexpected::Float(value), &self))
        }
    }
}

/// Reads a whole number.
pub fn deserialize<'de, D: Deserializer<'de>, T: TryFrom<u64>>(deserializer: D) -> Result<T, D::Error> {
    Integer::deserialize(deserializer).map(|Integer(value)| value)
}

/// Reads a whole number, or `None` from `null`.
pub fn optional<'de, D: Deserializer<'de>, T: TryFrom<u64>>(deserializer: D) -> Result<Option<T>, D::Error> {
    Ok(Option::deserialize(deserializer)?.map(|Integer(value)| value))
}

#[cfg(test)]
mod tests {
    use crate::wire::{Object, State};

    fn sequence(text: &str) -> Result<u64, String> {
        let body = format!(r#"{{"sequence": {text}, "time_s": 0, "joint_position": []}}"#);
        serde_json::from_str(&body).map(|Object(state): Object<State>| state.sequence).map_err(|e| e.to_string())
    }

    #[test]
    fn whole_numbers_are_read_in_every_notation() {
        for (text, value) in
            [("214103", 214_103), ("214103.0", 214_103), ("2.14103e5", 214_103), ("0.0", 0), ("-0.0", 0)]
        {
            assert_eq!(sequence(text), Ok(value), "{text}");
        }
        assert_eq!(sequence("9007199254740991.0"), Ok((1 << 53) - 1));
        assert_eq!(sequence("18446744073709551615"), Ok(u64::MAX));
    }

    #[test]
    fn other_numbers_are_refused() {
        for text in ["0.5", "-1", "-1.0", "1e300", "9007199254740992.0", "\"1\"", "null", "true"] {
            assert!(sequence(text).unwrap_err().contains("whole number"), "{text}");
        }
    }
}
