//! A file of completed rows, with which an interrupted sweep continues.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::plan::Identity;
use crate::simulator::recording::{Kind, Value, cell_text, cell_value};

/// Rows by the index of their cells.
pub type Rows = BTreeMap<usize, Vec<Value>>;

/// A file with one line per completed cell.
pub struct Partial {
    path: PathBuf,
    file: Mutex<File>,
}

impl Partial {
    /// Opens the file of a sweep and reads its rows. A file of another sweep is an error.
    pub fn open(path: &Path, identity: &Identity, columns: &[(String, Kind)]) -> io::Result<(Self, Rows)> {
        let head = serde_json::to_string(identity)? + "\n";
        let text = match std::fs::read_to_string(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            text => text?,
        };
        // The last line may be incomplete.
        let end_of_lines = text.rfind('\n').map_or(0, |end| end + 1);
        let rows = match text[..end_of_lines].strip_prefix(head.as_str()) {
            Some(rows) => read(rows, columns)?,
            None if end_of_lines == 0 => Rows::new(),
            None => {
                return Err(io::Error::other("the file belongs to another sweep; remove it, or choose another --out"));
            }
        };
        let mut file = OpenOptions::new().create(true).append(true).open(path)?;
        file.set_len(end_of_lines as u64)?;
        if end_of_lines == 0 {
            file.write_all(head.as_bytes())?;
        }
        Ok((Self { path: path.to_owned(), file: Mutex::new(file) }, rows))
    }

    /// Adds a row.
    pub fn add(&self, row: &[Value]) -> io::Result<()> {
        let mut line = csv::Writer::from_writer(Vec::new());
        line.write_record(row.iter().cloned().map(cell_text))?;
        let line = line.into_inner().map_err(|error| io::Error::other(error.to_string()))?;
        self.file.lock().unwrap_or_else(PoisonError::into_inner).write_all(&line)
    }

    /// Removes the file, unless another run of the same sweep has done so.
    pub fn remove(self) -> io::Result<()> {
        drop(self.file);
        match std::fs::remove_file(self.path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

fn read(text: &str, columns: &[(String, Kind)]) -> io::Result<Rows> {
    let wrong = || io::Error::other("a row is not valid; remove the file to restart the sweep");
    let mut rows = Rows::new();
    for record in csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes()).records() {
        let record = record?;
        let cells = record.iter().zip(columns).map(|(text, (_, kind))| cell_value(text, *kind));
        let row: Vec<Value> = cells.collect::<Option<_>>().ok_or_else(wrong)?;
        rows.insert(cell_index(&row).ok_or_else(wrong)?, row);
    }
    Ok(rows)
}

/// Returns the index of the cell of a row.
pub fn cell_index(row: &[Value]) -> Option<usize> {
    if let Some(Value::Count(index)) = row.first() { usize::try_from(*index).ok() } else { None }
}
