//! File formats of recordings.

use std::fmt;
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::Path;

use super::error::{ReadError, WriteError};
use super::writer::Writer;
use super::{Recording, csv_table, description, json_lines, mcap_log, parquet_table};

/// A file format of recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// CSV, with units in the column names; the description of the run is in another file.
    Csv,
    /// JSON lines, one object per period; the description of the run is in another file.
    JsonLines,
    /// Parquet, with the columns of the CSV file and the description of the run.
    Parquet,
    /// MCAP, with messages for Foxglove, Rerun and PlotJuggler and the description of the run.
    Mcap,
}

impl fmt::Display for Format {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.pad(self.ending())
    }
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Csv, Self::JsonLines, Self::Parquet, Self::Mcap];

    /// Returns the file name extension.
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::JsonLines => "jsonl",
            Self::Parquet => "parquet",
            Self::Mcap => "mcap",
        }
    }

    /// Returns the format of a file, by its extension.
    pub fn of(path: &Path) -> Result<Self, ReadError> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let known = || Self::ALL.map(|format| format!(".{}", format.ending())).join(", ");
        Self::ALL.into_iter().find(|f| f.ending() == ending).ok_or_else(|| ReadError::Format { known: known() })
    }

    /// Returns the number of periods to write at once. For Parquet it is the size of a row group.
    pub const fn piece(self) -> usize {
        match self {
            Self::Csv | Self::JsonLines | Self::Mcap => 500,
            Self::Parquet => 5000,
        }
    }

    /// Returns whether the description of the run is in another file.
    const fn has_sidecar(self) -> bool {
        matches!(self, Self::Csv | Self::JsonLines)
    }

    /// Begins a file. `timed` adds real times, which differ from run to run.
    pub fn writer<W: Write + Send + 'static>(
        self,
        recording: &Recording,
        timed: bool,
        out: W,
    ) -> Result<Box<dyn Writer>, WriteError> {
        Ok(match self {
            Self::Csv => Box::new(csv_table::CsvWriter::begin(recording, timed, out)?),
            Self::JsonLines => Box::new(json_lines::JsonLinesWriter::new(timed, out)),
            Self::Parquet => Box::new(parquet_table::ParquetTableWriter::begin(recording, timed, out)?),
            Self::Mcap => Box::new(mcap_log::McapWriter::begin(recording, timed, out)?),
        })
    }

    /// Writes a whole recording.
    pub fn write_all<W: Write + Send + 'static>(
        self,
        recording: &Recording,
        timed: bool,
        out: W,
    ) -> Result<(), WriteError> {
        let mut writer = self.writer(recording, timed, out)?;
        let rows = recording.samples.len();
        for start in (0..rows).step_by(self.piece()) {
            writer.write(recording, start..rows.min(start + self.piece()))?;
        }
        writer.finish()
    }

    /// Writes a recording to a file, and the description of the run to another file if the format needs it.
    pub fn write_file(self, recording: &Recording, timed: bool, path: &Path) -> Result<(), WriteError> {
        if self.has_sidecar() {
            let text = description::to_sidecar_json(recording, timed)?;
            replace(&sidecar(path), |mut file| Ok(file.write_all(text.as_bytes())?))?;
        }
        replace(path, |file| self.write_all(recording, timed, BufWriter::new(file)))
    }
}

/// Writes a file under another name and renames it when it is complete. An error leaves the file of before, or none.
fn replace(path: &Path, write: impl FnOnce(File) -> Result<(), WriteError>) -> Result<(), WriteError> {
    // Devices and pipes keep their name.
    if path.metadata().is_ok_and(|found| !found.is_file()) {
        return write(File::create(path)?);
    }
    let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let mut unfinished = place.clone().into_os_string();
    unfinished.push(format!(".{}.tmp", std::process::id()));
    // A directory may permit changes of its files alone.
    let Ok(file) = File::create_new(&unfinished) else { return write(File::create(path)?) };
    let written = write(file).and_then(|()| {
        if let Ok(before) = place.metadata() {
            std::fs::set_permissions(&unfinished, before.permissions())?;
        }
        // A file that is mounted alone cannot be replaced.
        Ok(std::fs::rename(&unfinished, &place).or_else(|_| std::fs::copy(&unfinished, &place).map(drop))?)
    });
    if written.is_err() || place.exists() {
        let _ = std::fs::remove_file(&unfinished);
    }
    written
}

