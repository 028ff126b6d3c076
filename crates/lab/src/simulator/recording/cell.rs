//! One value of a table, whatever it stands for.

use revprio_api::wire;
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::{Error, StrDeserializer};

use super::AtLimit;

/// A value on its way into a file or out of it.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Nothing.
    Missing,
    /// A number.
    Number(f64),
    /// A whole number.
    Count(u64),
    /// True or false.
    Flag(bool),
    /// One of a few words.
    Word(String),
}

/// What one value of a sample is to a table.
pub trait Cell {
    /// The value.
    fn value(&self) -> Value;

    /// Takes a value; false if it is of another kind.
    fn put(&mut self, value: Value) -> bool;
}

/// One cell or a row of them.
pub trait Cells {
    /// What a cell is.
    type Cell: Cell;

    /// A cell by number.
    fn cell(&self, i: usize) -> Option<&Self::Cell>;

    /// A cell by number, to be filled.
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

impl<T: Cell, const N: usize> Cells for [T; N] {
    type Cell = T;

    fn cell(&self, i: usize) -> Option<&T> {
        self.get(i)
    }

    fn cell_mut(&mut self, i: usize) -> Option<&mut T> {
        self.get_mut(i)
    }
}

/// A kind of value that is a variant of [`Value`].
macro_rules! cell {
    ($($kind:ty: $variant:ident),+) => {$(
        impl Cell for $kind {
            fn value(&self) -> Value {
                Value::$variant(*self)
            }

            fn put(&mut self, value: Value) -> bool {
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

    fn put(&mut self, value: Value) -> bool {
        *self = match value {
            Value::Missing => None,
            Value::Number(value) => Some(value),
            _ => return false,
        };
        true
    }
}

/// A word of the interface.
macro_rules! word {
    ($($kind:ty),+) => {$(
        impl Cell for $kind {
            fn value(&self) -> Value {
                Value::Word(self.to_string())
            }

            fn put(&mut self, value: Value) -> bool {
                let Value::Word(word) = value else { return false };
                let word: StrDeserializer<Error> = word.as_str().into_deserializer();
                <$kind>::deserialize(word).map(|word| *self = word).is_ok()
            }
        }
    )+};
}

word!(wire::Path, wire::Status, AtLimit);
