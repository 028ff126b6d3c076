//! What the levels so far leave open.
#![allow(non_snake_case)]

use super::active_set::Side;
use super::constraints::Constraints;
use super::level::{Level, LevelSolution, LevelSolver};
use super::objectives::Objective;
use super::relaxation::least_excess;
use crate::linalg::{Decomposition, RANK_TOLERANCE, TaskMatrix, TaskVector};

/// Relative gain by moving a limit away that proves it active for good.
///
/// Too large a value only leaves an inequality where an equality would do; too small a one would take rounding for proof.
const PROOF: f64 = 1e-7;

/// {base + Z z : lo ≤ rows · (base + Z z) ≤ hi}, with `base` inside and the columns of Z orthonormal.
#[derive(Clone, Default)]
pub struct FeasibleSet {
    /// lo, hi and the rows; to be set before [`Self::open_all`].
    pub constraints: Constraints,
    base: TaskVector,
    Z: TaskMatrix,
    /// Joints whose bounds coincide.
    pinned: Vec<usize>,
    /// Rows whose value is decided, by their bounds or by a level.
    fixed: Vec<bool>,
    /// Room to work in.
    room: TaskMatrix,
    decomposition: Decomposition,
}

impl FeasibleSet {
    /// Becomes all that the constraints allow, based at the slowest point of the box or, where inequalities forbid it, near
    /// it; joints whose bounds coincide are fixed. Inequalities that the box contradicts are relaxed until they hold.
    ///
    /// Not at what lower tasks ask: however much that is, task 1 must not lose digits to it.
    pub fn open_all(&mut self) {
        let Self { constraints, base, Z, pinned, fixed, .. } = self;
        let n = constraints.joints();
        let is_pinned = |row: usize| row < n && constraints.lower()[row] >= constraints.upper()[row];
        fixed.clear();
        fixed.extend((0..constraints.count()).map(is_pinned));
        pinned.clear();
        pinned.extend((0..n).filter(|&i| fixed[i]));
        Z.reset(n, n - pinned.len());
        (0..n).filter(|&i| !fixed[i]).enumerate().for_each(|(j, i)| Z[i][j] = 1.0);
        *base = least_excess(constraints, constraints.clamp_joints(TaskVector::zeros(n)), Z);
        constraints.admit(base);
        self.fix_decided_rows();
    }

    /// A point of the set; after a level, that level's solution.
    pub fn base(&self) -> &TaskVector {
        &self.base
    }

    /// Signed multipliers (per row) of the joints whose bounds coincide, at `base` as the solution of the first level.
    pub fn multipliers_of_pinned(&self, first: &Objective) -> TaskVector {
        let mut multipliers = TaskVector::zeros(self.constraints.count());
        if self.pinned.is_empty() {
            return multipliers;
        }
        let gradient = first.A.transposed_times(&(&(&first.A * &self.base) - &first.b));
        for &joint in &self.pinned {
            multipliers[joint] = -gradient[joint];
        }
        multipliers
    }

    /// Writes the objective over what is open, as a problem in z.
    pub fn reduce(&self, objective: &Objective, level: &mut Level) {
        let Self { constraints, base, Z, fixed, .. } = self;
        let values = constraints.values(base);
        level.C.become_product(&objective.A, Z);
        level.C.without_rounding(0, &objective.A);
        level.d = &objective.b - &(&objective.A * base);
        constraints.write_rows_of(Z, &mut level.G);
        // A plane that base exceeds by rounding has no room, rather than less than none.
        level.lower = (constraints.lower() - &values).map(|room| room.min(0.0));
        level.upper = (constraints.upper() - &values).map(|room| room.max(0.0));
        level.bounded.clear();
        level.bounded.extend(fixed.iter().map(|fixed| !fixed));
        level.speed = base.norm();
        level.scale = objective.norm;
        level.base_size = objective.norm * level.speed + objective.b.norm();
    }

    /// Moves to the solution of the level that [`Self::reduce`] gave, found by `solver`, and closes what it decides.
    pub fn keep(&mut self, objective: &Objective, level: &Level, solution: &LevelSolution, solver: &LevelSolver) {
        self.base += &(&self.Z * &solution.z);
        self.base = self.constraints.clamp_joints(std::mem::take(&mut self.base));
        for &(row, side) in solution.active_set.iter().filter(|(row, _)| *row < self.constraints.joints()) {
            self.base[row] = match side {
                Side::Lower => self.constraints.lower()[row],
                Side::Upper => self.constraints.upper()[row],
            };
        }
        if !(objective.is_exact() && solver.close(solution, PROOF, &mut self.Z)) {
            self.close(objective, level, solution);
        }
        self.fix_decided_rows();
    }

    /// Closes limits that are proved active, one by one, and then what the level keeps.
    fn close(&mut self, objective: &Objective, level: &Level, solution: &LevelSolution) {
        let Self { constraints, Z, room, decomposition, .. } = self;
        let mut same = true;
        for row in solution.proved_active(PROOF).filter(|_| objective.is_exact()) {
            room.reset(0, Z.ncols());
            room.push_row(&constraints.row_of(row, Z));
            decomposition.decompose(room, 0, 1.0);
            decomposition.to_null_space(Z);
            same = false;
        }
        if same {
            room.copy_from(&level.C);
        } else {
            room.become_product(&objective.A, Z);
        }
        room.truncate(objective.kept);
        decomposition.decompose(room, 0, objective.norm_kept);
        decomposition.to_null_space(Z);
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
        fixed.extend([false; 2]);
        let base = self.base.concatenated(&TaskVector::zeros(1));
        Self { constraints, base, Z, fixed, ..self.clone() }
    }

    /// Takes over what a set with a decided s leaves open of the joints; gives s.
    pub fn take_over(&mut self, scaled: &Self) -> f64 {
        let n = self.base.len();
        self.base = TaskVector::from_slice(&scaled.base[..n]);
        self.Z = scaled.Z.first_rows(n);
        self.fixed.copy_from_slice(&scaled.fixed[..self.constraints.count()]);
        scaled.base[n]
    }

    /// A row that Z moves by rounding alone is fixed, for good: its limits would be constraints without content.
    ///
    /// Joints last: their bounds are to hold to the last bit.
    fn fix_decided_rows(&mut self) {
        let Self { constraints, Z, fixed, room, .. } = self;
        constraints.write_rows_of(Z, room);
        for row in (0..fixed.len()).rev() {
            let size = room.row_norm(row);
            fixed[row] |= size <= RANK_TOLERANCE;
            if fixed[row] && size > 0.0 {
                Z.subtract_outer(&constraints.row(row), &room.row_vector(row));
            }
        }
    }
}
