//! Vectors of the size of a task: stored in place, on the heap only where they are larger.

use std::fmt;
use std::ops::{Add, AddAssign, Deref, DerefMut, Mul, Neg, Sub, SubAssign};

use super::Vector;
use super::lanes::{LANES, Lanes, add_scaled, dot, groups};

/// Groups in place: a vector of 128 bytes is copied by a few moves, a larger one by a call.
const NEAR: usize = 3;

/// A column of up to 12 entries in place, of more on the heap.
#[derive(PartialEq, Default)]
pub struct TaskVector {
    len: usize,
    /// Zero beyond `len`, so that all of it can be added and multiplied.
    near: [Lanes; NEAR],
    /// All groups of a vector that has no room in place.
    far: Box<[Lanes]>,
}

impl Clone for TaskVector {
    #[inline]
    fn clone(&self) -> Self {
        let far = if self.far.is_empty() { Box::default() } else { self.far.clone() };
        Self { len: self.len, near: self.near, far }
    }
}

impl TaskVector {
    /// `len` zeros.
    #[inline]
    pub fn zeros(len: usize) -> Self {
        let far = if len > NEAR * LANES { vec![[0.0; LANES]; groups(len)].into() } else { Box::default() };
        Self { len, near: [[0.0; LANES]; NEAR], far }
    }

    /// Entry by entry.
    #[inline]
    pub fn from_fn(len: usize, mut entry: impl FnMut(usize) -> f64) -> Self {
        let mut vector = Self::zeros(len);
        vector.iter_mut().enumerate().for_each(|(i, x)| *x = entry(i));
        vector
    }

    /// A copy.
    #[inline]
    pub fn from_slice(entries: &[f64]) -> Self {
        let mut vector = Self::zeros(entries.len());
        vector.copy_from_slice(entries);
        vector
    }

    /// Zeros, but for a one at `place`.
    #[inline]
    pub fn unit(len: usize, place: usize) -> Self {
        let mut unit = Self::zeros(len);
        unit[place] = 1.0;
        unit
    }

    /// Adds an entry.
    #[inline]
    pub fn push(&mut self, entry: f64) {
        if groups(self.len + 1) == groups(self.len) {
            self.len += 1;
        } else {
            let mut longer = Self::zeros(self.len + 1);
            longer[..self.len].copy_from_slice(self);
            *self = longer;
        }
        let last = self.len - 1;
        self[last] = entry;
    }

    /// The first `len` entries.
    #[must_use]
    #[inline]
    pub fn first(&self, len: usize) -> Self {
        Self::from_slice(&self[..len])
    }

    /// As a vector of any size.
    #[inline]
    pub fn to_vector(&self) -> Vector {
        Vector::from_column_slice(self)
    }

    #[inline]
    pub(super) fn lanes(&self) -> &[Lanes] {
        if self.far.is_empty() { &self.near[..groups(self.len)] } else { &self.far }
    }

    #[inline]
    pub(super) fn lanes_mut(&mut self) -> &mut [Lanes] {
        if self.far.is_empty() { &mut self.near[..groups(self.len)] } else { &mut self.far }
    }

    /// Σ x_i y_i.
    #[inline]
    pub fn dot(&self, other: &Self) -> f64 {
        if self.far.is_empty() { dot(&self.near, &other.near) } else { dot(&self.far, &other.far) }
    }

    /// ‖x‖.
    #[inline]
    pub fn norm(&self) -> f64 {
        self.dot(self).sqrt()
    }

    /// ‖x‖_∞, 0 for no entry at all; NaN where an entry is.
    #[inline]
    pub fn amax(&self) -> f64 {
        self.iter().fold(0.0, |most: f64, x| if x.abs() > most || x.is_nan() { x.abs() } else { most })
    }

    /// x ← x + factor y.
    #[inline]
    pub fn add_scaled(&mut self, factor: f64, y: &Self) {
        if self.far.is_empty() {
            add_scaled(&mut self.near, factor, &y.near);
        } else {
            add_scaled(&mut self.far, factor, &y.far);
        }
    }

    /// The entries of both, one after the other.
    #[must_use]
    #[inline]
    pub fn concatenated(&self, other: &Self) -> Self {
        let mut both = Self::zeros(self.len + other.len);
        both[..self.len].copy_from_slice(self);
        both[self.len..].copy_from_slice(other);
        both
    }

    /// x with `f` applied to each entry.
    #[must_use]
    #[inline]
    pub fn map(&self, mut f: impl FnMut(f64) -> f64) -> Self {
        Self::from_fn(self.len, |i| f(self[i]))
    }
}

impl fmt::Debug for TaskVector {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.debug_list().entries(self.iter()).finish()
    }
}

impl Deref for TaskVector {
    type Target = [f64];

    #[inline]
    fn deref(&self) -> &[f64] {
        let all = if self.far.is_empty() { self.near.as_flattened() } else { self.far.as_flattened() };
        &all[..self.len]
    }
}

impl DerefMut for TaskVector {
    #[inline]
    fn deref_mut(&mut self) -> &mut [f64] {
        let all = if self.far.is_empty() { self.near.as_flattened_mut() } else { self.far.as_flattened_mut() };
        &mut all[..self.len]
    }
}

impl From<&Vector> for TaskVector {
    #[inline]
    fn from(vector: &Vector) -> Self {
        Self::from_slice(vector.as_slice())
    }
}

impl AddAssign<&Self> for TaskVector {
    #[inline]
    fn add_assign(&mut self, other: &Self) {
        self.add_scaled(1.0, other);
    }
}

impl SubAssign<&Self> for TaskVector {
    #[inline]
    fn sub_assign(&mut self, other: &Self) {
        self.add_scaled(-1.0, other);
    }
}

impl Add for &TaskVector {
    type Output = TaskVector;

    #[inline]
    fn add(self, other: Self) -> TaskVector {
        let mut sum = self.clone();
        sum += other;
        sum
    }
}

impl Sub for &TaskVector {
    type Output = TaskVector;

    #[inline]
    fn sub(self, other: Self) -> TaskVector {
        let mut difference = self.clone();
        difference -= other;
        difference
    }
}

impl Mul<f64> for &TaskVector {
    type Output = TaskVector;

    #[inline]
    fn mul(self, factor: f64) -> TaskVector {
        let mut product = self.clone();
        product.iter_mut().for_each(|x| *x *= factor);
        product
    }
}

impl Neg for &TaskVector {
    type Output = TaskVector;

    #[inline]
    fn neg(self) -> TaskVector {
        self * -1.0
    }
}
