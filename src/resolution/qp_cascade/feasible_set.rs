//! What the levels so far leave open.
#![allow(non_snake_case)]

use super::active_set::Side;
use super::constraints::Constraints;
use super::level::{Level, LevelSolution};
use super::objectives::Objective;
use super::relaxation::least_excess;
use crate::linalg::{Matrix, RANK_TOLERANCE, Svd, SvdError, Vector};

/// Relative gain by moving a limit away that proves it active for good.
///
/// Too large a value only leaves an inequality where an equality would do; too small a one would take rounding for proof.
const PROOF: f64 = 1e-7;

/// {base + Z z : lo ≤ rows · (base + Z z) ≤ hi}, with `base` inside and the columns of Z orthonormal.
#[derive(Clone)]
pub struct FeasibleSet {
    constraints: Constraints,
    base: Vector,
    Z: Matrix,
    /// Joints whose bounds coincide.
    pinned: Vec<usize>,
    /// Rows whose value is decided, by their bounds or by a level.
    fixed: Vec<bool>,
}

impl FeasibleSet {
    /// All that the constraints allow, based at the slowest point of the box or, where inequalities forbid it, near it;
    /// joints whose bounds coincide are fixed. Inequalities that the box contradicts are relaxed until they hold.
    ///
    /// Not at what lower tasks ask: however much that is, task 1 must not lose digits to it.
    pub fn new(mut constraints: Constraints) -> Result<Self, SvdError> {
        let n = constraints.joints();
        let is_pinned = |row: usize| row < n && constraints.lower()[row] >= constraints.upper()[row];
        let fixed: Vec<bool> = (0..constraints.count()).map(is_pinned).collect();
        let (pinned, free): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| fixed[i]);
        let Z = Matrix::identity(n, n).select_columns(&free);
        let base = least_excess(&constraints, &constraints.clamp_joints(&Vector::zeros(n)), &Z)?;
        constraints.admit(&base);
        let mut set = Self { constraints, base, Z, pinned, fixed };
        set.fix_decided_rows();
        Ok(set)
    }

    /// A point of the set; after a level, that level's solution.
    pub fn base(&self) -> &Vector {
        &self.base
    }

    /// Signed multipliers (per row) of the joints whose bounds coincide, at `base` as the solution of the first level.
    pub fn multipliers_of_pinned(&self, first: &Objective) -> Vector {
        let gradient = first.A.transpose() * (&first.A * &self.base - &first.b);
        let mut multipliers = Vector::zeros(self.constraints.count());
        for &joint in &self.pinned {
            multipliers[joint] = -gradient[joint];
        }
        multipliers
    }

    /// The objective over what is open, as a problem in z.
    pub fn reduce(&self, objective: &Objective) -> Level {
        let values = self.constraints.values(&self.base);
        Level {
            C: &objective.A * &self.Z,
            d: &objective.b - &objective.A * &self.base,
            G: self.constraints.rows_of(&self.Z),
            // A plane that base exceeds by rounding has no room, rather than less than none.
            lower: (self.constraints.lower() - &values).map(|room| room.min(0.0)),
            upper: (self.constraints.upper() - &values).map(|room| room.max(0.0)),
            bounded: self.fixed.iter().map(|fixed| !fixed).collect(),
            speed: self.base.norm(),
            scale: objective.A.norm(),
            base_size: objective.A.norm() * self.base.norm() + objective.b.norm(),
        }
    }

    /// Moves to the solution and closes what it decides.
    pub fn keep(&mut self, objective: &Objective, solution: &LevelSolution) -> Result<(), SvdError> {
        self.base = self.constraints.clamp_joints(&(&self.base + &self.Z * &solution.z));
        for &(row, side) in solution.active_set.iter().filter(|(row, _)| *row < self.constraints.joints()) {
            self.base[row] = match side {
                Side::Lower => self.constraints.lower()[row],
                Side::Upper => self.constraints.upper()[row],
            };
        }
        if objective.is_exact() {
            for row in solution.proved_active(PROOF) {
                let row = self.constraints.row(row).transpose() * &self.Z;
                self.close(&Matrix::from_row_slice(1, row.len(), row.as_slice()), 1.0)?;
            }
        }
        let kept = objective.A.rows(0, objective.kept).into_owned();
        self.close(&(&kept * &self.Z), kept.norm())?;
        self.fix_decided_rows();
        Ok(())
    }

    /// The set with one more unknown s, 0 ≤ s ≤ 1, at s = 0.
    pub fn with_scale(&self) -> Self {
        let (n, p) = self.Z.shape();
        let mut constraints = self.constraints.with_one_more_unknown();
        let s = Vector::from_fn(n + 1, |i, _| f64::from(u8::from(i == n)));
        constraints.push(&-&s, 0.0);
        constraints.push(&s, 1.0);
        let mut Z = self.Z.clone().resize(n + 1, p + 1, 0.0);
        Z[(n, p)] = 1.0;
        let mut fixed = self.fixed.clone();
        fixed.extend([false, false]);
        Self { constraints, base: self.base.clone().push(0.0), Z, pinned: self.pinned.clone(), fixed }
    }

    /// Takes over what a set with a decided s leaves open of the joints; gives s.
    pub fn take_over(&mut self, scaled: &Self) -> f64 {
        let n = self.base.len();
        self.base = scaled.base.rows(0, n).into_owned();
        self.Z = scaled.Z.rows(0, n).into_owned();
        self.fixed.copy_from_slice(&scaled.fixed[..self.constraints.count()]);
        scaled.base[n]
    }

    /// Removes from Z what would change `rows` · z.
    fn close(&mut self, rows: &Matrix, scale: f64) -> Result<(), SvdError> {
        self.Z *= Svd::with_scale(rows, scale)?.null_space();
        Ok(())
    }

    /// A row that Z moves by rounding alone is fixed, for good: its limits would be constraints without content.
    ///
    /// Joints last: their bounds are to hold to the last bit.
    fn fix_decided_rows(&mut self) {
        let rows = self.constraints.rows_of(&self.Z);
        for row in (0..self.fixed.len()).rev().filter(|&row| rows.row(row).norm() <= RANK_TOLERANCE) {
            self.fixed[row] = true;
            self.Z -= self.constraints.row(row) * rows.row(row);
        }
    }
}
