//! A set-point at one time.

use smallvec::SmallVec;

/// The m entries of a set-point. Up to 12 are stored without allocation.
pub type Entries = SmallVec<[f64; 12]>;

/// A value at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// t, s.
    pub time_s: f64,
    /// The value at that time, m entries.
    pub value: Vec<f64>,
}

/// A set-point at one time, m entries each.
#[derive(Debug, Clone, PartialEq)]
pub struct SetPoint {
    /// The value.
    pub value: Entries,
    /// Its time derivative, per s.
    pub rate: Entries,
    /// Its second time derivative, per s².
    pub acceleration: Entries,
}

impl SetPoint {
    /// Returns a set-point with this value and zero derivatives.
    pub fn resting(value: Entries) -> Self {
        let zero = Entries::from_elem(0.0, value.len());
        Self { value, rate: zero.clone(), acceleration: zero }
    }
}
