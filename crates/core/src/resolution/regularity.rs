//! How far from singular the levels are on what their bounds leave.

use super::hierarchy::Hierarchy;
use super::solution::{Solution, refill};
use crate::linalg::{add_outer_square, cholesky, dot, eigenvalues_exceed, smallest_eigenvalue};
use crate::tolerances::TOLERANCES;

/// Half width for rows and joints that have one bound or none, in units of joint speed: rad/s or m/s.
pub const HALF_WIDTH: f64 = 1.0;

/// Steps of the secant method. Four or five reach rounding.
const MAX_SECANTS: u32 = 20;

/// Rows with the least room that are not eliminated, beyond one for each unknown.
const SPARE_ROWS: usize = 8;

/// The workspace of the numbers s_k.
#[derive(Default)]
pub struct Regularity {
    room: Vec<f64>,
    row_room: Vec<f64>,
    gram: Vec<f64>,
    factor: Vec<f64>,
    scratch: Vec<f64>,
    /// Rows of tasks and inequalities, without damping rows.
    counted: Vec<usize>,
    /// c² and the rows themselves, ascending, and the rows of A C in that order.
    sorted: Vec<(f64, usize)>,
    scaled: Vec<f64>,
    /// How many of the sorted rows are not eliminated.
    kept: usize,
}

impl Regularity {
    /// Sets the rows that count: all but the damping rows, whose number changes where the factor becomes zero.
    pub fn start(&mut self, levels: &Hierarchy) {
        refill(&mut self.counted, (0..levels.rows.len()).filter(|&row| levels.rows[row].origin.is_some()));
    }

    /// Returns s for the first `kept` levels at a solution, from 0 (singular) to 1 (singular values above the threshold).
    ///
    /// The rows count as regular if they are independent on what the bounds leave, or if the last level determines every
    /// unknown and the rows above it are independent on what the bounds leave.
    pub fn of(&mut self, levels: &Hierarchy, kept: usize, solution: &Solution, threshold: f64) -> f64 {
        self.measure_room(levels, solution);
        let end = levels.levels[kept - 1].end;
        let independent = self.row_regularity(levels, end, threshold);
        let start = levels.levels[kept - 1].start;
        if independent == 1.0 || end < levels.unknowns {
            return independent;
        }
        let determined = self.column_regularity(levels, kept, threshold);
        let above = if start == 0 { 1.0 } else { self.row_regularity(levels, start, threshold) };
        independent.max(determined * above)
    }

    /// Measures how much room each unknown and each inequality row has to its nearer bound: 0 at the bound, 1 far from it.
    fn measure_room(&mut self, levels: &Hierarchy, solution: &Solution) {
        let unknowns = solution.x.iter().zip(levels.bounds());
        refill(&mut self.room, unknowns.map(|(&x, (lower, upper))| room(x, lower, upper)));
        let rows = solution.row_values.iter().zip(&levels.rows);
        refill(&mut self.row_room, rows.map(|(&value, row)| room(value, row.lower, row.upper)));
    }

    /// Returns the regularity of the first `end` rows, smoothstep(σ_min/threshold) for [A C, diag(c)], with C the room of the unknowns
    /// and c that of the rows, 0 for equations: work in proportion to the number of rows.
    ///
    /// Of A C² Aᵀ + diag(c²) − λ I, the rows R with much room are eliminated. The rest is S(λ) − λ I, and the smallest eigenvalue
    /// is the λ that is the smallest eigenvalue θ of S(λ). θ falls with λ and is concave.
    fn row_regularity(&mut self, levels: &Hierarchy, end: usize, threshold: f64) -> f64 {
        let Self { row_room, counted, .. } = self;
        let (n, rows) = (levels.unknowns, counted.partition_point(|&row| row < end));
        if counted[..rows].iter().filter(|&&row| row_room[row] == 0.0).count() > n {
            return 0.0;
        }
        let Some(most) = self.split_rows(levels, rows, threshold * threshold) else { return 1.0 };
        self.write_rest(n, most);
        refill(&mut self.factor, self.gram.iter().copied());
        if eigenvalues_exceed(&mut self.factor, self.kept, most) {
            return smooth(most.sqrt() / threshold);
        }
        let (mut low, mut high) = (0.0_f64, most);
        let (mut last, mut missing) = (most, self.smallest_of_rest() - most);
        // Neither rounding nor a number that is none leaves the interval.
        let inside = |lambda: f64, low: f64, high: f64| lambda.max(low).min(high);
        let mut next = inside(most + missing, 0.0, most);
        for _ in 0..if self.kept < rows { MAX_SECANTS } else { 0 } {
            let excess = self.smallest_at(n, next) - next;
            (low, high) = if excess > 0.0 { (next, high.min(next + excess)) } else { (low.max(next + excess), next) };
            let slope = (excess - missing) / (next - last);
            (last, missing) = (next, excess);
            next = inside(last - excess / slope, low, high);
            if excess.abs() <= TOLERANCES.secant * most || next == last || slope.is_nan() {
                break;
            }
        }
        smooth(next.max(0.0).sqrt() / threshold)
    }

