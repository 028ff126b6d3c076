//! Triangles of STL files, binary and ASCII.

use nalgebra::Vector3;

use super::fitted_capsule::Triangle;

/// Bytes of one triangle of a binary file: normal and three corners in single precision, and two bytes that are not used.
const TRIANGLE_SIZE: usize = 50;

/// First words of the lines of one triangle of an ASCII file.
const FACET: [&str; 7] = ["facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet"];

/// Why an STL file cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum StlError {
    /// The file has another format.
    #[error("it does not begin with `solid` as ASCII STL does, and is too short for binary STL")]
    NotStl,
    /// A binary file has another size than its header says.
    #[error(
        "its header states {stated} triangles, but its size of {size} bytes is not that of {stated}, it has room for {room}; it is cut, \
         or not an STL file"
    )]
    Size {
        /// Number of triangles in the header.
        stated: u32,
        /// Number of whole triangles after the header.
        room: usize,
        /// Size of the file, bytes.
        size: usize,
    },
    /// A line of an ASCII file is wrong.
    #[error("its facet {facet} has another line in place of `{expected}`")]
    Line {
        /// Number of the facet, from 1.
        facet: usize,
        /// The line that belongs there.
        expected: &'static str,
    },
    /// An ASCII file has no end.
    #[error("it ends before `endsolid`; it is cut")]
    Unfinished,
}

/// Reads the triangles of a file.
pub fn read(bytes: &[u8]) -> Result<Vec<Triangle>, StlError> {
    // Many programs begin binary files with `solid` too, therefore the size decides. A text cannot have the size by chance: its
    // count would be above 10⁸.
    read_binary(bytes).or_else(|error| {
        let begins_with_solid =
            bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
        // A binary file that is cut contains zeros, a text does not.
        let is_text = begins_with_solid && !bytes.contains(&0);
        if is_text { read_ascii(&String::from_utf8_lossy(bytes)) } else { Err(error) }
    })
}

fn read_binary(bytes: &[u8]) -> Result<Vec<Triangle>, StlError> {
    let header = bytes.split_at_checked(80).and_then(|(_, after)| after.split_first_chunk());
    let (count, body) = header.ok_or(StlError::NotStl)?;
    let stated = u32::from_le_bytes(*count);
    let (triangles, rest) = body.as_chunks::<TRIANGLE_SIZE>();
    let room = triangles.len();
    // Some programs end a binary file with a line break.
    let is_whole = u32::try_from(room) == Ok(stated) && rest.trim_ascii().is_empty();
    if !is_whole {
        return Err(StlError::Size { stated, room, size: bytes.len() });
    }
    let number = |bytes: &[u8]| bytes.first_chunk().map_or(f64::NAN, |bytes| f64::from(f32::from_le_bytes(*bytes)));
    let corner = |bytes: &[u8]| Vector3::from_fn(|i, _| number(&bytes[4 * i..]));
    Ok(triangles.iter().map(|bytes| [12, 24, 36].map(|at| corner(&bytes[at..]))).collect())
}

fn read_ascii(text: &str) -> Result<Vec<Triangle>, StlError> {
    let mut triangles = Vec::new();
    let mut triangle = Triangle::default();
    let (mut is_open, mut step) = (false, 0);
    for line in text.split(['\n', '\r']) {
        let mut words = line.split_ascii_whitespace();
        let Some(word) = words.next().map(str::to_ascii_lowercase) else { continue };
        let wrong = |expected| StlError::Line { facet: triangles.len() + 1, expected };
        match word.as_str() {
            "solid" if !is_open => is_open = true,
            "endsolid" if is_open && step == 0 => is_open = false,
            word if is_open && word == FACET[step] => {
                if word == "vertex" {
                    triangle[step - 2] = point(words).ok_or_else(|| wrong("vertex X Y Z"))?;
                }
                step += 1;
            }
            _ => return Err(wrong(if is_open { FACET[step] } else { "solid" })),
        }
        if step == FACET.len() {
            triangles.push(triangle);
            step = 0;
        }
    }
    if is_open { Err(StlError::Unfinished) } else { Ok(triangles) }
}

fn point<'a>(words: impl Iterator<Item = &'a str>) -> Option<Vector3<f64>> {
    let numbers = words.map(|word| word.parse().ok()).collect::<Option<Vec<f64>>>()?;
    <[f64; 3]>::try_from(numbers).ok().map(Vector3::from)
}

#[cfg(test)]
mod tests;
