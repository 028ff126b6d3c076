//! The description of a run: everything except its samples, as JSON.

use serde::Deserialize;
use serde_json::Value;

use super::Recording;
use super::error::{ReadError, WriteError};

/// Key of the description in Parquet and MCAP files.
pub const KEY: &str = "revprio";

/// Serializes a recording without its samples. Real times are included only if `timed` is set, so that the same run gives
/// the same bytes.
pub fn to_json(recording: &Recording, timed: bool) -> Result<String, WriteError> {
    Ok(to_value(recording, timed)?.to_string())
}

/// Serializes as [`to_json`], with the number of periods. A table that lost its last lines has no other sign of it.
pub fn to_sidecar_json(recording: &Recording, timed: bool) -> Result<String, WriteError> {
    let mut description = to_value(recording, timed)?;
    description["periods"] = recording.samples.len().into();
    Ok(description.to_string())
}

fn to_value(recording: &Recording, timed: bool) -> Result<Value, WriteError> {
    let mut description = serde_json::to_value(recording)?;
    if let (false, Some(description)) = (timed, description.as_object_mut()) {
        description.remove("wall_time_s");
    }
    Ok(description)
}

/// Parses a recording without samples.
pub fn from_json(text: &str) -> Result<Recording, ReadError> {
    serde_json::from_str(text).map_err(ReadError::Description)
}

/// Refuses a recording with another number of periods than its description states. Older descriptions state none.
pub fn check_periods(text: &str, recording: &Recording) -> Result<(), ReadError> {
    #[derive(Deserialize)]
    struct Stated {
        periods: Option<usize>,
    }
    let Stated { periods } = serde_json::from_str(text).map_err(ReadError::Description)?;
    let found = recording.samples.len();
    match periods {
        Some(stated) if stated != found => Err(ReadError::Periods { stated, found }),
        _ => Ok(()),
    }
}
