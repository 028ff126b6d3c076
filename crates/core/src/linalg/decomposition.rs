//! Rank, pseudo-inverse and null space of a matrix, with singular values where they are asked for.
#![allow(non_snake_case)]

use super::lanes::{add_scaled, dot};
use super::reflections::{Order, Reflections};
use super::singular::Singular;
use super::{TaskMatrix, TaskVector, triangle};

/// Singular values below this fraction of the matrix's Frobenius norm count as zero; of a product A N with an
/// orthonormal N, below this fraction of the norm of A.
///
/// Rounding in a product of task matrices leaves some 1e-15 of the scale, and rows that an engineer calls
/// independent differ by far more than 1e-8; the decision sits between.
pub const RANK_TOLERANCE: f64 = 1e-10;

/// Rows shorter than this are zero: their squares leave the numbers.
const SMALLEST: f64 = 1e-150;

/// A = U C V_rᵀ with orthonormal V = [V_r, N]: coordinates in the *frame* V separate what A sees, the first r, from its
/// null space, the others.
///
/// The rank r is that of the singular values above [`RANK_TOLERANCE`] times a scale. Reflections of the longest rows
/// first (QR decomposition with pivoting) enclose the singular values; where that leaves the rank in doubt, which takes
/// singular values within some powers of two of the tolerance, they are computed and decide.
#[derive(Debug, Clone, Default)]
pub struct Decomposition {
    rows: usize,
    columns: usize,
    rank: usize,
    reflections: Reflections,
    core: Core,
    /// Of the core where the rank is below the number of rows: its own reflections. They act on the rows in the order in
    /// which they were taken, so that what is asked of rows of nothing is not mixed into the others.
    across: Option<Box<Reflections>>,
    singular: Option<Box<Singular>>,
    /// Room to work in.
    room: TaskMatrix,
}

/// What stands between the frame and the rows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Core {
    /// A triangle, as many rows as rank.
    #[default]
    Triangle,
    /// More rows than rank: a second set of reflections makes it a triangle.
    Across,
    /// The singular value decomposition.
    Singular,
}

impl Decomposition {
    /// The decomposition of `A`; rank relative to its own norm.
    pub fn new(A: &TaskMatrix) -> Self {
        Self::with_scale(A, A.norm())
    }

    /// The decomposition of `A`; rank relative to `scale`.
    ///
    /// A product like J_2 N, whose rows may be pure rounding, takes the norm of J_2.
    pub fn with_scale(A: &TaskMatrix, scale: f64) -> Self {
        let mut decomposition = Self::default();
        decomposition.decompose(A, 0, scale);
        decomposition
    }

    /// The decomposition of `A` by singular values; rank relative to `scale`.
    ///
    /// Paper: Eqs. (16), (17).
    pub fn singular(A: &TaskMatrix, scale: f64) -> Self {
        let mut decomposition = Self::default();
        decomposition.decompose_singular(A, 0, scale);
        decomposition
    }

    /// Becomes the decomposition of `A` from column `first` on; the frame leaves the coordinates before it alone.
    pub fn decompose(&mut self, A: &TaskMatrix, first: usize, scale: f64) {
        let cut = cut(scale);
        (self.rows, self.columns) = (A.nrows(), A.ncols());
        self.reflections.make(A, first, Order::LongestAbove(cut));
        self.rank = self.reflections.count();
        self.core = Core::Triangle;
        let certain = (self.is_full() || self.reflections.left_over <= cut) && self.certainly_above(cut);
        if !certain {
            self.decompose_singular(A, first, scale);
        } else if self.rank < self.rows {
            self.core = Core::Across;
            self.room.columns_in_order(&self.reflections.R, &self.reflections.order);
            self.across.get_or_insert_default().make(&self.room, 0, Order::Given);
        }
    }

    /// The same, by singular values.
    pub fn decompose_singular(&mut self, A: &TaskMatrix, first: usize, scale: f64) {
        let cut = cut(scale);
        (self.rows, self.columns) = (A.nrows(), A.ncols());
        // A scale beyond the numbers leaves nothing above it.
        let zero = if cut.is_finite() { SMALLEST } else { cut };
        self.reflections.make(A, first, Order::LongestAbove(zero));
        let singular = self.singular.get_or_insert_default();
        singular.decompose(&self.reflections.R, self.rows.min(self.columns - first));
        self.rank = singular.values().iter().filter(|&&sigma| sigma > cut).count();
        self.core = Core::Singular;
    }

