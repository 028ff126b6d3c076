//! Recordings as CSV.

use std::io::{Read, Write};
use std::ops::Range;

use super::Recording;
use super::cell::Value;
use super::columns::{Column, TableLayout};
use super::error::{ReadError, WriteError};
use super::quantity::Kind;
use super::writer::Writer;

/// Writes a CSV file.
pub struct CsvWriter<W: Write> {
    columns: Vec<Column>,
    out: csv::Writer<W>,
}

impl<W: Write> CsvWriter<W> {
    /// Writes the names of the columns.
    pub fn begin(recording: &Recording, timed: bool, out: W) -> Result<Self, WriteError> {
        let columns = TableLayout::from_recording(recording, timed).columns();
        let mut out = csv::Writer::from_writer(out);
        out.write_record(columns.iter().map(|column| &column.name))?;
        Ok(Self { columns, out })
    }
}

impl<W: Write + Send> Writer for CsvWriter<W> {
    fn write(&mut self, recording: &Recording, rows: Range<usize>) -> Result<(), WriteError> {
        for row in rows {
            self.out.write_record(self.columns.iter().map(|column| cell_text(column.value(recording, row))))?;
        }
        Ok(self.out.flush()?)
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        Ok(self.out.flush()?)
    }
}

/// Formats a value. Numbers have the shortest form that is parsed to the same bits.
pub fn cell_text(value: Value) -> String {
    match value {
        Value::Missing => String::new(),
        Value::Number(number) => number.to_string(),
        Value::Count(count) => count.to_string(),
        Value::Flag(flag) => flag.to_string(),
        Value::Word(word) => word,
    }
}

/// Parses a value; `None` if the text is not of this kind.
pub fn cell_value(text: &str, kind: Kind) -> Option<Value> {
    Some(match kind {
        Kind::OptionalNumber if text.is_empty() => Value::Missing,
        Kind::Number | Kind::OptionalNumber => Value::Number(text.parse().ok()?),
        Kind::Count => Value::Count(text.parse().ok()?),
        // Python writes `True`, spreadsheets write `TRUE`.
        Kind::Flag => Value::Flag(text.to_ascii_lowercase().parse().ok()?),
        Kind::Word => Value::Word(text.to_owned()),
    })
}

/// Reads the samples of a recording.
pub fn read(description: Recording, file: impl Read) -> Result<Recording, ReadError> {
    let mut table = csv::Reader::from_reader(file);
    let names = table.headers()?.clone();
    let mut recording = description;
    let joints = std::mem::take(&mut recording.joint_names);
    let layout = TableLayout::from_column_names(&joints, &names.iter());
    let columns = layout.columns();
    let indices: Vec<usize> = columns.iter().map(|column| column_index(column, &names)).collect::<Result<_, _>>()?;
    for row in table.records() {
        let row = row?;
        let (mut sample, mut timing) = layout.empty_sample();
        for (column, &index) in columns.iter().zip(&indices) {
            let text = row.get(index).unwrap_or_default();
            let value = cell_value(text, column.quantity.kind);
            if !value.is_some_and(|value| column.set((&mut sample, &mut timing), value)) {
                return Err(column.refused(recording.samples.len(), text));
            }
        }
        recording.push(sample, timing, layout.timed);
    }
    recording.joint_names = joints;
    Ok(recording)
}

fn column_index(column: &Column, names: &csv::StringRecord) -> Result<usize, ReadError> {
    let index = names.iter().position(|name| name == column.name);
    index.ok_or_else(|| ReadError::Column { column: column.name.clone() })
}
