//! What the levels so far leave open.
#![allow(non_snake_case)]

use super::active_set::Side;
use super::level::{Level, LevelSolution};
use super::objectives::Objective;
use crate::limits::VelocityBox;
use crate::linalg::{Matrix, RANK_TOLERANCE, Svd, SvdError, Vector};

/// Relative gain by moving a limit away that proves it active for good.
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
    /// The whole box, based at its slowest point; joints whose bounds coincide are fixed.
    ///
    /// Not at what lower tasks ask: however much that is, task 1 must not lose digits to it.
    pub fn new(limits: &'a VelocityBox) -> Self {
        let n = limits.joint_count();
        let fixed: Vec<bool> = (0..n).map(|i| limits.lower()[i] >= limits.upper()[i]).collect();
        let (pinned, free): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| fixed[i]);
        let Z = Matrix::identity(n, n).select_columns(&free);
        Self { limits, base: limits.clamp(&Vector::zeros(n)), Z, pinned, fixed }
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
            speed: self.base.norm(),
            scale: objective.A.norm(),
            base_size: objective.A.norm() * self.base.norm() + objective.b.norm(),
        }
    }

    /// Moves to the solution and closes what it decides.
    pub fn keep(&mut self, objective: &Objective, solution: &LevelSolution) -> Result<(), SvdError> {
        self.base = self.limits.clamp(&(&self.base + &self.Z * &solution.z));
        for &(joint, side) in &solution.active_set {
            self.base[joint] = match side {
                Side::Lower => self.limits.lower()[joint],
                Side::Upper => self.limits.upper()[joint],
            };
        }
        if objective.is_exact() {
            for joint in solution.proved_active(PROOF) {
                self.close(&self.Z.rows(joint, 1).into_owned(), 1.0)?;
            }
        }
        let kept = objective.A.rows(0, objective.kept).into_owned();
        self.close(&(&kept * &self.Z), kept.norm())?;
        self.fix_decided_joints();
        Ok(())
    }

    /// Removes from Z what would change `rows` · z.
    fn close(&mut self, rows: &Matrix, scale: f64) -> Result<(), SvdError> {
        self.Z *= Svd::with_scale(rows, scale)?.null_space();
        Ok(())
    }

    /// A joint that Z moves by rounding alone is fixed: its limits would be constraints without content.
    fn fix_decided_joints(&mut self) {
        for joint in 0..self.fixed.len() {
            if self.Z.row(joint).norm() <= RANK_TOLERANCE {
                self.fixed[joint] = true;
                self.Z.row_mut(joint).fill(0.0);
            }
        }
    }
}