/// Returns the path of the description of the run of a table.
fn sidecar(path: &Path) -> std::path::PathBuf {
    path.with_extension("recording.json")
}

/// Reads a recording from a file of any format.
pub fn read(path: &Path) -> Result<Recording, ReadError> {
    let format = Format::of(path)?;
    if !format.has_sidecar() {
        return match format {
            Format::Parquet => parquet_table::read(File::open(path)?),
            _ => mcap_log::read(&std::fs::read(path)?),
        };
    }
    let file = BufReader::new(File::open(path)?);
    let sidecar = sidecar(path);
    let text = std::fs::read_to_string(&sidecar).map_err(|source| ReadError::Sidecar { path: sidecar, source })?;
    let description = description::from_json(&text)?;
    let recording = match format {
        Format::Csv => csv_table::read(description, file),
        _ => json_lines::read(description, file),
    }?;
    description::check_periods(&text, &recording)?;
    Ok(recording)
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;
    use crate::simulator::recording::Sample;

    struct FullDisk;

    impl Write for FullDisk {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn the_error_of_a_full_disk_says_so() {
        let recording = Recording { samples: vec![Sample::at_rest(); 5], ..Recording::empty() };
        for format in Format::ALL {
            let error = format.write_all(&recording, false, FullDisk).unwrap_err().to_string();
            assert!(error.contains(&io::Error::from(io::ErrorKind::StorageFull).to_string()), "{format}: {error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_cannot_be_completed_leaves_the_one_of_before() {
        let directory = std::env::temp_dir().join(format!("revprio-replaced-{}", std::process::id()));
        std::fs::create_dir_all(&directory).unwrap();
        let (path, link) = (directory.join("run.csv"), directory.join("link.csv"));
        std::fs::write(&path, "before").unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        let half = |mut file: File| {
            file.write_all(b"half")?;
            Err(WriteError::from(io::Error::from(io::ErrorKind::StorageFull)))
        };
        replace(&path, half).unwrap_err();
        replace(&directory.join("new.csv"), half).unwrap_err();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "before");
        assert_eq!(std::fs::read_dir(&directory).unwrap().count(), 2);
        replace(&link, |mut file| Ok(file.write_all(b"after")?)).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "after");
        assert!(link.is_symlink());
        replace(Path::new("/dev/null"), |mut file| Ok(file.write_all(b"gone")?)).unwrap();
        std::fs::remove_dir_all(&directory).unwrap();
    }

    #[test]
    fn a_table_with_other_lines_than_its_description_states_is_refused() {
        let directory = std::env::temp_dir().join(format!("revprio-periods-{}", std::process::id()));
        std::fs::create_dir_all(&directory).unwrap();
        let recording = Recording { samples: vec![Sample::at_rest(); 5], ..Recording::empty() };
        for format in [Format::Csv, Format::JsonLines] {
            let path = directory.join(format!("run.{format}"));
            format.write_file(&recording, false, &path).unwrap();
            assert_eq!(read(&path).unwrap().samples.len(), 5);
            let text = std::fs::read_to_string(&path).unwrap();
            let lines: Vec<&str> = text.lines().collect();
            let (shorter, longer) = (&lines[..lines.len() - 2], [&lines[..], &lines[lines.len() - 1..]].concat());
            for (lines, count) in [(shorter, 3), (&longer, 6)] {
                std::fs::write(&path, lines.join("\n")).unwrap();
                let error = read(&path).unwrap_err();
                assert!(matches!(error, ReadError::Periods { stated: 5, found } if found == count), "{error}");
            }
            // Older descriptions do not state the number.
            std::fs::write(sidecar(&path), description::to_json(&recording, false).unwrap()).unwrap();
            assert_eq!(read(&path).unwrap().samples.len(), 6);
        }
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
