//! Rows of numbers in groups of four, the last group filled up with zeros, so that products take whole groups and never a
//! remainder. Sums have one fixed order: the same numbers give the same bits on every machine.
//!
//! A matrix is its rows one after the other, each of as many groups as the vectors that it is multiplied with. Loops over
//! rows are compiled once for each usual length, up to eight joints, and once for any other.

use std::array;

/// Entries that are treated together.
pub const LANES: usize = 4;

/// A group of entries.
pub type Lanes = [f64; LANES];

/// Groups that `entries` take.
#[inline]
pub fn groups(entries: usize) -> usize {
    entries.div_ceil(LANES)
}

/// Does some work with a number of groups that the compiler knows, where it is a usual one.
macro_rules! with_known {
    ($groups:expr, |$known:ident| $work:expr) => {
        match $groups {
            0 => {}
            1 => {
                let $known = 1;
                $work
            }
            2 => {
                let $known = 2;
                $work
            }
            $known => $work,
        }
    };
}
pub(super) use with_known;

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
        // Both are read before one is written, which spares the question whether they overlap.
        let (before, added) = (*y, *x);
        *y = array::from_fn(|lane| before[lane] + factor * added[lane]);
    }
}

/// y ← A x, row by row.
#[inline]
pub fn rows_times(rows: &[Lanes], x: &[Lanes], y: &mut [f64]) {
    with_known!(x.len(), |groups| {
        rows.chunks_exact(groups).zip(y).for_each(|(row, y)| *y = dot(row, &x[..groups]));
    });
}

/// y ← y + Aᵀ x, row by row.
#[inline]
pub fn add_rows(y: &mut [Lanes], x: &[f64], rows: &[Lanes]) {
    with_known!(y.len(), |groups| {
        rows.chunks_exact(groups).zip(x).for_each(|(row, &x)| add_scaled(&mut y[..groups], x, row));
    });
}

/// x ← H x for one reflection after the other, `vs` their vectors, for each row x of as many groups.
#[inline]
pub fn reflect_all(rows: &mut [Lanes], groups: usize, vs: &[Lanes], gains: &[f64]) {
    with_known!(groups, |groups| {
        for x in rows.chunks_exact_mut(groups) {
            for (v, gain) in vs.chunks_exact(groups).zip(gains) {
                add_scaled(x, -gain * dot(v, x), v);
            }
        }
    });
}

/// The same for one x, the last reflection first.
#[inline]
pub fn reflect_all_back(x: &mut [Lanes], vs: &[Lanes], gains: &[f64]) {
    with_known!(x.len(), |groups| {
        let x = &mut x[..groups];
        for (v, gain) in vs.chunks_exact(groups).zip(gains).rev() {
            add_scaled(x, -gain * dot(v, x), v);
        }
    });
}
