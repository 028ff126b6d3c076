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

/// Relative size up to which a multiplier is rounding.
const NO_MULTIPLIER: f64 = 1e-11;

/// {base + Z z : lo ≤ base + Z z ≤ hi}, with `base` in the box and the columns of Z orthonormal.
pub struct FeasibleSet<'a> {
    limits: &'a VelocityBox,
    base: Vector,
    Z: Matrix,
    /// Joints whose bounds coincide.
    pinned: Vec<usize>,
    /// What Z would be if those joints were free as long as no level proves that it presses against them; empty without
    /// such joints.
    unpinned: Matrix,
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
        let unpinned = if pinned.is_empty() { Matrix::zeros(n, 0) } else { Matrix::identity(n, n) };
        Self { limits, base: limits.clamp(start), Z, pinned, unpinned, fixed }
    }

    /// A point of the set; after a level, that level's solution.
    pub fn base(&self) -> &Vector {
        &self.base
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

    /// Moves to the solution and closes what it decides; returns the signed multipliers (n) of all limits.
    pub fn keep(&mut self, objective: &Objective, solution: &LevelSolution) -> Result<Vector, SvdError> {
        self.base = self.limits.clamp(&(&self.base + &self.Z * &solution.z));
        let multipliers = self.multipliers(objective, solution)?;
        let proved: Vec<usize> =
            if objective.is_exact() { solution.proved_active(PROOF).collect() } else { Vec::new() };
        for &joint in &proved {
            self.fixed[joint] = true;
        }
        self.Z = closed(&self.Z, objective, &proved)?;
        for joint in (0..self.fixed.len()).filter(|&joint| self.fixed[joint]) {
            self.Z.row_mut(joint).fill(0.0);
        }
        if self.unpinned.ncols() > 0 {
            let least = PROOF * solution.gradient_scale;
            let pressed = self.pinned.iter().copied().filter(|&joint| multipliers[joint].abs() > least);
            let decided: Vec<usize> = proved.iter().copied().chain(pressed).collect();
            self.unpinned = closed(&self.unpinned, objective, &decided)?;
        }
        Ok(multipliers)
    }

    /// Multipliers of the level's bounds and, in the same sense, of the joints whose bounds coincide.
    ///
    /// The latter are no unknowns of the level: with U = `unpinned`, E the rows of those joints and m the multipliers of
    /// the others, theirs are the p of Uᵀ(Aᵀ(A q̇ − b) + m + Eᵀp) = 0.
    fn multipliers(&self, objective: &Objective, solution: &LevelSolution) -> Result<Vector, SvdError> {
        let mut multipliers = solution.multipliers.clone();
        if self.unpinned.ncols() == 0 {
            return Ok(multipliers);
        }
        let gradient = objective.A.transpose() * (&objective.A * &self.base - &objective.b) + &multipliers;
        let E_U = self.unpinned.select_rows(&self.pinned);
        let p = Svd::with_scale(&E_U.transpose(), 1.0)?.solve(&-(self.unpinned.transpose() * gradient));
        for (&joint, &value) in self.pinned.iter().zip(p.iter()) {
            if value.abs() > NO_MULTIPLIER * solution.gradient_scale {
                multipliers[joint] = value;
            }
        }
        Ok(multipliers)
    }
}

/// What is left of a basis when the kept rows of the objective and some joints must not change.
fn closed(basis: &Matrix, objective: &Objective, joints: &[usize]) -> Result<Matrix, SvdError> {
    let kept = objective.A.rows(0, objective.kept);
    // One common scale for task rows and rows of the basis, so that one rank decision serves both.
    let scale = kept.norm();
    let mut decided = kept * basis;
    if scale > 0.0 {
        decided /= scale;
    }
    let decided = stack(&decided, &basis.select_rows(joints));
    Ok(basis * Svd::with_scale(&decided, 1.0)?.null_space())
}
