//! A row of the factorisation, and the steps that turn rows into a triangle.

use crate::linalg::Row;
use crate::tolerances::TOLERANCES;

/// An active row: its part of the triangle, and what belongs to it in the problem.
#[derive(Debug, Clone, Default)]
pub struct FactorRow<const N: usize> {
    /// The row over the coordinates, a row of L.
    pub coordinates: Row<N>,
    /// What reflections have left of the row, over the unknowns; for a pivot v of its own reflection I − gain v vᵀ.
    pub rest: Row<N>,
    /// Its index in the problem.
    pub index: usize,
    /// b.
    pub target: f64,
    /// b − a·x.
    pub residual: f64,
    /// 1 / pivot, for a pivot.
    pub inverse: f64,
    pub gain: f64,
    /// ‖rest‖².
    pub square: f64,
    /// `square` when it was summed last.
    pub summed_square: f64,
}

impl<const N: usize> FactorRow<N> {
    /// Exchanges two rows that are no pivots yet. Part by part they stay in registers; as a whole they would be copied by calls.
    #[inline]
    fn exchange(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.coordinates, &mut other.coordinates);
        std::mem::swap(&mut self.rest, &mut other.rest);
        std::mem::swap(&mut self.index, &mut other.index);
        std::mem::swap(&mut self.target, &mut other.target);
        std::mem::swap(&mut self.residual, &mut other.residual);
        std::mem::swap(&mut self.square, &mut other.square);
        std::mem::swap(&mut self.summed_square, &mut other.summed_square);
    }

    /// Applies the reflection of a pivot.
    #[inline]
    pub fn reflect(&self, u: &mut Row<N>) {
        u.add_scaled(-self.gain * self.rest.dot(u), &self.rest);
    }
}

/// Takes the row p of `pivot` as the coordinate c, with the entry e at the place `head`, and removes it from the `later` rows;
/// returns y_c.
///
/// With α = ∓‖p‖ and v = p − α e, H = I − g v vᵀ gives H p = α e. A row r gets the coordinate p·r/α, and v·r = p·r − α r_e,
/// so that the products p·r do not wait for the square root. The rest of r has zero at e, elsewhere v is p.
// Not inlined: the compiler then knows that the pivot is none of the later rows.
#[inline(never)]
pub fn remove_coordinate<const N: usize>(
    pivot: &mut FactorRow<N>,
    later: &mut [FactorRow<N>],
    square: f64,
    (c, head): (usize, usize),
) -> f64 {
    let p = pivot.rest;
    let length = square.sqrt();
    // −0 counts as 0: the sign of α decides the last bits.
    let entry = p.0[head] + 0.0;
    let alpha = -length.copysign(entry);
    let inverse = 1.0 / alpha;
    let gain = 1.0 / (length * (length + entry.abs()));
    let y = pivot.residual * inverse;
    for row in later {
        let (product, at_head) = (p.dot(&row.rest), row.rest.0[head]);
        row.rest.add_scaled(gain * (alpha * at_head - product), &p);
        row.rest.0[head] = 0.0;
        let coordinate = product * inverse;
        row.coordinates.0[c] = coordinate;
        row.residual -= coordinate * y;
        row.square -= coordinate * coordinate;
    }
    pivot.coordinates.0[c] = alpha;
    pivot.rest.0[head] -= alpha;
    (pivot.inverse, pivot.gain, pivot.residual) = (inverse, gain, 0.0);
    y
}

/// Moves the longest of these rows to the front; returns its squared length. Before it counts as too short, with `least` at most,
/// all lengths are summed again.
pub fn bring_longest<const N: usize>(rows: &mut [FactorRow<N>], least: f64) -> f64 {
    let mut longest = longest(rows);
    let square = rows[longest].square;
    if square <= TOLERANCES.trusted_square * rows[longest].summed_square || square <= least {
        sum_squares(rows);
        longest = self::longest(rows);
    }
    if longest > 0 {
        let (before, from) = rows.split_at_mut(longest);
        before[0].exchange(&mut from[0]);
    }
    rows[0].square
}

#[cold]
fn sum_squares<const N: usize>(rows: &mut [FactorRow<N>]) {
    for row in rows {
        row.square = row.rest.dot(&row.rest);
        row.summed_square = row.square;
    }
}

#[inline]
fn longest<const N: usize>(rows: &[FactorRow<N>]) -> usize {
    let (mut longest, mut most) = (0, rows[0].square);
    for (place, row) in rows.iter().enumerate() {
        if row.square > most {
            (longest, most) = (place, row.square);
        }
    }
    longest
}
