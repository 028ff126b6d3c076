//! What every file format writes.

use std::ops::Range;

use super::Recording;
use super::error::WriteError;

/// Writes a recording in parts.
pub trait Writer: Send {
    /// Writes the next periods of the recording.
    fn write(&mut self, recording: &Recording, rows: Range<usize>) -> Result<(), WriteError>;

    /// Writes the end of the file.
    fn finish(self: Box<Self>) -> Result<(), WriteError>;
}
