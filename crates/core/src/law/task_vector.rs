//! Vectors of the size of a task, stored in place.

use std::ops::{Add, Deref, DerefMut, Mul, Neg, Sub};

use smallvec::SmallVec;

use crate::linalg::Vector;

/// A column of up to 12 entries in place, of more on the heap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TaskVector(SmallVec<[f64; 12]>);

impl TaskVector {
    /// Returns `len` zeros.
    pub fn zeros(len: usize) -> Self {
        Self(SmallVec::from_elem(0.0, len))
    }

    /// Returns the vector with the entries `entry(0)`, `entry(1)`, …
    pub fn from_fn(len: usize, mut entry: impl FnMut(usize) -> f64) -> Self {
        let mut vector = Self::zeros(len);
        vector.iter_mut().enumerate().for_each(|(i, place)| *place = entry(i));
        vector
    }

    /// Copies a slice.
    pub fn from_slice(entries: &[f64]) -> Self {
        Self(SmallVec::from_slice(entries))
    }

    /// Returns a copy on the heap.
    pub fn to_vector(&self) -> Vector {
        Vector::from_column_slice(self)
    }
}

impl Deref for TaskVector {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl DerefMut for TaskVector {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

impl Add for &TaskVector {
    type Output = TaskVector;

    fn add(self, other: Self) -> TaskVector {
        TaskVector::from_fn(self.len(), |i| self[i] + other[i])
    }
}

impl Sub for &TaskVector {
    type Output = TaskVector;

    fn sub(self, other: Self) -> TaskVector {
        TaskVector::from_fn(self.len(), |i| self[i] - other[i])
    }
}

impl Mul<f64> for &TaskVector {
    type Output = TaskVector;

    fn mul(self, factor: f64) -> TaskVector {
        TaskVector::from_fn(self.len(), |i| self[i] * factor)
    }
}

impl Neg for &TaskVector {
    type Output = TaskVector;

    fn neg(self) -> TaskVector {
        self * -1.0
    }
}
