//! Recordings as Parquet.

use std::io::Write;
use std::ops::Range;

use parquet::file::reader::ChunkReader;

use super::Recording;
use super::cell::Value;
use super::columns::{Column, Extent};
use super::error::{ReadError, WriteError};
use super::format::Writer;
use super::head;
use super::parquet_file::{ParquetReader, ParquetWriter};

/// A table that is being written.
pub struct Table<W: Write + Send> {
    columns: Vec<Column>,
    out: ParquetWriter<W>,
}

impl<W: Write + Send> Table<W> {
    /// Begins the file.
    pub fn begin(recording: &Recording, timed: bool, out: W) -> Result<Self, WriteError> {
        let columns = Extent::of(recording, timed).columns();
        let names = columns.iter().map(|column| (column.name.as_str(), column.quantity.kind));
        let out = ParquetWriter::begin(names, &[(head::KEY, head::to_json(recording, timed)?)], out)?;
        Ok(Self { columns, out })
    }
}

impl<W: Write + Send> Writer for Table<W> {
    fn write(&mut self, recording: &Recording, rows: Range<usize>) -> Result<(), WriteError> {
        Ok(self.out.write(rows, |row, column| self.columns[column].value(recording, row))?)
    }

    fn finish(self: Box<Self>) -> Result<(), WriteError> {
        Ok(self.out.finish()?)
    }
}

/// Reads a recording.
pub fn read(file: impl ChunkReader + 'static) -> Result<Recording, ReadError> {
    let file = ParquetReader::open(file)?;
    let mut recording = head::from_json(file.text(head::KEY).ok_or(ReadError::NoHead)?)?;
    let names = file.names();
    let joints = std::mem::take(&mut recording.joint_names);
    let extent = Extent::of_names(&joints, &names.iter().copied());
    let columns = extent.columns();
    let place = |column: &Column| {
        let place = names.iter().position(|name| *name == column.name);
        place.ok_or_else(|| ReadError::Column { column: column.name.clone() })
    };
    let places: Vec<usize> = columns.iter().map(place).collect::<Result<_, _>>()?;
    file.read(|mut group| {
        for row in 0..group.first().map_or(0, Vec::len) {
            let (mut sample, mut timing) = extent.blank();
            for (column, &place) in columns.iter().zip(&places) {
                let value =
                    group[place].get_mut(row).map_or(Value::Missing, |value| std::mem::replace(value, Value::Missing));
                column.put(recording.samples.len(), (&mut sample, &mut timing), Some(value))?;
            }
            recording.push(sample, timing, extent.timed);
        }
        Ok::<_, ReadError>(())
    })?;
    recording.joint_names = joints;
    Ok(recording)
}