    /// Returns the regularity of the columns of the equations of the first `kept` levels.
    pub fn column_regularity(&mut self, levels: &Hierarchy, kept: usize, threshold: f64) -> f64 {
        let (n, end) = (levels.unknowns, levels.levels[kept - 1].end);
        let equations = || (0..end).filter(|&row| levels.rows[row].is_equation());
        if equations().count() < n {
            return 0.0;
        }
        refill(&mut self.gram, std::iter::repeat_n(0.0, n * n));
        equations().for_each(|row| add_outer_square(&mut self.gram, levels.row(row)));
        refill(&mut self.factor, self.gram.iter().copied());
        if eigenvalues_exceed(&mut self.factor, n, threshold * threshold) {
            return 1.0;
        }
        let smallest = smallest_eigenvalue(&mut self.gram, n, &mut self.scratch);
        smooth(smallest.max(0.0).sqrt() / threshold)
    }

    /// Sorts rows by their room and writes A C; those with the least are kept, the rest is R. Returns a bound of the smallest
    /// eigenvalue, `square` at most; `None` if no row has so little room.
    fn split_rows(&mut self, levels: &Hierarchy, rows: usize, square: f64) -> Option<f64> {
        let Self { room, row_room, sorted, scaled, counted, .. } = self;
        let n = levels.unknowns;
        refill(sorted, counted[..rows].iter().map(|&row| (row_room[row] * row_room[row], row)));
        sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        // A combination of n + 1 rows sees no unknown.
        let most = sorted.get(n).map_or(square, |(room, _)| room.min(square));
        self.kept = sorted.iter().take_while(|(room, _)| *room <= 2.0 * most).count().min(n + SPARE_ROWS);
        scaled.clear();
        for (_, row) in &*sorted {
            scaled.extend(levels.row(*row).iter().zip(&*room).map(|(a, room)| a * room));
        }
        (self.kept > 0).then_some(most)
    }

    /// Returns θ(λ).
    fn smallest_at(&mut self, n: usize, lambda: f64) -> f64 {
        self.write_rest(n, lambda);
        self.smallest_of_rest()
    }

    fn smallest_of_rest(&mut self) -> f64 {
        smallest_eigenvalue(&mut self.gram, self.kept, &mut self.scratch)
    }

    /// Writes S(λ) = diag(c²) + A C P⁻¹ C Aᵀ over the kept rows into `gram`, with P = I + Σ_R (C a)(C a)ᵀ/(c² − λ).
    fn write_rest(&mut self, n: usize, lambda: f64) {
        let Self { gram, factor, sorted, scaled, kept, .. } = self;
        refill(factor, (0..n * n).map(|at| if at % (n + 1) == 0 { 1.0 } else { 0.0 }));
        for ((room, _), row) in sorted.iter().zip(scaled.chunks_exact(n)).skip(*kept) {
            let weight = 1.0 / (room - lambda).max(f64::EPSILON * room);
            for (i, entries) in factor.chunks_exact_mut(n).enumerate() {
                let scaled = weight * row[i];
                entries[..=i].iter_mut().zip(row).for_each(|(entry, other)| *entry += scaled * other);
            }
        }
        // P is at least I.
        cholesky(factor, n);
        // u = L⁻¹ C a for each kept row, behind S.
        let count = *kept;
        refill(gram, std::iter::repeat_n(0.0, count * (count + n)));
        let (rest, solved) = gram.split_at_mut(count * count);
        for (u, row) in solved.chunks_exact_mut(n).zip(scaled.chunks_exact(n)) {
            for i in 0..n {
                u[i] = (row[i] - dot(&factor[i * n..][..i], &u[..i])) / factor[i * n + i];
            }
        }
        for i in 0..count {
            for j in 0..=i {
                let product = dot(&solved[i * n..][..n], &solved[j * n..][..n]);
                let sum = product + if i == j { sorted[i].0 } else { 0.0 };
                (rest[i * count + j], rest[j * count + i]) = (sum, sum);
            }
        }
        gram.truncate(count * count);
    }
}

/// Returns a smooth step from 0 at 0 to 1 at 1 and beyond.
fn smooth(ratio: f64) -> f64 {
    let ratio = ratio.min(1.0);
    ratio * ratio * (3.0 - 2.0 * ratio)
}

/// Half width of the widest box that counts, rad/s: no joint of an arm is as fast.
pub const WIDEST: f64 = 10.0;

/// Returns the distance to the nearer bound, relative to half the width between the bounds, at most [`WIDEST`], and at most 1.
fn room(value: f64, lower: f64, upper: f64) -> f64 {
    let half_width = 0.5 * (upper - lower);
    let half_width = if half_width.is_finite() { half_width.min(WIDEST) } else { HALF_WIDTH };
    let distance = (value - lower).min(upper - value).max(0.0);
    if distance == 0.0 { 0.0 } else { (distance / half_width).min(1.0) }
}

#[cfg(test)]
mod tests;
