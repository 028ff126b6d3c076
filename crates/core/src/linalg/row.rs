//! Rows of N numbers, padded with zeros.
//!
//! N is a multiple of four that the compiler knows, so that loops over a row become vector instructions. Sums have one
//! fixed order and no fused multiplication: the same numbers give the same bits on every machine.

use std::array;
use std::ops::Deref;

/// A row of up to N numbers, zero beyond the last one.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub struct Row<const N: usize>(pub [f64; N]);

impl<const N: usize> Default for Row<N> {
    fn default() -> Self {
        Self::ZERO
    }
}

impl<const N: usize> Deref for Row<N> {
    type Target = [f64; N];

    fn deref(&self) -> &[f64; N] {
        &self.0
    }
}

impl<const N: usize> Row<N> {
    /// Zeros.
    pub const ZERO: Self = Self([0.0; N]);

    /// Copies `entries`, N at most.
    #[inline]
    pub fn from_slice(entries: &[f64]) -> Self {
        let mut row = Self::ZERO;
        row.0[..entries.len()].copy_from_slice(entries);
        row
    }

    /// Returns Σ a_i b_i.
    #[inline]
    pub fn dot(&self, other: &[f64; N]) -> f64 {
        let (a, b) = (self.0.as_chunks::<4>().0, other.as_chunks::<4>().0);
        let mut sums: [f64; 4] = array::from_fn(|lane| a[0][lane] * b[0][lane]);
        for (a, b) in a[1..].iter().zip(&b[1..]) {
            for lane in 0..4 {
                sums[lane] += a[lane] * b[lane];
            }
        }
        (sums[0] + sums[2]) + (sums[1] + sums[3])
    }

    /// Returns the Euclidean norm.
    #[inline]
    pub fn norm(&self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Returns the largest absolute value.
    #[inline]
    pub fn amax(&self) -> f64 {
        let mut largest = [0.0_f64; 4];
        for chunk in self.0.as_chunks::<4>().0 {
            for lane in 0..4 {
                let size = chunk[lane].abs();
                largest[lane] = if size > largest[lane] { size } else { largest[lane] };
            }
        }
        largest.into_iter().fold(0.0, f64::max)
    }

    /// Adds `factor` · `other`.
    #[inline]
    pub fn add_scaled(&mut self, factor: f64, other: &[f64; N]) {
        for (entry, other) in self.0.iter_mut().zip(other) {
            *entry += factor * other;
        }
    }

    /// Adds `factor` · `other`, which is zero from the entry `end` on.
    #[inline]
    pub fn add_scaled_before(&mut self, end: usize, factor: f64, other: &Self) {
        let groups = if N > 8 { end.div_ceil(4) } else { N / 4 };
        for (entries, others) in self.0.as_chunks_mut::<4>().0.iter_mut().zip(other.0.as_chunks::<4>().0).take(groups) {
            for (entry, other) in entries.iter_mut().zip(others) {
                *entry += factor * other;
            }
        }
    }

    /// Returns the sum.
    #[inline]
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self(array::from_fn(|i| self.0[i] + other.0[i]))
    }

    /// Returns the difference.
    #[inline]
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        Self(array::from_fn(|i| self.0[i] - other.0[i]))
    }

    /// Returns `factor` times the row.
    #[inline]
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self(array::from_fn(|i| self.0[i] * factor))
    }

    /// Returns the products of the entries.
    #[inline]
    #[must_use]
    pub fn times(&self, other: &[f64; N]) -> Self {
        Self(array::from_fn(|i| self.0[i] * other[i]))
    }

    /// Returns the entries moved into [lower, upper].
    #[inline]
    #[must_use]
    pub fn clamp(&self, lower: &Self, upper: &Self) -> Self {
        Self(array::from_fn(|i| {
            let raised = if self.0[i] < lower.0[i] { lower.0[i] } else { self.0[i] };
            if raised > upper.0[i] { upper.0[i] } else { raised }
        }))
    }
}
