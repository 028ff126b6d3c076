//! One level in reduced form, and the ways to its solution.
#![allow(non_snake_case)]

use super::active_set::{self, ActiveSet, Candidate, Side};
use super::clarabel_level;
use crate::linalg::{Matrix, RANK_TOLERANCE, SvdError, Vector};
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
    /// ‖base‖, the speed from which z counts.
    pub speed: f64,
    /// ‖A‖ of the objective before reduction: C and products with it are rank-tested against this.
    pub scale: f64,
    /// ‖A‖ ‖base‖ + ‖b‖: the size of the terms whose difference is d.
    pub base_size: f64,
}

impl Level {
    /// p, the number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.C.ncols()
    }

    /// Size of the terms whose difference is C z − d; rounding and optimality are judged against it.
    pub fn size(&self, z: &Vector) -> f64 {
        self.base_size + self.scale * z.norm()
    }

    /// Whether nothing that is open changes the objective.
    fn is_decided(&self) -> bool {
        self.C.norm() <= RANK_TOLERANCE * self.scale
    }

    /// Room of a joint towards one side.
    pub fn bound(&self, joint: usize, side: Side) -> f64 {
        match side {
            Side::Lower => self.lower[joint],
            Side::Upper => self.upper[joint],
        }
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
    /// What moving each limit away would gain, n, relative to the size of the level; ≥ 0.
    relief: Vector,
    /// Relative residual of the optimality conditions.
    pub kkt_residual: f64,
    /// The way that led here.
    pub path: Path,
    /// Iterations of Clarabel.
    pub iterations: u32,
}

impl LevelSolution {
    fn new(candidate: Candidate, path: Path, iterations: u32) -> Self {
        Self {
            z: candidate.z,
            multipliers: candidate.multipliers,
            active_set: candidate.active_set,
            kkt_residual: candidate.kkt_residual,
            relief: candidate.relief,
            path,
            iterations,
        }
    }

    /// Joints whose limit, moved away, would gain more than `proof`.
    pub fn proved_active(&self, proof: f64) -> impl Iterator<Item = usize> {
        self.relief.iter().enumerate().filter(move |(_, relief)| **relief > proof).map(|(joint, _)| joint)
    }
}

/// Solves the level: by the guessed active set if its optimality conditions hold, otherwise through Clarabel.
///
/// Clarabel's answer is worth its active set: the least-squares problem on that set is solved exactly. Should the set
/// be wrong, which happens at degenerate corners, an active-set iteration from z = 0 corrects it.
pub fn solve(level: &Level, guess: Option<&ActiveSet>) -> Result<LevelSolution, SvdError> {
    if level.is_decided() {
        return Ok(LevelSolution::new(Candidate::stay(level), Path::ActiveSet, 0));
    }
    if let Some(guess) = guess {
        let candidate = active_set::polish(level, &Vector::zeros(level.unknowns()), guess)?;
        if candidate.is_optimal() {
            return Ok(LevelSolution::new(candidate, Path::ActiveSet, 0));
        }
    }
    let approximate = clarabel_level::solve(level);
    // From z = 0 first: where the level leaves something open, Clarabel's point is large for no reason.
    for near in [&Vector::zeros(level.unknowns()), &approximate.z] {
        let polished = active_set::polish(level, near, &approximate.active_set)?;
        if polished.is_optimal() {
            return Ok(LevelSolution::new(polished, Path::Qp, approximate.iterations));
        }
    }
    Ok(LevelSolution::new(active_set::iterate(level)?, Path::Qp, approximate.iterations))
}
