//! Recordings as JSON, one object per line and period.

use std::io::{BufRead, Write};
use std::ops::Range;

use serde::Serialize;

use super::error::{ReadError, WriteError};
use super::writer::Writer;
use super::{Recording, Sample, Timing};

/// Writes a file of JSON lines.
pub struct JsonLinesWriter<W> {
    timed: bool,
    out: W,
}

/// A sample with its real times.
#[derive(Serialize)]
struct Timed<'a> {
    #[serde(flatten)]
    sample: &'a Sample,
    #[serde(flatten)]
    timing: Timing,
}

impl<W: Write> JsonLinesWriter<W> {
    /// Returns a writer for an empty file.
    pub fn new(timed: bool, out: W) -> Self {
        Self { timed, out }
    }
}

impl<W: Write + Send> Writer for JsonLinesWriter<W> {
    fn write(&mut self, recording: &Recording, rows: Range<usize>) -> Result<(), WriteError> {
        for row in rows {
            write_object(recording, row, self.timed, &mut self.out)?;
            self.out.write_all(b"\n")?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        Ok(self.out.flush()?)
    }
}

/// Writes one period as a JSON object.
pub fn write_object(recording: &Recording, row: usize, timed: bool, out: impl Write) -> serde_json::Result<()> {
    let sample = &recording.samples[row];
    match recording.timings.get(row) {
        Some(&timing) if timed => serde_json::to_writer(out, &Timed { sample, timing }),
        _ => serde_json::to_writer(out, sample),
    }
}

/// Parses one period and adds it to the recording.
pub fn read_object(recording: &mut Recording, text: &[u8]) -> serde_json::Result<()> {
    let sample = serde_json::from_slice(text)?;
    // The fields are missing in files without real times.
    let timing = serde_json::from_slice::<Timing>(text).ok();
    recording.push(sample, timing.unwrap_or_default(), timing.is_some());
    Ok(())
}

/// Reads the samples of a recording.
pub fn read(description: Recording, file: impl BufRead) -> Result<Recording, ReadError> {
    let mut recording = description;
    for (i, line) in file.lines().enumerate() {
        let line = line?;
        if !line.trim().is_empty() {
            let read = read_object(&mut recording, line.as_bytes());
            read.map_err(|source| ReadError::Line { line: i + 1, source })?;
        }
    }
    Ok(recording)
}
