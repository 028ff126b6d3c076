//! What the levels so far leave open.
#![allow(non_snake_case)]

use smallvec::SmallVec;

use super::active_set::Side;
use super::constraints::Constraints;
use super::level::{Level, LevelSolution};
use super::objectives::Objective;
use super::relaxation::least_excess;
use crate::linalg::{Decomposition, RANK_TOLERANCE, TaskMatrix, TaskVector};

/// Relative gain by moving a limit away that proves it active for good.
///
/// Too large a value only leaves an inequality where an equality would do; too small a one would take rounding for proof.
const PROOF: f64 = 1e-7;

/// {base + Z z : lo ≤ rows · (base + Z z) ≤ hi}, with `base` inside and the columns of Z orthonormal.
#[derive(Clone)]
pub struct FeasibleSet {
    constraints: Constraints,
    base: TaskVector,
    Z: TaskMatrix,
    /// Joints whose bounds coincide.
    pinned: SmallVec<[usize; 16]>,
    /// Rows whose value is decided, by their bounds or by a level.
    fixed: SmallVec<[bool; 16]>,
}

impl FeasibleSet {
    /// All that the constraints allow, based at the slowest point of the box or, where inequalities forbid it, near it;
    /// joints whose bounds coincide are fixed. Inequalities that the box contradicts are relaxed until they hold.
    ///
    /// Not at what lower tasks ask: however much that is, task 1 must not lose digits to it.
    pub fn new(mut constraints: Constraints) -> Self {
        let n = constraints.joints();
        let is_pinned = |row: usize| row < n && constraints.lower()[row] >= constraints.upper()[row];
        let fixed: SmallVec<[bool; 16]> = (0..constraints.count()).map(is_pinned).collect();
        let pinned: SmallVec<[usize; 16]> = (0..n).filter(|&i| fixed[i]).collect();
        let free: SmallVec<[usize; 16]> = (0..n).filter(|&i| !fixed[i]).collect();
        let Z = TaskMatrix::from_fn(n, free.len(), |i, j| f64::from(u8::from(i == free[j])));
        let base = least_excess(&constraints, constraints.clamp_joints(TaskVector::zeros(n)), &Z);
        constraints.admit(&base);
        let mut set = Self { constraints, base, Z, pinned, fixed };
        set.fix_decided_rows();
        set
    }

    /// A point of the set; after a level, that level's solution.
    pub fn base(&self) -> &TaskVector {
        &self.base
    }

    /// Signed multipliers (per row) of the joints whose bounds coincide, at `base` as the solution of the first level.
    pub fn multipliers_of_pinned(&self, first: &Objective) -> TaskVector {
        let gradient = first.A.transposed_times(&(&(&first.A * &self.base) - &first.b));
        let mut multipliers = TaskVector::zeros(self.constraints.count());
        for &joint in &self.pinned {
            multipliers[joint] = -gradient[joint];
        }
        multipliers
    }

    /// The objective over what is open, as a problem in z.
    pub fn reduce(&self, objective: &Objective) -> Level {
        let values = self.constraints.values(&self.base);
        let mut C = &objective.A * &self.Z;
        C.without_rounding(0, &objective.A);
        Level {
            C,
            d: &objective.b - &(&objective.A * &self.base),
            G: self.constraints.rows_of(&self.Z),
            // A plane that base exceeds by rounding has no room, rather than less than none.
            lower: (self.constraints.lower() - &values).map(|room| room.min(0.0)),
            upper: (self.constraints.upper() - &values).map(|room| room.max(0.0)),
            bounded: self.fixed.iter().map(|fixed| !fixed).collect(),
            speed: self.base.norm(),
            scale: objective.norm,
            base_size: objective.norm * self.base.norm() + objective.b.norm(),
        }
    }

    /// Moves to the solution and closes what it decides.
    pub fn keep(&mut self, objective: &Objective, solution: &LevelSolution) {
        self.base = self.constraints.clamp_joints(&self.base + &(&self.Z * &solution.z));
        for &(row, side) in solution.active_set.iter().filter(|(row, _)| *row < self.constraints.joints()) {
            self.base[row] = match side {
                Side::Lower => self.constraints.lower()[row],
                Side::Upper => self.constraints.upper()[row],
            };
        }
        if objective.is_exact() {
            for row in solution.proved_active(PROOF) {
                let mut rows = TaskMatrix::default();
                rows.push_row(&self.constraints.row_of(row, &self.Z));
                self.close(&rows, 1.0);
            }
        }
        let kept = objective.A.first_rows(objective.kept);
        self.close(&(&kept * &self.Z), kept.norm());
        self.fix_decided_rows();
    }

    /// The set with one more unknown s, 0 ≤ s ≤ 1, at s = 0.
    pub fn with_scale(&self) -> Self {
        let (n, p) = (self.Z.nrows(), self.Z.ncols());
        let mut constraints = self.constraints.with_one_more_unknown();
        let s = TaskVector::from_fn(n + 1, |i| f64::from(u8::from(i == n)));
        constraints.push(&-&s, 0.0);
        constraints.push(&s, 1.0);
        let Z = TaskMatrix::from_fn(n + 1, p + 1, |i, j| match (i < n, j < p) {
            (true, true) => self.Z[i][j],
            (false, false) => 1.0,
            _ => 0.0,
        });
        let mut fixed = self.fixed.clone();
        fixed.extend([false, false]);
        let base = self.base.concatenated(&TaskVector::zeros(1));
        Self { constraints, base, Z, pinned: self.pinned.clone(), fixed }
    }

    /// Takes over what a set with a decided s leaves open of the joints; gives s.
    pub fn take_over(&mut self, scaled: &Self) -> f64 {
        let n = self.base.len();
        self.base = TaskVector::from_slice(&scaled.base[..n]);
        self.Z = scaled.Z.first_rows(n);
        self.fixed = SmallVec::from_slice(&scaled.fixed[..self.constraints.count()]);
        scaled.base[n]
    }

    /// Removes from Z what would change `rows` · z.
    fn close(&mut self, rows: &TaskMatrix, scale: f64) {
        self.Z = Decomposition::with_scale(rows, scale).times_null_space(&self.Z);
    }

    /// A row that Z moves by rounding alone is fixed, for good: its limits would be constraints without content.
    ///
    /// Joints last: their bounds are to hold to the last bit.
    fn fix_decided_rows(&mut self) {
        let rows = self.constraints.rows_of(&self.Z);
        for row in (0..self.fixed.len()).rev().filter(|&row| rows.row_norm(row) <= RANK_TOLERANCE) {
            self.fixed[row] = true;
            let moved = rows.row_vector(row);
            let direction = self.constraints.row(row);
            self.Z.subtract_outer(&direction, &moved);
        }
    }
}
