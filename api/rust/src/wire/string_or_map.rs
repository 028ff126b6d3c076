//! Values that are a word or an object.
//!
//! serde's untagged enums would do, but say only "did not match any variant" when something is wrong.

use std::fmt;
use std::marker::PhantomData;

use serde::Deserializer;
use serde::de::{Error, MapAccess, Visitor};

/// A value that is written as a string or as an object.
pub trait StringOrMap: Sized {
    /// What an error says was expected.
    const EXPECTED: &'static str;

    /// Reads the string.
    fn from_string<E: Error>(text: &str) -> Result<Self, E>;

    /// Reads the object.
    fn from_map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error>;
}

/// Reads either.
pub fn deserialize<'de, D: Deserializer<'de>, T: StringOrMap>(deserializer: D) -> Result<T, D::Error> {
    deserializer.deserialize_any(Either(PhantomData))
}

struct Either<T>(PhantomData<T>);

impl<'de, T: StringOrMap> Visitor<'de> for Either<T> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(T::EXPECTED)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<T, E> {
        T::from_string(text)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::from_map(map)
    }
}
