//! What can go wrong with files of recordings.

use std::io;
use std::path::PathBuf;

/// Why a recording cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The table.
    #[error("{0}")]
    Csv(#[from] csv::Error),
    /// A line or the description of the run.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// The Parquet file.
    #[error("{0}")]
    Parquet(#[from] parquet::errors::ParquetError),
    /// The MCAP file.
    #[error("{0}")]
    Mcap(#[from] mcap::McapError),
    /// A message of the MCAP file.
    #[error("a message is too long")]
    Message,
}

impl From<WriteError> for io::Error {
    fn from(error: WriteError) -> Self {
        match error {
            WriteError::Io(error) => error,
            other => Self::other(other),
        }
    }
}

/// Why a file is no recording.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The ending of its name is unknown.
    #[error("the name of a recording ends in {known}")]
    Format {
        /// The endings.
        known: String,
    },
    /// A table without the description of its run.
    #[error(
        "the run is described in {}, which cannot be read: {source}; it is written beside the table; Parquet and MCAP \
         carry it inside", path.display()
    )]
    Sidecar {
        /// The other file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A Parquet or MCAP file of somebody else.
    #[error("the file does not say which run it is of; was it written by revprio?")]
    NoHead,
    /// The description of the run.
    #[error("the description of the run: {0}")]
    Head(serde_json::Error),
    /// A line.
    #[error("line {line}: {source}")]
    Line {
        /// Its number, from 1.
        line: usize,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// Not a table.
    #[error("{0}")]
    Csv(#[from] csv::Error),
    /// Not a Parquet file.
    #[error("{0}")]
    Parquet(#[from] parquet::errors::ParquetError),
    /// Not an MCAP file.
    #[error("{0}")]
    Mcap(#[from] mcap::McapError),
    /// A column is not there.
    #[error("there is no column `{column}`")]
    Column {
        /// Its name.
        column: String,
    },
    /// A value is of another kind.
    #[error("row {row}: column `{column}` holds a value that cannot stand there")]
    Value {
        /// Its row, from 1.
        row: usize,
        /// Its name.
        column: String,
    },
}
