//! Recordings as Parquet.

use std::io::Write;
use std::ops::Range;

use parquet::file::reader::ChunkReader;

use super::Recording;
use super::cell::Value;
use super::columns::{Column, TableLayout};
use super::csv_table::cell_text;
use super::description;
use super::error::{ReadError, WriteError};
use super::parquet_file::{ParquetReader, ParquetWriter};
use super::writer::Writer;

/// Writes a recording as a Parquet file.
pub struct ParquetTableWriter<W: Write + Send> {
    columns: Vec<Column>,
    out: ParquetWriter<W>,
}

impl<W: Write + Send> ParquetTableWriter<W> {
    /// Begins the file.
    pub fn begin(recording: &Recording, timed: bool, out: W) -> Result<Self, WriteError> {
        let columns = TableLayout::from_recording(recording, timed).columns();
        let names = columns.iter().map(|column| (column.name.as_str(), column.quantity.kind));
        let out = ParquetWriter::begin(names, &[(description::KEY, description::to_json(recording, timed)?)], out)?;
        Ok(Self { columns, out })
    }
}

impl<W: Write + Send> Writer for ParquetTableWriter<W> {
    fn write(&mut self, recording: &Recording, rows: Range<usize>) -> Result<(), WriteError> {
        Ok(self.out.write(rows, |row, column| self.columns[column].value(recording, row))?)
    }

    fn finish(self: Box<Self>) -> Result<(), WriteError> {
        Ok(self.out.finish()?)
    }
}

/// Reads a recording from a Parquet file.
pub fn read(file: impl ChunkReader + 'static) -> Result<Recording, ReadError> {
    let file = ParquetReader::open(file)?;
    let mut recording = description::from_json(file.text(description::KEY).ok_or(ReadError::NoDescription)?)?;
    let names = file.names();
    let joints = std::mem::take(&mut recording.joint_names);
    let layout = TableLayout::from_column_names(&joints, &names.iter().copied());
    let columns = layout.columns();
    let index = |column: &Column| {
        let index = names.iter().position(|name| *name == column.name);
        index.ok_or_else(|| ReadError::Column { column: column.name.clone() })
    };
    let indices: Vec<usize> = columns.iter().map(index).collect::<Result<_, _>>()?;
    file.read(|group| {
        for row in 0..group.first().map_or(0, Vec::len) {
            let (mut sample, mut timing) = layout.empty_sample();
            for (column, &index) in columns.iter().zip(&indices) {
                let value = group[index].get(row).unwrap_or(&Value::Missing);
                if !column.set((&mut sample, &mut timing), value.clone()) {
                    return Err(column.refused(recording.samples.len(), &cell_text(value.clone())));
                }
            }
            recording.push(sample, timing, layout.timed);
        }
        Ok::<_, ReadError>(())
    })?;
    recording.joint_names = joints;
    Ok(recording)
}