    /// Number of singular values that count as non-zero.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// The first coordinate of the frame that A does not see.
    fn open(&self) -> usize {
        self.reflections.first + self.rank
    }

    /// Whether all min(m, n) singular values count as non-zero.
    pub fn is_full(&self) -> bool {
        self.rank == self.rows.min(self.columns - self.reflections.first)
    }

    /// Whether all min(m, n) singular values are above `bound` for certain; `false` says nothing.
    pub fn exceeds(&mut self, bound: f64) -> bool {
        self.is_full() && self.certainly_above(bound)
    }

    /// Whether the first r singular values are above `bound` for certain.
    fn certainly_above(&mut self, bound: f64) -> bool {
        let Some(last) = self.rank.checked_sub(1) else { return true };
        if let Some(singular) = self.by_values() {
            return singular.values()[last] > bound;
        }
        // Of a triangle of the longest rows first, σ_r ≥ 2^(1 − r) |R_rr| (Faddeev, Kublanovskaya and Faddeeva), and of
        // any, σ_r ≥ 1/‖R⁻¹‖.
        let corner = self.reflections.R[last][self.reflections.order[last]].abs();
        corner * (0..last).fold(1.0, |halves, _| 0.5 * halves) > bound || self.inverse_below(1.0 / bound)
    }

    /// Whether the leading triangle has an inverse shorter than `size`.
    fn inverse_below(&mut self, size: f64) -> bool {
        self.reflections.write_triangle(&mut self.room);
        triangle::invert(&mut self.room);
        self.room.norm() < size
    }

    /// The singular value decomposition of the core, where that is what it is.
    fn by_values(&self) -> Option<&Singular> {
        self.singular.as_deref().filter(|_| self.core == Core::Singular)
    }

    /// All min(m, n) singular values, largest first; of a decomposition by singular values alone, else empty.
    pub fn singular_values(&self) -> &[f64] {
        self.by_values().map_or(&[], Singular::values)
    }

    /// σ_min, the min(m, n)-th singular value, of a decomposition by singular values.
    pub fn smallest(&self) -> f64 {
        self.singular_values().last().copied().unwrap_or(0.0)
    }

    /// x ← Vᵀ x: into the frame.
    pub fn to_frame(&self, x: &mut TaskVector) {
        self.reflections.turn(x.lanes_mut());
        self.turn_core(x);
    }

    /// The rows of `B` in the frame, B V.
    pub fn rows_to_frame(&self, B: &mut TaskMatrix) {
        self.reflections.turn(B.rows_from_mut(0));
        (0..B.nrows()).filter(|_| self.core == Core::Singular).for_each(|i| self.turn_core(&mut B[i]));
    }

    fn turn_core(&self, x: &mut [f64]) {
        if let Some(singular) = self.by_values() {
            let first = self.reflections.first;
            singular.turn(&mut x[first..first + self.reflections.count()]);
        }
    }

    /// x ← V x: out of the frame.
    pub fn from_frame(&self, x: &mut TaskVector) {
        if let Some(singular) = self.by_values() {
            let first = self.reflections.first;
            singular.turn_back(&mut x[first..first + self.reflections.count()]);
        }
        self.reflections.turn_back(x.lanes_mut());
    }

    /// Vᵀ A⁺ b: the shortest x that minimises ‖A x − b‖, in the frame.
    pub fn solve_in_frame(&self, b: &TaskVector) -> TaskVector {
        match (self.core, self.across.as_deref()) {
            (Core::Triangle, _) => self.reflections.solve_transposed(b),
            (Core::Across, Some(across)) => {
                let c = self.enter_core(b, across);
                let mut x = TaskVector::zeros(self.columns);
                x[self.reflections.first..][..self.rank].copy_from_slice(&across.solve(&c));
                x
            }
            _ => self.damped_in_frame(b, 0.0),
        }
    }

