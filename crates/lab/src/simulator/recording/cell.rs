//! Values of table cells.

use revprio_api::wire;
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::{Error, StrDeserializer};

use super::{AtLimit, ContactEvent, ContactWord};

/// A value that is read from or written to a file.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// No value.
    Missing,
    /// A number.
    Number(f64),
    /// A non-negative integer.
    Count(u64),
    /// True or false.
    Flag(bool),
    /// A word.
    Word(String),
}

/// A field of a sample as the value of a table cell.
pub trait Cell {
    /// Returns the value.
    fn value(&self) -> Value;

    /// Sets the value; returns false if it has another kind.
    fn set(&mut self, value: Value) -> bool;
}

/// A field with one cell or several.
pub trait Cells {
    /// Type of a cell.
    type Cell: Cell;

    /// Returns a cell by index.
    fn cell(&self, i: usize) -> Option<&Self::Cell>;

    /// Returns a mutable cell by index.
    fn cell_mut(&mut self, i: usize) -> Option<&mut Self::Cell>;
}

impl<T: Cell> Cells for T {
    type Cell = T;

    fn cell(&self, i: usize) -> Option<&T> {
        (i == 0).then_some(self)
    }

    fn cell_mut(&mut self, i: usize) -> Option<&mut T> {
        (i == 0).then_some(self)
    }
}

impl<T: Cell> Cells for Vec<T> {
    type Cell = T;

    fn cell(&self, i: usize) -> Option<&T> {
        self.get(i)
    }

    fn cell_mut(&mut self, i: usize) -> Option<&mut T> {
        self.get_mut(i)
    }
}

/// The cells of all entries one after another.
impl<T: Cell, const N: usize> Cells for Vec<[T; N]> {
    type Cell = T;

    fn cell(&self, i: usize) -> Option<&T> {
        self.as_flattened().get(i)
    }

    fn cell_mut(&mut self, i: usize) -> Option<&mut T> {
        self.as_flattened_mut().get_mut(i)
    }
}

impl<T: Cell, const N: usize> Cells for [T; N] {
    type Cell = T;

    fn cell(&self, i: usize) -> Option<&T> {
        self.get(i)
    }

    fn cell_mut(&mut self, i: usize) -> Option<&mut T> {
        self.get_mut(i)
    }
}

/// Implements [`Cell`] for a type that is a variant of [`Value`].
macro_rules! cell {
    ($($kind:ty: $variant:ident),+) => {$(
        impl Cell for $kind {
            fn value(&self) -> Value {
                Value::$variant(*self)
            }

            fn set(&mut self, value: Value) -> bool {
                let Value::$variant(value) = value else { return false };
                *self = value;
                true
            }
        }
    )+};
}

cell!(f64: Number, u64: Count, bool: Flag);

impl Cell for Option<f64> {
    fn value(&self) -> Value {
        self.map_or(Value::Missing, Value::Number)
    }

    fn set(&mut self, value: Value) -> bool {
        *self = match value {
            Value::Missing => None,
            Value::Number(value) => Some(value),
            _ => return false,
        };
        true
    }
}

/// Implements [`Cell`] for an enum that is serialized as a word.
macro_rules! word {
    ($($kind:ty),+) => {$(
        impl Cell for $kind {
            fn value(&self) -> Value {
                Value::Word(self.to_string())
            }

            fn set(&mut self, value: Value) -> bool {
                let Value::Word(word) = value else { return false };
                let word: StrDeserializer<Error> = word.as_str().into_deserializer();
                <$kind>::deserialize(word).map(|word| *self = word).is_ok()
            }
        }
    )+};
}

word!(wire::Path, wire::Status, AtLimit, ContactEvent, ContactWord);
