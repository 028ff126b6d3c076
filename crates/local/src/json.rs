//! Bodies in JSON.

use revprio_api::wire::Object;
use revprio_api::wire::read_error::in_plain_words;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_json::error::Category;
use serde_path_to_error::Segment;

use crate::error::{ApiError, escape_pointer};
use crate::inner_place::inner_place;

/// Initial capacity, bytes: enough for the answer to a step. Growing from zero took a third of the instructions.
const INITIAL_CAPACITY: usize = 2048;

/// Writes a value.
pub fn write<T: Serialize + ?Sized>(value: &T) -> serde_json::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(INITIAL_CAPACITY);
    serde_json::to_writer(&mut bytes, value)?;
    Ok(bytes)
}

/// Reads an object.
pub fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, ApiError> {
    read_borrowed(bytes).map_or_else(|| explain(bytes), Ok)
}

/// Reads an object that may borrow from the bytes. Returns `None` on any error.
pub fn read_borrowed<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Option<T> {
    serde_json::from_slice(bytes).ok().map(|Object(value)| value)
}

/// Reads a wrong body again and tracks the place of the error. A correct body does not pay for the tracking.
pub fn explain<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, ApiError> {
    let mut deserializer = serde_json::Deserializer::from_slice(bytes);
    let Object(value) = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let (place, cause) = (pointer(error.path()), error.into_inner());
        let detail = in_plain_words(&cause.to_string());
        match cause.classify() {
            Category::Data => {
                let detail = match inner_place::<T>(bytes, &place) {
                    Some(inner) => format!("in `{inner}`: {detail}"),
                    None => detail,
                };
                ApiError::invalid(place, detail)
            }
            _ if is_well_formed(bytes) => {
                let detail = too_long::<T>(bytes, &place).unwrap_or(detail);
                ApiError::invalid(place, detail)
            }
            Category::Syntax | Category::Eof | Category::Io => ApiError::malformed(detail),
        }
    })?;
    deserializer.end().map_err(|error| ApiError::malformed(in_plain_words(&error.to_string())))?;
    Ok(value)
}

/// Returns whether the bytes are JSON with finite numbers. A value of a wrong type can look like a syntax error.
fn is_well_formed(bytes: &[u8]) -> bool {
    serde_json::from_slice::<Value>(bytes).is_ok()
}

/// Returns what is wrong with a list of too many entries at `place`; `None`: it is something else. To the reader of the text, they look like
/// text after the end of the value.
fn too_long<T: DeserializeOwned>(bytes: &[u8], place: &str) -> Option<String> {
    let mut body: Value = serde_json::from_slice(bytes).ok()?;
    let list = body.pointer_mut(place)?.as_array_mut()?;
    let given = list.len();
    // The mistake of an empty list says how many there must be.
    list.clear();
    let mistake = serde_json::from_value::<Object<T>>(body).err()?;
    in_plain_words(&mistake.to_string()).strip_suffix("not of 0").map(|text| format!("{text}not of {given}"))
}

/// Returns the JSON pointer (RFC 6901) of a path.
pub fn pointer(path: &serde_path_to_error::Path) -> String {
    let part = |segment: &Segment| match segment {
        Segment::Seq { index } => format!("/{index}"),
        Segment::Map { key } => format!("/{}", escape_pointer(key)),
        Segment::Enum { .. } | Segment::Unknown => String::new(),
    };
    path.iter().map(part).collect()
}

#[cfg(test)]
mod tests {
    use revprio_api::wire::RobotRegistration;

    use super::read;

    #[test]
    fn a_list_of_too_many_entries_is_told_with_both_numbers() {
        let refused = |position: &str| {
            let text = format!(r#"{{"name": "a", "urdf": "", "limits": {{"elbow": {{"position": {position}}}}}}}"#);
            read::<RobotRegistration>(text.as_bytes()).unwrap_err().to_string()
        };
        let (long, short) = (refused("[-1, 1, 2]"), refused("[-1]"));
        assert!(long.starts_with("/limits/elbow/position: give a list of 2 entries, not of 3"), "{long}");
        assert!(short.starts_with("/limits/elbow/position: give a list of 2 entries, not of 1"), "{short}");
    }
}
