//! What is common to all periods of a run, as text that goes with the samples.

use super::Recording;
use super::error::{ReadError, WriteError};

/// Name of this text in Parquet and MCAP files.
pub const KEY: &str = "revprio";

/// The recording without its samples, as JSON; the clock on the wall only if asked for, so that the same run leaves the
/// same bytes.
pub fn to_json(recording: &Recording, timed: bool) -> Result<String, WriteError> {
    let mut head = serde_json::to_value(recording)?;
    if let (false, Some(head)) = (timed, head.as_object_mut()) {
        head.remove("wall_time_s");
    }
    Ok(head.to_string())
}

/// A recording that waits for its samples.
pub fn from_json(text: &str) -> Result<Recording, ReadError> {
    serde_json::from_str(text).map_err(ReadError::Head)
}
