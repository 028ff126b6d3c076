//! Bodies in MessagePack, restricted to the values of JSON.
//!
//! MessagePack has values that JSON does not have: numbers that are not finite, binary data, and keys that are not
//! strings, which serde would use as the index of a field. The service refuses them before it reads a field.

use std::fmt;
use std::io::Cursor;

use revprio_api::wire::Object;
use revprio_api::wire::read_error::in_plain_words;
use revprio_local::json::{self, pointer};
use rmp_serde::decode::{Deserializer, Error};
use serde::de::{DeserializeOwned, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

use crate::service::error::ApiError;

/// Maximum depth of nesting, as in JSON.
const MAX_DEPTH: usize = 128;

/// Reads an object.
pub fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, ApiError> {
    check(bytes)?;
    match rmp_serde::from_slice(bytes) {
        Ok(Object(value)) => Ok(value),
        // Reads the same body as JSON, which finds the place of the error. A correct body does not pay for it.
        Err(cause) => match json::explain::<T>(&as_json(bytes)?) {
            Err(error) => Err(error.map_detail(without_position)),
            // A field that is there twice is lost on the way to JSON.
            Ok(_) => Err(ApiError::invalid("", in_plain_words(&cause.to_string()))),
        },
    }
}

/// Writes a value. Structs are maps with the names of their fields.
pub fn write<T: Serialize + ?Sized>(value: &T) -> Result<Vec<u8>, rmp_serde::encode::Error> {
    rmp_serde::to_vec_named(value)
}

/// Returns the body in JSON.
fn as_json(bytes: &[u8]) -> Result<Vec<u8>, ApiError> {
    let value: serde_json::Value =
        rmp_serde::from_slice(bytes).map_err(|error| ApiError::malformed(error.to_string()))?;
    Ok(value.to_string().into_bytes())
}

/// Returns the text without the line and column of the JSON, which the client never sent.
fn without_position(detail: &str) -> &str {
    detail.rsplit_once(" at line ").map_or(detail, |(text, _)| text)
}

/// Refuses bytes that are not exactly one value that JSON can express.
fn check(bytes: &[u8]) -> Result<(), ApiError> {
    let mut deserializer = Deserializer::new(Cursor::new(bytes));
    deserializer.set_max_depth(MAX_DEPTH);
    serde_path_to_error::deserialize::<_, JsonValue>(&mut deserializer).map_err(|error| {
        let (place, cause) = (pointer(error.path()), error.into_inner());
        match cause {
            Error::Syntax(detail) => ApiError::malformed(detail).at(place),
            cause => ApiError::malformed(format!("the body is not MessagePack: {cause}")),
        }
    })?;
    let rest = bytes.len() as u64 - deserializer.position();
    if rest == 0 {
        Ok(())
    } else {
        Err(ApiError::malformed(format!("{rest} bytes follow the value; send one value only")))
    }
}

/// Accepts and discards any value that JSON can express.
struct JsonValue;

impl<'de> Deserialize<'de> for JsonValue {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Self)
    }
}

impl<'de> Visitor<'de> for JsonValue {
    type Value = Self;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a value that JSON can express")
    }

    fn visit_bool<E>(self, _: bool) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_i64<E>(self, _: i64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_u64<E>(self, _: u64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Self, E> {
        if value.is_finite() { Ok(self) } else { Err(E::custom(format!("{value} is not a finite number"))) }
    }

    fn visit_str<E>(self, _: &str) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_unit<E>(self) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self, A::Error> {
        while list.next_element::<Self>()?.is_some() {}
        Ok(self)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self, A::Error> {
        while map.next_entry::<Key, Self>()?.is_some() {}
        Ok(self)
    }
}

/// Accepts and discards a string as the key of an entry.
struct Key;

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Self)
    }
}

impl Visitor<'_> for Key {
    type Value = Self;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a string as the name of a field")
    }

    fn visit_str<E>(self, _: &str) -> Result<Self, E> {
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use revprio_api::wire::State;

    /// Returns the map {"a": …} around some bytes.
    fn inside(bytes: &[u8]) -> Vec<u8> {
        [&[0x81, 0xa1, b'a'], bytes].concat()
    }

    fn refusal(bytes: &[u8]) -> revprio_api::wire::Problem {
        read::<State>(bytes).unwrap_err().into_wire()
    }

    #[test]
    fn values_that_json_lacks_are_refused_with_a_pointer() {
        let nan = [[0xcb].as_slice(), &f64::NAN.to_be_bytes()].concat();
        let infinity = [[0xca].as_slice(), &f32::INFINITY.to_be_bytes()].concat();
        let (number_as_key, binary, extension) = ([0x81, 0x01, 0x01], [0xc4, 1, 0], [0xd4, 1, 0]);
        for bytes in [nan.as_slice(), &infinity, &number_as_key, &binary, &extension] {
            let refusal = refusal(&inside(bytes));
            assert_eq!(refusal.status, 400, "{bytes:?}");
            assert!(refusal.pointer.unwrap().starts_with("/a"), "{bytes:?}");
        }
    }

    #[test]
    fn bytes_that_are_not_one_value_are_refused() {
        let deep = [vec![0x91; 100_000], vec![0xc0]].concat();
        for bytes in [&[][..], &[0xc1], &[0x81], &[0x80, 0x80], &[0xdd, 255, 255, 255, 255], &[0xa1, 0xff], &deep] {
            assert_eq!(refusal(bytes).status, 400, "{:?}", &bytes[..bytes.len().min(8)]);
        }
    }
}
