//! Tables as Parquet files with flat columns and metadata. The same content gives the same bytes.

use std::io::Write;
use std::ops::Range;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::{ChunkReader, FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};

use super::cell::Value;
use super::quantity::Kind;

/// Writes a Parquet file.
pub struct ParquetWriter<W: Write + Send> {
    kinds: Vec<Kind>,
    out: SerializedFileWriter<W>,
}

impl<W: Write + Send> ParquetWriter<W> {
    /// Begins a file with these columns and these texts as metadata.
    pub fn begin<'a>(
        columns: impl Iterator<Item = (&'a str, Kind)> + Clone,
        texts: &[(&str, String)],
        out: W,
    ) -> Result<Self> {
        let fields = columns.clone().map(|(name, kind)| field(name, kind).map(Arc::new)).collect::<Result<_>>()?;
        let schema = Type::group_type_builder("table").with_fields(fields).build()?;
        let texts = texts.iter().map(|(key, text)| KeyValue::new((*key).to_owned(), text.clone())).collect();
        let properties = WriterProperties::builder()
            .set_created_by(concat!("revprio ", env!("CARGO_PKG_VERSION")).to_owned())
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_compression(Compression::LZ4_RAW)
            .set_key_value_metadata(Some(texts));
        // The first bytes of neighbouring numbers are alike: one after the other they compress to half the size.
        let is_number = |kind| matches!(kind, Kind::Number | Kind::OptionalNumber);
        let numbers = columns.clone().filter(|(_, kind)| is_number(*kind));
        let properties = numbers.fold(properties, |properties, (name, _)| {
            let path = ColumnPath::from(name);
            let split = properties.set_column_encoding(path.clone(), Encoding::BYTE_STREAM_SPLIT);
            split.set_column_dictionary_enabled(path, false)
        });
        let out = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties.build()))?;
        Ok(Self { kinds: columns.map(|(_, kind)| kind).collect(), out })
    }

    /// Writes rows as one row group; `value(row, column)` returns a cell.
    pub fn write(&mut self, rows: Range<usize>, value: impl Fn(usize, usize) -> Value) -> Result<()> {
        let mut group = self.out.next_row_group()?;
        for (column, &kind) in self.kinds.iter().enumerate() {
            if let Some(mut out) = group.next_column()? {
                write_column(&mut out, kind, rows.clone().map(|row| value(row, column)))?;
                out.close()?;
            }
        }
        group.close().map(drop)
    }

    /// Writes the end of the file.
    pub fn finish(self) -> Result<()> {
        self.out.close().map(drop)
    }
}

fn field(name: &str, kind: Kind) -> Result<Type> {
    let physical = match kind {
        Kind::Number | Kind::OptionalNumber => Physical::DOUBLE,
        Kind::Count => Physical::INT64,
        Kind::Flag => Physical::BOOLEAN,
        Kind::Word => Physical::BYTE_ARRAY,
    };
    let repetition = if kind == Kind::OptionalNumber { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    let logical = (kind == Kind::Word).then_some(LogicalType::String);
    Type::primitive_type_builder(name, physical).with_repetition(repetition).with_logical_type(logical).build()
}

fn write_column(out: &mut SerializedColumnWriter, kind: Kind, values: impl Iterator<Item = Value>) -> Result<()> {
    match kind {
        Kind::Number => write_all::<DoubleType>(out, values, |value| match value {
            Value::Number(number) => Some(number),
            _ => None,
        }),
        Kind::Count => write_all::<Int64Type>(out, values, |value| match value {
            Value::Count(count) => i64::try_from(count).ok(),
            _ => None,
        }),
        Kind::Flag => write_all::<BoolType>(out, values, |value| match value {
            Value::Flag(flag) => Some(flag),
            _ => None,
        }),
        Kind::Word => write_all::<ByteArrayType>(out, values, |value| match value {
            Value::Word(word) => Some(ByteArray::from(word.into_bytes())),
            _ => None,
        }),
        Kind::OptionalNumber => {
            let (mut numbers, mut present) = (Vec::new(), Vec::new());
            for value in values {
                let number = if let Value::Number(number) = value { Some(number) } else { None };
                present.push(i16::from(number.is_some()));
                numbers.extend(number);
            }
            out.typed::<DoubleType>().write_batch(&numbers, Some(&present), None).map(drop)
        }
    }
}

fn write_all<T: DataType>(
    out: &mut SerializedColumnWriter,
    values: impl Iterator<Item = Value>,
    of: impl Fn(Value) -> Option<T::T>,
) -> Result<()> {
    let values: Option<Vec<T::T>> = values.map(of).collect();
    let values = values.ok_or_else(|| ParquetError::General("a value is missing or has the wrong kind".to_owned()))?;
    out.typed::<T>().write_batch(&values, None, None).map(drop)
}

/// Reads a Parquet file.
pub struct ParquetReader<R: ChunkReader + 'static> {
    file: SerializedFileReader<R>,
}

