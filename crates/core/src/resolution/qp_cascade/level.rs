//! One level in reduced form, and the ways to its solution.
#![allow(non_snake_case)]

use super::Guess;
use super::active_set::{self, ActiveSet, Candidate, Side};
use super::clarabel_level::ClarabelLevels;
use super::minimiser::Minimiser;
use crate::linalg::{RANK_TOLERANCE, TaskMatrix, TaskVector};
use crate::resolution::resolve::Path;

/// min ‖C z − d‖² s.t. lower ≤ G z ≤ upper for the bounded rows; z = 0 is feasible.
#[derive(Default)]
pub struct Level {
    /// C, m × p.
    pub C: TaskMatrix,
    /// d, m.
    pub d: TaskVector,
    /// G, rows × p: the rows of the [`Constraints`](super::constraints::Constraints) per unit of z.
    pub G: TaskMatrix,
    /// Room below, per row, ≤ 0.
    pub lower: TaskVector,
    /// Room above, per row, ≥ 0.
    pub upper: TaskVector,
    /// Whether the row's bounds are constraints of this level.
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
    pub fn size(&self, z: &TaskVector) -> f64 {
        self.base_size + self.scale * z.norm()
    }

    /// Whether nothing that is open changes the objective.
    fn is_decided(&self) -> bool {
        self.C.norm() <= RANK_TOLERANCE * self.scale
    }

    /// Room of a row towards one side.
    pub fn bound(&self, row: usize, side: Side) -> f64 {
        match side {
            Side::Lower => self.lower[row],
            Side::Upper => self.upper[row],
        }
    }

    /// Whether a limit is a constraint of this level.
    pub fn has(&self, (row, side): (usize, Side)) -> bool {
        self.bounded.get(row) == Some(&true) && self.bound(row, side).is_finite()
    }

    /// The finite bounds: row, side, right-hand side.
    pub fn constraints(&self) -> impl Iterator<Item = (usize, Side, f64)> {
        (0..self.G.nrows())
            .filter(|&row| self.bounded[row])
            .flat_map(|row| [(row, Side::Lower, self.lower[row]), (row, Side::Upper, self.upper[row])])
            .filter(|(_, _, bound)| bound.is_finite())
    }
}

/// The solution of a level.
pub struct LevelSolution {
    /// z, p.
    pub z: TaskVector,
    /// Signed multipliers of the limits, per row; positive at the upper, negative at the lower bound.
    pub multipliers: TaskVector,
    /// The limits that are active.
    pub active_set: ActiveSet,
    /// What moving each limit away would gain, per row, relative to the size of the level; ≥ 0.
    relief: TaskVector,
    /// Relative residual of the optimality conditions.
    pub kkt_residual: f64,
    /// The way that led here.
    pub path: Path,
    /// Iterations of Clarabel.
    pub iterations: u32,
    /// Whether Clarabel failed, so that the active-set iteration stood in.
    pub failed: bool,
    /// Whether the solver's minimiser is on this set.
    is_last: bool,
}

impl LevelSolution {
    /// The candidate that was found last.
    fn of(candidate: Candidate, minimiser: &Minimiser) -> Self {
        Self {
            is_last: minimiser.active == candidate.active_set,
            z: candidate.z,
            multipliers: candidate.multipliers,
            active_set: candidate.active_set,
            kkt_residual: candidate.kkt_residual,
            relief: candidate.relief,
            path: Path::ActiveSet,
            iterations: 0,
            failed: false,
        }
    }

    /// Rows whose limit, moved away, would gain more than `proof`.
    pub fn proved_active(&self, proof: f64) -> impl Iterator<Item = usize> {
        self.relief.iter().enumerate().filter(move |(_, relief)| **relief > proof).map(|(row, _)| row)
    }

    /// Whether all limits of the set are proved active.
    fn proves_its_set(&self, proof: f64) -> bool {
        self.active_set.iter().all(|&(row, _)| self.relief[row] > proof)
    }
}

/// The ways to the solution of a level.
#[derive(Default)]
pub struct LevelSolver {
    clarabel: ClarabelLevels,
    minimiser: Minimiser,
}

impl LevelSolver {
    /// Solves the level: with a guess by active sets that start from it, if one is found whose optimality conditions hold,
    /// otherwise through Clarabel.
    ///
    /// Clarabel's answer is worth its active set: the least-squares problem on that set is solved exactly. Should the set
    /// be wrong, which happens at degenerate corners, or Clarabel fail, an active-set iteration from z = 0 finds the right
    /// one.
    pub fn solve(&mut self, level: &Level, guess: Guess) -> LevelSolution {
        let Self { clarabel, minimiser } = self;
        if level.is_decided() {
            return LevelSolution { is_last: false, ..LevelSolution::of(Candidate::stay(level), minimiser) };
        }
        if let Some(found) = guess.and_then(|guess| active_set::search(level, guess, minimiser)) {
            return LevelSolution::of(found, minimiser);
        }
        let (active_set, iterations) = clarabel.solve(level);
        let failed = active_set.is_none();
        let polished = active_set.map(|set| active_set::polish(level, &set, minimiser));
        let candidate = polished.filter(Candidate::is_optimal).unwrap_or_else(|| active_set::iterate(level, minimiser));
        let solution = LevelSolution::of(candidate, minimiser);
        LevelSolution { path: Path::Qp, iterations, failed, ..solution }
    }

    /// Z ← Z N, with N what changes neither C z nor the limits that the solution proves active, where these are all of its
    /// set; whether they are.
    pub fn close(&self, solution: &LevelSolution, proof: f64, Z: &mut TaskMatrix) -> bool {
        let known = solution.is_last && solution.proves_its_set(proof);
        if known {
            self.minimiser.close(Z);
        }
        known
    }
}