    /// Vᵀ Aᵀ(A Aᵀ + λ² I)⁻¹ b, for a decomposition by singular values: the x that minimises ‖A x − b‖² + λ² ‖x‖², in the
    /// frame.
    ///
    /// Paper: Eqs. (15), (18).
    pub fn damped_in_frame(&self, b: &TaskVector, lambda: f64) -> TaskVector {
        let mut x = TaskVector::zeros(self.columns);
        let first = self.reflections.first;
        let Some(singular) = self.by_values() else { return x };
        for (i, &sigma) in singular.values().iter().enumerate().take(self.rank) {
            x[first + i] = sigma / (sigma * sigma + lambda * lambda) * dot(singular.left(i), b.lanes());
        }
        x
    }

    /// A⁺ b: the shortest x that minimises ‖A x − b‖.
    pub fn solve(&self, b: &TaskVector) -> TaskVector {
        let mut x = self.solve_in_frame(b);
        self.from_frame(&mut x);
        x
    }

    /// A A⁺ b − A x for the damped x of [`Self::damped_in_frame`]: what damping gives up of the reachable part of b;
    /// nothing but for a decomposition by singular values.
    pub fn damping_loss(&self, b: &TaskVector, lambda: f64) -> TaskVector {
        let mut loss = TaskVector::zeros(self.rows);
        let Some(singular) = self.by_values() else { return loss };
        for (i, &sigma) in singular.values().iter().enumerate().take(self.rank) {
            let share = lambda * lambda / (sigma * sigma + lambda * lambda);
            let u = singular.left(i);
            add_scaled(loss.lanes_mut(), share * dot(u, b.lanes()), u);
        }
        loss
    }

    /// The coordinates of b, m, of which A reaches the first r.
    fn enter_core(&self, b: &TaskVector, across: &Reflections) -> TaskVector {
        let mut c = TaskVector::zeros(self.rows);
        c.iter_mut().zip(&self.reflections.order).for_each(|(entry, &row)| *entry = b[row]);
        across.turn(c.lanes_mut());
        c
    }

    /// Overwrites b, m, with what has these coordinates.
    fn leave_core(&self, mut c: TaskVector, across: &Reflections, b: &mut [f64]) {
        across.turn_back(c.lanes_mut());
        self.reflections.order.iter().zip(c.iter()).for_each(|(&row, entry)| b[row] = *entry);
    }

    /// B ← B N with an orthonormal basis N of {x : A x = 0}, n × (n − rank).
    pub fn to_null_space(&self, B: &mut TaskMatrix) {
        self.rows_to_frame(B);
        B.keep_columns_from(self.open());
    }

    /// N, an orthonormal basis of {x : A x = 0}, n × (n − rank).
    pub fn null_space(&self) -> TaskMatrix {
        let mut N = TaskMatrix::identity(self.columns);
        self.to_null_space(&mut N);
        N
    }

    /// b without its part in {A x}: what no x reaches.
    pub fn unreachable(&self, b: &TaskVector) -> TaskVector {
        let mut left = b.clone();
        match (self.core, self.across.as_deref(), self.by_values()) {
            (Core::Across, Some(across), _) => {
                let mut c = self.enter_core(b, across);
                c[..self.rank].fill(0.0);
                self.leave_core(c, across, &mut left);
            }
            (Core::Singular, _, Some(singular)) => {
                for i in 0..self.rank {
                    let u = singular.left(i);
                    add_scaled(left.lanes_mut(), -dot(u, b.lanes()), u);
                }
            }
            _ => left.fill(0.0),
        }
        left
    }

    /// An orthonormal basis of {A x} as rows, rank × m.
    pub fn range(&self) -> TaskMatrix {
        let mut basis = TaskMatrix::zeros(self.rank, self.rows);
        for i in 0..self.rank {
            match (self.core, self.across.as_deref(), self.by_values()) {
                (Core::Across, Some(across), _) => {
                    self.leave_core(TaskVector::unit(self.rows, i), across, &mut basis[i]);
                }
                (Core::Singular, _, Some(singular)) => basis.row_mut(i).copy_from_slice(singular.left(i)),
                _ => basis[i][i] = 1.0,
            }
        }
        basis
    }

    /// Becomes the lower triangle whose rows are those of A in this frame, in the order in which they were taken; whether
    /// that is what this decomposition has.
    pub(super) fn write_triangle(&self, L: &mut TaskMatrix) -> bool {
        let has = self.core == Core::Triangle;
        if has {
            self.reflections.write_triangle(L);
        }
        has
    }
}

fn cut(scale: f64) -> f64 {
    (RANK_TOLERANCE * scale).max(SMALLEST)
}
