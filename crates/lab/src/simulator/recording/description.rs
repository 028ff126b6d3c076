//! The description of a run: everything except its samples, as JSON.

use super::Recording;
use super::error::{ReadError, WriteError};

/// Key of the description in Parquet and MCAP files.
pub const KEY: &str = "revprio";

/// Serializes a recording without its samples. Real times are included only if `timed` is set, so that the same run gives
/// the same bytes.
pub fn to_json(recording: &Recording, timed: bool) -> Result<String, WriteError> {
    let mut description = serde_json::to_value(recording)?;
    if let (false, Some(description)) = (timed, description.as_object_mut()) {
        description.remove("wall_time_s");
    }
    Ok(description.to_string())
}

/// Parses a recording without samples.
pub fn from_json(text: &str) -> Result<Recording, ReadError> {
    serde_json::from_str(text).map_err(ReadError::Description)
}
