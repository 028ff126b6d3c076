//! Bodies in MessagePack, as far as JSON could say the same.
//!
//! MessagePack has values that JSON has not: numbers that are not finite, keys that are no texts (from which serde would
//! take the place of a field), binary data. They are refused before a field is looked at.

use std::fmt;
use std::io::Cursor;

use revprio_api::wire::Object;
use rmp_serde::decode::{Deserializer, Error};
use serde::de::{DeserializeOwned, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::pointer;
use crate::service::error::ApiError;

/// Depth of nesting that is read, as in JSON.
const DEEPEST: usize = 128;

/// Reads an object.
pub fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, ApiError> {
    check(bytes)?;
    match rmp_serde::from_slice(bytes) {
        Ok(Object(value)) => Ok(value),
        // Once more, keeping track of where: what a good body need not pay for.
        Err(_) => match serde_path_to_error::deserialize(&mut Deserializer::from_read_ref(bytes)) {
            Ok(Object(value)) => Ok(value),
            Err(error) => Err(ApiError::invalid(pointer(error.path()), error.into_inner())),
        },
    }
}

/// Writes a value, structs as maps with the names of their fields.
pub fn write<T: Serialize + ?Sized>(value: &T) -> Result<Vec<u8>, rmp_serde::encode::Error> {
    rmp_serde::to_vec_named(value)
}

/// Refuses bytes that are not one value of those that JSON has.
fn check(bytes: &[u8]) -> Result<(), ApiError> {
    let mut deserializer = Deserializer::new(Cursor::new(bytes));
    deserializer.set_max_depth(DEEPEST);
    serde_path_to_error::deserialize::<_, JsonValue>(&mut deserializer).map_err(|error| {
        let (place, cause) = (pointer(error.path()), error.into_inner());
        match cause {
            Error::Syntax(detail) => ApiError::malformed(detail).at(place),
            cause => ApiError::malformed(format!("no MessagePack: {cause}")),
        }
    })?;
    let rest = bytes.len() as u64 - deserializer.position();
    if rest == 0 { Ok(()) } else { Err(ApiError::malformed(format!("{rest} bytes follow the value"))) }
}

/// Any value that JSON has, forgotten.
struct JsonValue;

impl<'de> Deserialize<'de> for JsonValue {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Self)
    }
}

impl<'de> Visitor<'de> for JsonValue {
    type Value = Self;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a value that JSON has")
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

/// A text as the key of an entry, forgotten.
struct Key;

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Self)
    }
}

impl Visitor<'_> for Key {
    type Value = Self;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a text as the name of a field")
    }

    fn visit_str<E>(self, _: &str) -> Result<Self, E> {
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use revprio_api::wire::State;

    /// The map {"a": …} around some bytes.
    fn inside(bytes: &[u8]) -> Vec<u8> {
        [&[0x81, 0xa1, b'a'], bytes].concat()
    }

    fn refusal(bytes: &[u8]) -> revprio_api::wire::Problem {
        read::<State>(bytes).unwrap_err().into_wire()
    }

    #[test]
    fn what_json_cannot_say_is_refused_with_its_place() {
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
    fn bytes_that_are_no_single_value_are_refused() {
        let deep = [vec![0x91; 100_000], vec![0xc0]].concat();
        for bytes in [&[][..], &[0xc1], &[0x81], &[0x80, 0x80], &[0xdd, 255, 255, 255, 255], &[0xa1, 0xff], &deep] {
            assert_eq!(refusal(bytes).status, 400, "{:?}", &bytes[..bytes.len().min(8)]);
        }
    }
}
