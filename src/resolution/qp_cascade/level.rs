//! One level in reduced form, and the ways to its solution.
#![allow(non_snake_case)]

use super::active_set::{self, ActiveSet, Candidate, Side};
use super::clarabel_level;
use crate::linalg::{Matrix, SvdError, Vector};
use crate::resolution::resolve::Path;

/// min ‖C z − d‖² s.t. lower ≤ G z ≤ upper for the bounded joints; z = 0 is feasible.
pub struct Level {
    /// C, m × p.
    pub C: Matrix,
    /// d, m.
    pub d: Vector,
    /// G, n × p: joint velocities per unit of z.
    pub G: Matrix,
    /// Room below, n, ≤ 0.
    pub lower: Vector,
    /// Room above, n, ≥ 0.
    pub upper: Vector,
    /// Whether the joint's bounds are constraints of this level.
    pub bounded: Vec<bool>,
    /// Size that a gradient of this level can have by scale alone.
    pub gradient_scale: f64,
}

impl Level {
    /// p, the number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.C.ncols()
    }

    /// The finite bounds: joint, side, right-hand side.
    pub fn constraints(&self) -> impl Iterator<Item = (usize, Side, f64)> {
        (0..self.G.nrows())
            .filter(|&joint| self.bounded[joint])
            .flat_map(|joint| [(joint, Side::Lower, self.lower[joint]), (joint, Side::Upper, self.upper[joint])])
            .filter(|(_, _, bound)| bound.is_finite())
    }
}

/// The solution of a level.
pub struct LevelSolution {
    /// z, p.
    pub z: Vector,
    /// Signed multipliers of the limits, n; positive at the upper, negative at the lower bound.
    pub multipliers: Vector,
    /// The limits that are active.
    pub active_set: ActiveSet,
    /// Scale of the level's gradient, against which multipliers are small or large.
    pub gradient_scale: f64,
    /// Relative residual of the optimality conditions.
    pub kkt_residual: f64,
    /// The way that led here.
    pub path: Path,
    /// Iterations of Clarabel.
    pub iterations: u32,
}

impl LevelSolution {
    fn new(level: &Level, candidate: Candidate, path: Path, iterations: u32) -> Self {
        Self {
            z: candidate.z,
            multipliers: candidate.multipliers,
            active_set: candidate.active_set,
            kkt_residual: candidate.kkt_residual,
            gradient_scale: level.gradient_scale,
            path,
            iterations,
        }
    }

    /// Joints whose multiplier is, relative to the gradient, larger than `proof`.
    pub fn proved_active(&self, proof: f64) -> impl Iterator<Item = usize> {
        let least = proof * self.gradient_scale;
        self.multipliers.iter().enumerate().filter(move |(_, m)| m.abs() > least).map(|(joint, _)| joint)
    }
}

/// Solves the level: by the guessed active set if its optimality conditions hold, otherwise through Clarabel.
///
/// Clarabel's answer is worth its active set: the least-squares problem on that set is solved exactly. Should the set
/// be wrong, which happens at degenerate corners, an active-set iteration from z = 0 corrects it.
pub fn solve(level: &Level, guess: Option<&ActiveSet>) -> Result<LevelSolution, SvdError> {
    if level.unknowns() == 0 {
        return Ok(LevelSolution::new(level, Candidate::nothing_open(level), Path::ActiveSet, 0));
    }
    if let Some(guess) = guess {
        let candidate = active_set::polish(level, &Vector::zeros(level.unknowns()), guess)?;
        if candidate.is_optimal() {
            return Ok(LevelSolution::new(level, candidate, Path::ActiveSet, 0));
        }
    }
    let approximate = clarabel_level::solve(level);
    let polished = active_set::polish(level, &approximate.z, &approximate.active_set)?;
    let candidate = if polished.is_optimal() { polished } else { active_set::iterate(level)? };
    Ok(LevelSolution::new(level, candidate, Path::Qp, approximate.iterations))
}
