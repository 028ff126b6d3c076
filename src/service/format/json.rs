//! Bodies in JSON.

use revprio_api::wire::Object;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::error::Category;

use super::pointer;
use crate::service::error::ApiError;

/// Quota for an answer to a step: growing towards it in small steps took a third of the instructions of writing it.
const USUAL_LENGTH: usize = 2048;

/// Writes a value.
pub fn write<T: Serialize + ?Sized>(value: &T) -> serde_json::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(USUAL_LENGTH);
    serde_json::to_writer(&mut bytes, value)?;
    Ok(bytes)
}

/// Reads an object.
pub fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, ApiError> {
    glance(bytes).map_or_else(|| explain(bytes), Ok)
}

/// Reads an object, without a word if that fails.
pub fn glance<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Option<T> {
    serde_json::from_slice(bytes).ok().map(|Object(value)| value)
}

/// Reads once more, keeping track of where: what a good body need not pay for.
fn explain<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, ApiError> {
    let mut deserializer = serde_json::Deserializer::from_slice(bytes);
    let Object(value) = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let (place, cause) = (pointer(error.path()), error.into_inner());
        match cause.classify() {
            Category::Data => ApiError::invalid(place, cause),
            _ if is_well_formed(bytes) => ApiError::invalid(place, cause),
            Category::Syntax | Category::Eof | Category::Io => ApiError::malformed(cause.to_string()),
        }
    })?;
    deserializer.end().map_err(|error| ApiError::malformed(error.to_string()))?;
    Ok(value)
}

/// Whether it is JSON of finite numbers: a value of another type than the expected one can look like wrong syntax.
fn is_well_formed(bytes: &[u8]) -> bool {
    serde_json::from_slice::<serde_json::Value>(bytes).is_ok()
}
