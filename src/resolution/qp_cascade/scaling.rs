//! A task that is slowed down rather than bent: the largest s ≤ 1 with J_k q̇ = s ẋ_k.
//!
//! The usual level gives the least residual, whatever its direction. A task that is to be scaled keeps the direction
//! instead: with an orthonormal basis U of what J_k can reach without limits, the unknowns (q̇, s) obey
//! Uᵀ(J_k q̇ − s ẋ_k) = 0, and then (1 − s)² becomes minimal: two more levels of the same cascade.
#![allow(non_snake_case)]

use super::feasible_set::FeasibleSet;
use super::level::{self, LevelSolution};
use super::objectives::Objective;
use super::{ActiveSet, Guesses};
use crate::linalg::{Matrix, Svd, SvdError, Vector, stack};
use crate::resolution::certificate::relative;

/// Levels that a scaled task has beside the usual one.
pub const LEVELS: usize = 2;

/// Residual, relative to the level's size, up to which the direction counts as kept.
const KEPT: f64 = 1e-11;

/// What became of a task that is to be scaled.
pub struct Scaling {
    /// s; 1 where the limits do not cut the task, `None` where no s keeps the direction: limits exclude standstill, or
    /// higher tasks move this one.
    pub factor: Option<f64>,
    /// The levels (direction, magnitude) that were needed.
    pub levels: Vec<LevelSolution>,
}

impl Scaling {
    /// Whether the limits cut the task and scaling took the place of the usual level.
    pub fn is_cut(&self) -> bool {
        self.factor.is_some() && !self.levels.is_empty()
    }
}

/// min ‖J q̇ − ẋ‖², kept in direction.
pub struct ScaledTask<'a> {
    objective: &'a Objective,
    /// U, m × r.
    reachable: Matrix,
}

impl<'a> ScaledTask<'a> {
    /// `higher`: the objectives that were solved before.
    pub fn new(objective: &'a Objective, higher: &[Objective]) -> Result<Self, SvdError> {
        let J = &objective.A;
        let above = higher.iter().fold(Matrix::zeros(0, J.ncols()), |rows, level| stack(&rows, &level.A));
        let N = Svd::new(&above)?.null_space();
        Ok(Self { objective, reachable: Svd::with_scale(&(J * N), J.norm())?.range() })
    }

    /// After the usual level was solved in `usual`: replaces its solution, found in `before`, if the limits bend the task.
    pub fn solve(
        &self,
        before: &FeasibleSet,
        usual: &mut FeasibleSet,
        guesses: [Option<&ActiveSet>; LEVELS],
    ) -> Result<Scaling, SvdError> {
        let Objective { A: J, b: xdot, .. } = self.objective;
        let size = J.norm() * usual.base().norm() + xdot.norm();
        if relative(&(self.reachable.transpose() * (J * usual.base() - xdot)), size) <= KEPT {
            return Ok(Scaling { factor: Some(1.0), levels: Vec::new() });
        }
        let mut scaled = before.with_scale();
        let direction = self.direction();
        let first = level::solve(&scaled.reduce(&direction), guesses[0])?;
        scaled.keep(&direction, &first)?;
        let size = direction.A.norm() * scaled.base().norm().max(1.0);
        if xdot.norm() == 0.0 || relative(&(&direction.A * scaled.base()), size) > KEPT {
            return Ok(Scaling { factor: None, levels: vec![first] });
        }
        let magnitude = self.magnitude();
        let second = level::solve(&scaled.reduce(&magnitude), guesses[1])?;
        scaled.keep(&magnitude, &second)?;
        Ok(Scaling { factor: Some(usual.take_over(&scaled)), levels: vec![first, second] })
    }

    /// Uᵀ(J q̇ − s ẋ) → 0.
    fn direction(&self) -> Objective {
        let Objective { A: J, b: xdot, .. } = self.objective;
        let U = self.reachable.transpose();
        let mut rows = (&U * J).insert_column(J.ncols(), 0.0);
        rows.set_column(J.ncols(), &-(U * xdot));
        Objective::exact(&rows, Vector::zeros(rows.nrows()))
    }

    /// s ‖ẋ‖ → ‖ẋ‖, so that multipliers count as those of the usual level do.
    fn magnitude(&self) -> Objective {
        let (size, n) = (self.objective.b.norm(), self.objective.A.ncols());
        let mut row = Matrix::zeros(1, n + 1);
        row[(0, n)] = size;
        Objective::exact(&row, Vector::from_element(1, size))
    }
}

impl Guesses<'_> {
    /// The guesses of the levels that scaling adds after level `index`.
    pub fn of_scaling(&self, index: usize) -> [Option<&ActiveSet>; LEVELS] {
        std::array::from_fn(|i| self.level(index + 1 + i))
    }
}
