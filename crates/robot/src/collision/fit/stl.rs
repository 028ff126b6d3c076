//! Triangles of STL files, binary and ASCII.

use nalgebra::Vector3;

use super::fitted_capsule::Triangle;

/// Bytes of one triangle of a binary file: normal and three corners in single precision, and two bytes that are not used.
const TRIANGLE_SIZE: usize = 50;

/// Words around the three corners of a facet of an ASCII file, after `facet normal X Y Z`.
const BEFORE: [&str; 2] = ["outer", "loop"];
const AFTER: [&str; 2] = ["endloop", "endfacet"];

/// Three bytes that some programs put before a text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Why an STL file cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum StlError {
    /// The file has another format.
    #[error("it does not begin with `solid` as ASCII STL does, and is too short for binary STL; give an STL file")]
    NotStl,
    /// A binary file has another size than its header says.
    #[error(
        "its header states {stated} triangles, but its size of {size} bytes is that of {found}; it is cut, or not an STL file: export or \
         download it again"
    )]
    Size {
        /// Number of triangles in the header.
        stated: u32,
        /// Number of whole triangles after the header.
        found: usize,
        /// Size of the file, bytes.
        size: usize,
    },
    /// A word of an ASCII file is wrong.
    #[error("its facet {facet} has another word in place of `{expected}`; export it again, best as binary STL")]
    Word {
        /// Number of the facet, from 1.
        facet: usize,
        /// What belongs there.
        expected: &'static str,
    },
    /// An ASCII file has no end.
    #[error("it ends before `endsolid`; it is cut: export or download it again")]
    Unfinished,
}

/// Reads the triangles of a file.
pub fn read(bytes: &[u8]) -> Result<Vec<Triangle>, StlError> {
    // Many programs begin binary files with `solid` too, therefore the size decides. A text cannot have the size by chance: its
    // count would be above 10⁸.
    read_binary(bytes).or_else(|error| {
        let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
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
    let found = triangles.len();
    // Some programs end a binary file with a line break.
    let is_whole = u32::try_from(found) == Ok(stated) && rest.trim_ascii().is_empty();
    if !is_whole {
        return Err(StlError::Size { stated, found, size: bytes.len() });
    }
    let number = |bytes: &[u8]| bytes.first_chunk().map_or(f64::NAN, |bytes| f64::from(f32::from_le_bytes(*bytes)));
    let corner = |bytes: &[u8]| Vector3::from_fn(|i, _| number(&bytes[4 * i..]));
    Ok(triangles.iter().map(|bytes| [12, 24, 36].map(|at| corner(&bytes[at..]))).collect())
}

fn read_ascii(text: &str) -> Result<Vec<Triangle>, StlError> {
    let mut words = Words { rest: text };
    let mut triangles = Vec::new();
    let mut is_open = false;
    while let Some(word) = words.next() {
        match word.to_ascii_lowercase().as_str() {
            // A name may follow, of any words.
            "solid" if !is_open => (is_open, words) = (true, words.after_the_line()),
            "endsolid" if is_open => (is_open, words) = (false, words.after_the_line()),
            "facet" if is_open => triangles.push(words.facet(triangles.len() + 1)?),
            _ => {
                let expected = if is_open { "facet" } else { "solid" };
                return Err(StlError::Word { facet: triangles.len() + 1, expected });
            }
        }
    }
    if is_open { Err(StlError::Unfinished) } else { Ok(triangles) }
}

/// The words of an ASCII file; lines do not count.
struct Words<'a> {
    rest: &'a str,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a str> {
        let rest = self.rest.trim_ascii_start();
        let (word, rest) = rest.split_at(rest.find(|c: char| c.is_ascii_whitespace()).unwrap_or(rest.len()));
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    fn after_the_line(self) -> Self {
        Self { rest: self.rest.find(['\n', '\r']).map_or("", |end| &self.rest[end..]) }
    }

    /// Reads a facet from its normal on; `number` counts it, from 1.
    fn facet(&mut self, number: usize) -> Result<Triangle, StlError> {
        self.keyword("normal", number)?;
        self.point("X Y Z behind normal", number)?;
        BEFORE.iter().try_for_each(|word| self.keyword(word, number))?;
        let mut triangle = Triangle::default();
        for corner in &mut triangle {
            self.keyword("vertex", number)?;
            *corner = self.point("X Y Z behind vertex", number)?;
        }
        AFTER.iter().try_for_each(|word| self.keyword(word, number))?;
        Ok(triangle)
    }

    fn keyword(&mut self, expected: &'static str, facet: usize) -> Result<(), StlError> {
        let word = self.next().ok_or(StlError::Unfinished)?;
        if word.eq_ignore_ascii_case(expected) { Ok(()) } else { Err(StlError::Word { facet, expected }) }
    }

    fn point(&mut self, expected: &'static str, facet: usize) -> Result<Vector3<f64>, StlError> {
        let mut point = Vector3::zeros();
        for entry in &mut point {
            let word = self.next().ok_or(StlError::Unfinished)?;
            *entry = word.parse().map_err(|_| StlError::Word { facet, expected })?;
        }
        Ok(point)
    }
}

#[cfg(test)]
mod tests;
