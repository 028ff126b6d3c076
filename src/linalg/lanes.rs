//! Rows of numbers in groups of four, the last group filled up with zeros, so that products take whole groups and never a
//! remainder. Sums have one fixed order: the same numbers give the same bits on every machine.

/// Entries that are treated together.
pub const LANES: usize = 4;

/// A group of entries.
pub type Lanes = [f64; LANES];

/// Σ a_i b_i.
#[inline]
pub fn dot(a: &[Lanes], b: &[Lanes]) -> f64 {
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// y ← y + factor x.
#[inline]
pub fn add_scaled(y: &mut [Lanes], factor: f64, x: &[Lanes]) {
    for (y, x) in y.iter_mut().zip(x) {
        for lane in 0..LANES {
            y[lane] += factor * x[lane];
        }
    }
}
