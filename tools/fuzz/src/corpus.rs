//! The kept inputs: one archive per target, and the inputs that once had a defect as files.

use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;

use crate::Target;

/// Size of a block of a tar archive, bytes. A header is one block; content is filled up with zeros.
const BLOCK: usize = 512;

/// Returns the kept inputs of a target with their names: those of `corpus/TARGET.tar.gz`, then those of `corpus/TARGET/`.
pub fn kept(target: Target) -> io::Result<Vec<(String, Vec<u8>)>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let mut archive = Vec::new();
    let compressed = std::fs::read(folder.join(format!("{}.tar.gz", target.name())))?;
    GzDecoder::new(compressed.as_slice()).read_to_end(&mut archive)?;
    let mut inputs = unpack(&archive)?;
    for path in files(&folder.join(target.name()))? {
        inputs.push((path.display().to_string(), std::fs::read(&path)?));
    }
    Ok(inputs)
}

/// Returns the files of a folder in the order of their names; none if the folder does not exist.
fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
    paths.sort();
    Ok(paths)
}

/// Returns the files of a tar archive with names of at most 100 bytes, as `tools/fuzz/run` packs them.
fn unpack(archive: &[u8]) -> io::Result<Vec<(String, Vec<u8>)>> {
    let broken = || io::Error::new(io::ErrorKind::InvalidData, "the archive is broken");
    let (mut files, mut rest) = (Vec::new(), archive);
    while let Some((header, after)) = rest.split_first_chunk::<BLOCK>() {
        // A block of zeros ends the archive.
        if header.iter().all(|byte| *byte == 0) {
            return Ok(files);
        }
        let size = usize::from_str_radix(&text(&header[124..136]), 8).map_err(|_| broken())?;
        let content = after.get(..size).ok_or_else(broken)?;
        files.push((text(&header[..100]), content.to_vec()));
        rest = after.get(size.next_multiple_of(BLOCK)..).ok_or_else(broken)?;
    }
    Err(broken())
}

/// Returns a field of a header without the zeros after it.
fn text(field: &[u8]) -> String {
    let end = field.iter().position(|byte| *byte == 0).unwrap_or(field.len());
    String::from_utf8_lossy(&field[..end]).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broken_archive_is_an_error() {
        let mut archive = vec![0; 3 * BLOCK];
        archive[0] = b'a';
        archive[124..136].copy_from_slice(b"00000000003\0");
        archive[BLOCK..BLOCK + 3].copy_from_slice(b"xyz");
        assert_eq!(unpack(&archive).unwrap(), [("a".to_owned(), b"xyz".to_vec())]);
        assert!(unpack(&archive[..2 * BLOCK]).is_err());
        archive[124..136].copy_from_slice(b"00000002000\0");
        assert!(unpack(&archive).is_err());
        assert!(unpack(&[]).is_err());
    }
}