impl<R: ChunkReader + 'static> ParquetReader<R> {
    /// Opens a file.
    pub fn open(file: R) -> Result<Self> {
        SerializedFileReader::new(file).map(|file| Self { file })
    }

    /// Returns a text of the metadata by its key.
    pub fn text(&self, key: &str) -> Option<&str> {
        let texts = self.file.metadata().file_metadata().key_value_metadata()?;
        texts.iter().find(|text| text.key == key)?.value.as_deref()
    }

    /// Returns the names of the columns.
    pub fn names(&self) -> Vec<&str> {
        let columns = self.file.metadata().file_metadata().schema_descr().columns();
        columns.iter().map(|column| column.name()).collect()
    }

    /// Calls `take` with the columns of each row group.
    pub fn read<E: From<ParquetError>>(
        &self,
        mut take: impl FnMut(Vec<Vec<Value>>) -> std::result::Result<(), E>,
    ) -> std::result::Result<(), E> {
        for group in 0..self.file.num_row_groups() {
            let group = self.file.get_row_group(group)?;
            let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
            let columns = (0..group.num_columns()).map(|i| read_column(group.get_column_reader(i)?, rows));
            take(columns.collect::<Result<_>>()?)?;
        }
        Ok(())
    }
}

fn read_column(column: ColumnReader, rows: usize) -> Result<Vec<Value>> {
    match column {
        ColumnReader::DoubleColumnReader(column) => read_all(column, rows, |number| Some(Value::Number(*number))),
        ColumnReader::BoolColumnReader(column) => read_all(column, rows, |flag| Some(Value::Flag(*flag))),
        ColumnReader::Int64ColumnReader(column) => {
            read_all(column, rows, |count| u64::try_from(*count).ok().map(Value::Count))
        }
        ColumnReader::ByteArrayColumnReader(column) => {
            read_all(column, rows, |word| word.as_utf8().ok().map(|word| Value::Word(word.to_owned())))
        }
        _ => Err(ParquetError::General("a column has a type that recordings do not use".to_owned())),
    }
}

fn read_all<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    rows: usize,
    of: impl Fn(&T::T) -> Option<Value>,
) -> Result<Vec<Value>> {
    let (mut values, mut present) = (Vec::new(), Vec::new());
    let mut read = 0;
    while read < rows {
        let (more, _, _) = column.read_records(rows - read, Some(&mut present), None, &mut values)?;
        if more == 0 {
            break;
        }
        read += more;
    }
    let wrong = || ParquetError::General("a value is not valid in a recording".to_owned());
    let mut values = values.iter().map(|value| of(value).ok_or_else(wrong));
    if present.is_empty() {
        return values.collect();
    }
    present
        .iter()
        .map(|present| if *present > 0 { values.next().ok_or_else(wrong)? } else { Ok(Value::Missing) })
        .collect()
}
