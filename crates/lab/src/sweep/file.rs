//! The Parquet file of a sweep or of a part of it.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use parquet::errors::{ParquetError, Result};

use super::partial::{Rows, cell_index};
use super::plan::Identity;
use crate::simulator::recording::parquet_file::{ParquetReader, ParquetWriter};
use crate::simulator::recording::{Kind, Value};

/// Key of the description of the sweep in the file.
const KEY: &str = "revprio-sweep";

/// Rows per row group.
const GROUP_LEN: usize = 10_000;

/// Writes the rows in the order of their cells.
pub fn write(path: &Path, identity: &Identity, columns: &[(String, Kind)], rows: &Rows) -> Result<()> {
    let rows: Vec<&Vec<Value>> = rows.values().collect();
    let identity = serde_json::to_string(identity).map_err(|error| ParquetError::External(error.into()))?;
    let names = columns.iter().map(|(name, kind)| (name.as_str(), *kind));
    // The file is renamed when it is complete, so that a file of this name is always complete.
    let unfinished = path.with_extension("parquet.tmp");
    let mut file = ParquetWriter::begin(names, &[(KEY, identity)], BufWriter::new(File::create(&unfinished)?))?;
    for start in (0..rows.len()).step_by(GROUP_LEN) {
        file.write(start..rows.len().min(start + GROUP_LEN), |row, column| rows[row][column].clone())?;
    }
    file.finish()?;
    Ok(std::fs::rename(unfinished, path)?)
}

/// The content of a sweep file.
pub struct Written {
    /// The identity of the sweep.
    pub identity: Identity,
    /// The rows of this file.
    pub rows: Rows,
}

/// Reads a sweep file.
pub fn read(path: &Path) -> Result<Written> {
    let file = ParquetReader::open(File::open(path)?)?;
    let identity = identity(&file)?;
    let mut rows = Rows::new();
    file.read(|group| {
        for row in 0..group.first().map_or(0, Vec::len) {
            let row: Vec<Value> = group.iter().map(|column| column[row].clone()).collect();
            rows.insert(cell_index(&row).ok_or_else(foreign)?, row);
        }
        Ok::<_, ParquetError>(())
    })?;
    Ok(Written { identity, rows })
}

/// Returns whether a file is the table of this sweep.
pub fn is_table_of(path: &Path, sweep: &Identity) -> bool {
    let open = || identity(&ParquetReader::open(File::open(path)?)?);
    open().is_ok_and(|found| found == *sweep)
}

fn identity(file: &ParquetReader<File>) -> Result<Identity> {
    file.text(KEY).and_then(|text| serde_json::from_str(text).ok()).ok_or_else(foreign)
}

fn foreign() -> ParquetError {
    ParquetError::General("the file is not a table of a sweep".to_owned())
}

/// Merges the parts of a sweep.
pub fn merge(parts: &[PathBuf]) -> std::result::Result<Written, String> {
    let read = |path: &PathBuf| read(path).map_err(|error| format!("cannot read {}: {error}", path.display()));
    let (first, others) = parts.split_first().ok_or("give the files to merge")?;
    let mut whole = read(first)?;
    for path in others {
        let part = read(path)?;
        if part.identity != whole.identity {
            return Err(format!("{} and {} belong to different sweeps", first.display(), path.display()));
        }
        for (index, row) in part.rows {
            if whole.rows.insert(index, row).is_some() {
                return Err(format!("cell {index} of {} is also in an earlier file", path.display()));
            }
        }
    }
    let cells = whole.identity.cells;
    match (0..cells).find(|cell| !whole.rows.contains_key(cell)) {
        Some(missing) => {
            Err(format!("{} of {cells} cells are missing, cell {missing} first", cells - whole.rows.len()))
        }
        None => Ok(whole),
    }
}
