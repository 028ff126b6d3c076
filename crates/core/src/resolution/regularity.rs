//! How far from singular the levels are on what their bounds leave.

use super::hierarchy::Hierarchy;
use super::solution::{Solution, refill};
use crate::linalg::{Matrix, Row, dot, smallest_eigenvalue};

/// Half width for rows and joints that have one bound or none, in units of joint speed: rad/s or m/s.
pub const HALF_WIDTH: f64 = 1.0;

/// Rows beyond which their Gram matrix would cost more than bisection.
const MAX_GRAM: usize = 40;

/// Halvings of an interval until it is as wide as rounding.
const HALVINGS: u32 = 44;

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
        let determined = self.column_regularity(levels, end, threshold);
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

    /// Returns the regularity of the columns of the first `end` rows.
    fn column_regularity(&mut self, levels: &Hierarchy, end: usize, threshold: f64) -> f64 {
        let n = levels.unknowns;
        refill(&mut self.gram, std::iter::repeat_n(0.0, n * n));
        for row in (0..end).filter(|&row| levels.rows[row].is_equation()).map(|row| levels.row(row)) {
            for i in 0..n {
                for j in 0..n {
                    self.gram[i * n + j] += row[i] * row[j];
                }
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
        let smallest = match size {
            0..=8 => smallest_of(gram, size, narrow),
            9..=40 => smallest_of(gram, size, wide),
            // This allocates.
            _ => Matrix::from_row_slice(size, size, gram).symmetric_eigenvalues().min(),
        };
        smooth(smallest.max(0.0).sqrt() / threshold)
    }

    /// The same as [`Self::row_regularity`] for the first `rows` of many rows, by bisection: work in proportion to their number.
    fn regularity_of_many(&mut self, levels: &Hierarchy, rows: usize, threshold: f64) -> f64 {
        if self.exceed(levels, rows, threshold) {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, threshold);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            if self.exceed(levels, rows, middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        smooth(low / threshold)
    }

    /// Returns whether all singular values of [A C, diag(c)] exceed `bound` = t.
    ///
    /// The rows R with c² > 2 t² are eliminated from A C² Aᵀ + diag(c²) − t² I first, by Woodbury: with P = I + Σ_R (C a)(C a)ᵀ/(c² − t²),
    /// the rest is diag(c² − t²) + A C P⁻¹ C Aᵀ over the other rows.
    fn exceed(&mut self, levels: &Hierarchy, rows: usize, bound: f64) -> bool {
        let Self { room, row_room, gram, factor, counted, .. } = self;
        let (n, square) = (levels.unknowns, bound * bound);
        let rest = |row: usize| row_room[row] * row_room[row] - square;
        let is_eliminated = |row: &usize| rest(*row) > square;
        refill(factor, (0..n * n).map(|at| if at % (n + 1) == 0 { 1.0 } else { 0.0 }));
        for &row in counted[..rows].iter().filter(|row| is_eliminated(row)) {
            let (a, weight) = (levels.row(row), 1.0 / rest(row));
            for i in 0..n {
                let scaled = weight * a[i] * room[i];
                for j in 0..=i {
                    factor[i * n + j] += scaled * a[j] * room[j];
                }
            }
        }
        if !exceeds(factor, n, 0.0) {
            return false;
        }
        // u = L⁻¹ C a for each other row, one after the other in `gram`.
        gram.clear();
        let others = || counted[..rows].iter().copied().filter(|row| !is_eliminated(row));
        for row in others() {
            let start = gram.len();
            for i in 0..n {
                let known: f64 = (0..i).map(|j| factor[i * n + j] * gram[start + j]).sum();
                gram.push((levels.row(row)[i] * room[i] - known) / factor[i * n + i]);
            }
        }
        let count = gram.len() / n;
        refill(factor, std::iter::repeat_n(0.0, count * count));
        for (i, row) in others().enumerate() {
            for j in 0..=i {
                factor[i * count + j] = dot(&gram[i * n..][..n], &gram[j * n..][..n]);
            }
            factor[i * count + i] += rest(row);
        }
        exceeds(factor, count, 0.0)
    }
}

/// Returns a smooth step from 0 at 0 to 1 at 1 and beyond.
fn smooth(ratio: f64) -> f64 {
    let ratio = ratio.min(1.0);
    ratio * ratio * (3.0 - 2.0 * ratio)
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
            let sum: f64 = (0..j).map(|l| matrix[i * size + l] * matrix[j * size + l]).sum();
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
    fn bisection_and_the_gram_matrix_give_the_same_regularity() {
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
    fn a_threshold_that_is_hardly_a_number_ends_the_bisection() {
        let mut levels = Hierarchy::default();
        levels.clear(&[0.0]);
        levels.push_row([0.0], Demand::between(0.0, 1.0, None));
        levels.end_level();
        let mut regularity =
            Regularity { room: vec![0.0], row_room: vec![0.0], counted: vec![0], ..Regularity::default() };
        assert_eq!(regularity.regularity_of_many(&levels, 1, 5e-324), 0.0);
    }
}
