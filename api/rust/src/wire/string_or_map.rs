//! Reads a value that is written as a string or as an object.
//!
//! Its error texts name what is wrong. Untagged enums of serde say only "did not match any variant".

use std::fmt;
use std::marker::PhantomData;

use serde::Deserializer;
use serde::de::{Error, MapAccess, Visitor};

/// A value that is written as a string or as an object.
pub trait StringOrMap: Sized {
    /// What the text of an error names as expected.
    const EXPECTED: &'static str;

    /// Reads the value from a string.
    fn from_string<E: Error>(text: &str) -> Result<Self, E>;

    /// Reads the value from an object.
    fn from_map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error>;
}

/// Reads the value from a string or an object.
pub fn deserialize<'de, D: Deserializer<'de>, T: StringOrMap>(deserializer: D) -> Result<T, D::Error> {
    deserializer.deserialize_any(StringOrMapVisitor(PhantomData))
}

struct StringOrMapVisitor<T>(PhantomData<T>);

impl<'de, T: StringOrMap> Visitor<'de> for StringOrMapVisitor<T> {
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
