//! What the levels so far leave open.
#![allow(non_snake_case)]

use super::level::{Level, LevelSolution};
use super::objectives::Objective;
use crate::limits::VelocityBox;
use crate::linalg::{Matrix, Svd, SvdError, Vector, stack};

/// Relative size of a multiplier that proves a limit active for good.
///
/// Too large a value only leaves an inequality where an equality would do; too small a one would take rounding for proof.
const PROOF: f64 = 1e-7;

/// {base + Z z : lo ≤ base + Z z ≤ hi}, with `base` in the box and the columns of Z orthonormal.
pub struct FeasibleSet<'a> {
    limits: &'a VelocityBox,
    base: Vector,
    Z: Matrix,
    /// Joints whose bounds coincide.
    pinned: Vec<usize>,
    /// Joints whose velocity is decided, by their bounds or by a level.
    fixed: Vec<bool>,
}

impl<'a> FeasibleSet<'a> {
    /// The whole box, based at its point nearest to `start`; joints whose bounds coincide are fixed.
    pub fn new(limits: &'a VelocityBox, start: &Vector) -> Self {
        let n = start.len();
        let fixed: Vec<bool> = (0..n).map(|i| limits.lower()[i] == limits.upper()[i]).collect();
        let (pinned, free): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| fixed[i]);
        let Z = Matrix::identity(n, n).select_columns(&free);
        Self { limits, base: limits.clamp(start), Z, pinned, fixed }
    }

    /// A point of the set; after a level, that level's solution.
    pub fn base(&self) -> &Vector {
        &self.base
    }

    /// Signed multipliers (n) of the joints whose bounds coincide, at `base` as the solution of the first level.
    pub fn multipliers_of_pinned(&self, first: &Objective) -> Vector {
        let gradient = first.A.transpose() * (&first.A * &self.base - &first.b);
        let mut multipliers = Vector::zeros(self.base.len());
        for &joint in &self.pinned {
            multipliers[joint] = -gradient[joint];
        }
        multipliers
    }

    /// The objective over what is open, as a problem in z.
    pub fn reduce(&self, objective: &Objective) -> Level {
        Level {
            C: &objective.A * &self.Z,
            d: &objective.b - &objective.A * &self.base,
            G: self.Z.clone(),
            lower: self.limits.lower() - &self.base,
            upper: self.limits.upper() - &self.base,
            bounded: self.fixed.iter().map(|fixed| !fixed).collect(),
            gradient_scale: objective.A.norm() * (objective.A.norm() * self.base.norm()).max(objective.b.norm()),
        }
    }

    /// Moves to the solution and closes what it decides.
    pub fn keep(&mut self, objective: &Objective, solution: &LevelSolution) -> Result<(), SvdError> {
        self.base = self.limits.clamp(&(&self.base + &self.Z * &solution.z));
        let mut decided = objective.A.rows(0, objective.kept) * &self.Z;
        // One common scale for task rows and rows of Z, so that one rank decision serves both.
        let scale = objective.A.rows(0, objective.kept).norm();
        if scale > 0.0 {
            decided /= scale;
        }
        if objective.is_exact() {
            for joint in solution.proved_active(PROOF) {
                self.fixed[joint] = true;
                decided = stack(&decided, &self.Z.rows(joint, 1).into_owned());
            }
        }
        self.Z *= Svd::with_scale(&decided, 1.0)?.null_space();
        for joint in (0..self.fixed.len()).filter(|&joint| self.fixed[joint]) {
            self.Z.row_mut(joint).fill(0.0);
        }
        Ok(())
    }
}
