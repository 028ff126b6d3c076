//! How far from singular the levels are on what their bounds leave.

use super::hierarchy::Hierarchy;
use super::solution::{Solution, refill};
use crate::linalg::{Matrix, Row, dot, smallest_eigenvalue};

/// Half width for rows and joints that have one bound or none, in units of joint speed: rad/s or m/s.
pub const HALF_WIDTH: f64 = 1.0;

/// Rows beyond which their Gram matrix would cost more than the elimination of rows.
const MAX_GRAM: usize = 40;

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
    narrow: Vec<Row<8>>,
    wide: Vec<Row<40>>,
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

    /// Returns the regularity of the first `end` rows: from the smallest singular value of [A C, diag(c)], with C the room of
    /// the unknowns and c that of the rows, 0 for equations.
    fn row_regularity(&mut self, levels: &Hierarchy, end: usize, threshold: f64) -> f64 {
        let Self { room, row_room, gram, counted, .. } = self;
        let rows = counted.partition_point(|&row| row < end);
        if counted[..rows].iter().filter(|&&row| row_room[row] == 0.0).count() > levels.unknowns {
            return 0.0;
        }
        if rows > MAX_GRAM {
            return self.regularity_of_many(levels, rows, threshold);
        }
        refill(gram, std::iter::repeat_n(0.0, rows * rows));
        for (place, &i) in counted[..rows].iter().enumerate() {
            for (other, &j) in counted[..=place].iter().enumerate() {
                let product = levels.row(i).iter().zip(levels.row(j)).zip(room.iter());
                let sum: f64 = product.map(|((a, b), c)| a * b * c * c).sum();
                let sum = sum + if i == j { row_room[i] * row_room[i] } else { 0.0 };
                (gram[place * rows + other], gram[other * rows + place]) = (sum, sum);
            }
        }
        self.regularity_of_gram(rows, threshold)
    }

    /// Returns the regularity of the columns of the equations of the first `kept` levels.
    pub fn column_regularity(&mut self, levels: &Hierarchy, kept: usize, threshold: f64) -> f64 {
        let (n, end) = (levels.unknowns, levels.levels[kept - 1].end);
        let equations = || (0..end).filter(|&row| levels.rows[row].is_equation());
        if equations().count() < n {
            return 0.0;
        }
        refill(&mut self.gram, std::iter::repeat_n(0.0, n * n));
        for row in equations().map(|row| levels.row(row)) {
            for (sums, entry) in self.gram.chunks_exact_mut(n).zip(row) {
                sums.iter_mut().zip(row).for_each(|(sum, other)| *sum += entry * other);
            }
        }
        self.regularity_of_gram(n, threshold)
    }

    /// Returns smoothstep(σ_min/threshold) of a matrix from its Gram matrix, of `size` rows.
    fn regularity_of_gram(&mut self, size: usize, threshold: f64) -> f64 {
        let Self { gram, factor, narrow, wide, .. } = self;
        factor.clone_from(gram);
        if exceeds(factor, size, threshold * threshold) {
            return 1.0;
        }
        let smallest = smallest_of_any(gram, size, narrow, wide);
        smooth(smallest.max(0.0).sqrt() / threshold)
    }

    /// The same as [`Self::row_regularity`] for the first `rows` of many rows: work in proportion to their number.
    ///
    /// Of A C² Aᵀ + diag(c²) − λ I, the rows R with much room are eliminated. The rest is S(λ) − λ I, and the smallest eigenvalue
    /// is the λ that is the smallest eigenvalue θ of S(λ). θ falls with λ and is concave.
    fn regularity_of_many(&mut self, levels: &Hierarchy, rows: usize, threshold: f64) -> f64 {
        let n = levels.unknowns;
        let square = threshold * threshold;
        let Some(most) = self.split_rows(levels, rows, square) else { return 1.0 };
        self.write_rest(n, most);
        self.factor.clone_from(&self.gram);
        if exceeds(&mut self.factor, self.kept, most) {
            return smooth(most.sqrt() / threshold);
        }
        let (mut low, mut high) = (0.0_f64, most);
        let (mut last, mut missing) = (most, self.smallest_of_rest() - most);
        // Neither rounding nor a number that is none leaves the interval.
        let inside = |lambda: f64, low: f64, high: f64| lambda.max(low).min(high);
        let mut next = inside(most + missing, 0.0, most);
        for _ in 0..MAX_SECANTS {
            let excess = self.smallest_at(n, next) - next;
            (low, high) = if excess > 0.0 { (next, high.min(next + excess)) } else { (low.max(next + excess), next) };
            let slope = (excess - missing) / (next - last);
            (last, missing) = (next, excess);
            next = inside(last - excess / slope, low, high);
            if excess.abs() <= 4.0 * f64::EPSILON * most || next == last || slope.is_nan() {
                break;
            }
        }
        smooth(last.max(0.0).sqrt() / threshold)
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
        let Self { gram, narrow, wide, kept, .. } = self;
        smallest_of_any(gram, *kept, narrow, wide)
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
        exceeds(factor, n, 0.0);
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

/// Returns the smallest eigenvalue of a Gram matrix; `narrow` and `wide` are room.
fn smallest_of_any(gram: &[f64], size: usize, narrow: &mut Vec<Row<8>>, wide: &mut Vec<Row<40>>) -> f64 {
    match size {
        0..=8 => smallest_of(gram, size, narrow),
        9..=40 => smallest_of(gram, size, wide),
        // This allocates.
        _ => Matrix::from_row_slice(size, size, gram).symmetric_eigenvalues().min(),
    }
}

/// Returns the smallest eigenvalue of a Gram matrix of up to N rows; `rows` is room.
fn smallest_of<const N: usize>(gram: &[f64], size: usize, rows: &mut Vec<Row<N>>) -> f64 {
    refill(rows, gram.chunks_exact(size).map(Row::from_slice));
    smallest_eigenvalue(rows)
}

/// Returns the distance to the nearer bound, relative to half the width between the bounds, at most 1.
fn room(value: f64, lower: f64, upper: f64) -> f64 {
    let half_width = 0.5 * (upper - lower);
    let half_width = if half_width.is_finite() { half_width } else { HALF_WIDTH };
    let distance = (value - lower).min(upper - value).max(0.0);
    if distance == 0.0 { 0.0 } else { (distance / half_width).min(1.0) }
}

/// Returns whether all eigenvalues of a symmetric matrix exceed `bound`, by Cholesky's factorisation in place.
fn exceeds(matrix: &mut [f64], size: usize, bound: f64) -> bool {
    for i in 0..size {
        matrix[i * size + i] -= bound;
        for j in 0..=i {
            let sum = dot(&matrix[i * size..][..j], &matrix[j * size..][..j]);
            let rest = matrix[i * size + j] - sum;
            matrix[i * size + j] = if i > j {
                rest / matrix[j * size + j]
            } else if rest > 0.0 {
                rest.sqrt()
            } else {
                return false;
            };
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolution::hierarchy::Demand;

    /// Reproducible numbers between −1 and 1.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 1_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// Equations and inequality rows, some at their bounds, over joints, some of which have no room.
    #[test]
    fn elimination_of_rows_and_the_gram_matrix_give_the_same_regularity() {
        let mut number = numbers();
        let (n, threshold) = (6, 0.3);
        let mut between = 0;
        for _ in 0..300 {
            let mut levels = Hierarchy::default();
            levels.clear(&[0.0; 6]);
            for _ in 0..12 {
                levels.push_row((0..n).map(|_| number()).collect::<Vec<_>>(), Demand::between(0.0, 1.0, None));
            }
            levels.end_level();
            let mut regularity = Regularity {
                room: (0..n).map(|_| number().max(0.0)).collect(),
                row_room: (0..12).map(|i| if i < 3 { 0.0 } else { number().abs() }).collect(),
                counted: (0..12).collect(),
                ..Regularity::default()
            };
            let expected = regularity.row_regularity(&levels, 12, threshold);
            let found = regularity.regularity_of_many(&levels, 12, threshold);
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
            between += u32::from(0.01 < expected && expected < 0.99);
        }
        assert!(between > 30, "{between}");
    }

    #[test]
    fn rows_beyond_the_range_of_numbers_end_the_secants() {
        let mut levels = Hierarchy::default();
        levels.clear(&[0.0; 2]);
        for row in [[1e200, 0.0], [0.0, 1e200], [1e-200, 1e200]] {
            levels.push_row(row, Demand::between(0.0, 1.0, None));
        }
        levels.end_level();
        let mut regularity = Regularity {
            room: vec![1.0; 2],
            row_room: vec![0.0, 0.0, 0.5],
            counted: (0..3).collect(),
            ..Regularity::default()
        };
        let found = regularity.regularity_of_many(&levels, 3, 1.0);
        assert!((0.0..=1.0).contains(&found), "{found}");
    }

    #[test]
    fn a_threshold_that_is_hardly_a_number_gives_no_regularity() {
        let mut levels = Hierarchy::default();
        levels.clear(&[0.0]);
        levels.push_row([0.0], Demand::between(0.0, 1.0, None));
        levels.end_level();
        let mut regularity =
            Regularity { room: vec![0.0], row_room: vec![0.0], counted: vec![0], ..Regularity::default() };
        assert_eq!(regularity.regularity_of_many(&levels, 1, 5e-324), 0.0);
    }
}
