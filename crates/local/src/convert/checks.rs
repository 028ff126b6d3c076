//! Checks of the parts of a body, and the places of their errors.

use std::fmt::Display;

use crate::error::ApiError;
use crate::robots::MAX_NAME;

/// What reading a part of a body returns.
pub type Result<T, E = ApiError> = std::result::Result<T, E>;

/// Refuses the field at `pointer` if it is not right; `detail` says why, with the remedy.
pub fn check(is_right: bool, pointer: &str, detail: impl Display) -> Result<()> {
    is_right.then_some(()).or_invalid(pointer, detail)
}

/// Refuses a name that is empty, too long, or breaks the line or the quotes of a sentence.
pub fn check_name(name: &str, pointer: &str) -> Result<()> {
    let is_word = (1..=MAX_NAME).contains(&name.len()) && !name.contains(|c: char| c.is_control() || c == '`');
    check(is_word, pointer, format_args!("give a name of 1 to {MAX_NAME} bytes, without '`' and control characters"))
}

/// Places the error of a part of a body in the whole body.
pub trait Inside: Sized {
    /// Puts `place` before the pointer of an error: the place of the part in the whole body.
    fn inside(self, place: &str) -> Self;
}

impl<T> Inside for Result<T> {
    fn inside(self, place: &str) -> Self {
        self.map_err(|error| error.inside(place))
    }
}

/// Reads a list at `place`. `read` gets the index and the entry; its pointers begin at the entry.
pub fn each<'a, T, U, C: FromIterator<U>>(
    place: &str,
    list: &'a [T],
    read: impl Fn(usize, &'a T) -> Result<U>,
) -> Result<C> {
    list.iter()
        .enumerate()
        .map(|(i, entry)| read(i, entry).map_err(|error| error.inside(&format!("{place}/{i}"))))
        .collect()
}

/// Names the field that is wrong if the library refuses it.
pub trait Refused<T> {
    /// Turns the error of the library into one of the field at `pointer`.
    fn at(self, pointer: &str) -> Result<T>;
}

impl<T, E: Display> Refused<T> for Result<T, E> {
    fn at(self, pointer: &str) -> Result<T> {
        self.map_err(|error| ApiError::invalid(pointer, error))
    }
}

/// Names the field that is wrong if something is missing.
pub trait Missing<T> {
    /// Returns the value, or the error of the field at `pointer`; `detail` says why, with the remedy.
    fn or_invalid(self, pointer: &str, detail: impl Display) -> Result<T>;
}

impl<T> Missing<T> for Option<T> {
    fn or_invalid(self, pointer: &str, detail: impl Display) -> Result<T> {
        self.ok_or_else(|| ApiError::invalid(pointer, detail))
    }
}

/// Returns the error of a part of a memory that does not fit the controller.
pub fn foreign(pointer: &str, what: &str) -> ApiError {
    ApiError::invalid(pointer, format!("{what}; send the memory of the last answer unchanged"))
}
