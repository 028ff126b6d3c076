//! A task that is slowed down rather than bent: the largest s ≤ 1 with J_k q̇ = s ẋ_k.
//!
//! The usual level gives the least residual, whatever its direction. A task that is to be scaled keeps the direction
//! instead: with an orthonormal basis U of what J_k can reach without limits, the unknowns (q̇, s) obey
//! Uᵀ(J_k q̇ − s ẋ_k) = 0, and then (1 − s)² becomes minimal: two more levels of the same cascade.
#![allow(non_snake_case)]

use super::feasible_set::FeasibleSet;
use super::level::{Level, LevelSolution, LevelSolver};
use super::objectives::Objective;
use super::{Guess, Guesses};
use crate::linalg::{Decomposition, TaskMatrix, TaskVector};
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
    /// Uᵀ, r × m.
    reachable: TaskMatrix,
}

impl<'a> ScaledTask<'a> {
    /// `higher`: the objectives that were solved before.
    pub fn new(objective: &'a Objective, higher: &[Objective]) -> Self {
        let J = &objective.A;
        let mut above = TaskMatrix::zeros(0, J.ncols());
        for level in higher {
            above.push_rows(&level.A);
        }
        let mut open = J.clone();
        Decomposition::new(&above).to_null_space(&mut open);
        Self { objective, reachable: Decomposition::with_scale(&open, objective.norm).range() }
    }

    /// After the usual level was solved in `usual`: replaces its solution, found in `before`, if the limits bend the task.
    pub fn solve(
        &self,
        before: &FeasibleSet,
        usual: &mut FeasibleSet,
        guesses: [Guess; LEVELS],
        solver: &mut LevelSolver,
    ) -> Scaling {
        let Objective { A: J, b: xdot, norm, .. } = self.objective;
        let size = norm * usual.base().norm() + xdot.norm();
        if relative((&self.reachable * &(&(J * usual.base()) - xdot)).amax(), size) <= KEPT {
            return Scaling { factor: Some(1.0), levels: Vec::new() };
        }
        let mut scaled = before.with_scale();
        let [first_guess, second_guess] = guesses;
        let direction = self.direction();
        let first = settle(&mut scaled, &direction, first_guess, solver);
        let size = direction.norm * scaled.base().norm().max(1.0);
        if xdot.norm() == 0.0 || relative((&direction.A * scaled.base()).amax(), size) > KEPT {
            return Scaling { factor: None, levels: vec![first] };
        }
        let magnitude = self.magnitude();
        let second = settle(&mut scaled, &magnitude, second_guess, solver);
        Scaling { factor: Some(usual.take_over(&scaled)), levels: vec![first, second] }
    }

    /// Uᵀ(J q̇ − s ẋ) → 0.
    fn direction(&self) -> Objective {
        let Objective { A: J, b: xdot, .. } = self.objective;
        let (rows, n) = (&self.reachable * J, J.ncols());
        let last = -&(&self.reachable * xdot);
        let rows = TaskMatrix::from_fn(rows.nrows(), n + 1, |i, j| if j < n { rows[i][j] } else { last[i] });
        let zero = TaskVector::zeros(rows.nrows());
        Objective::exact(rows, zero)
    }

    /// s ‖ẋ‖ → ‖ẋ‖, so that multipliers count as those of the usual level do.
    fn magnitude(&self) -> Objective {
        let (size, n) = (self.objective.b.norm(), self.objective.A.ncols());
        let row = TaskMatrix::from_fn(1, n + 1, |_, j| if j == n { size } else { 0.0 });
        Objective::exact(row, TaskVector::from_slice(&[size]))
    }
}

fn settle(set: &mut FeasibleSet, objective: &Objective, guess: Guess, solver: &mut LevelSolver) -> LevelSolution {
    let mut level = Level::default();
    set.reduce(objective, &mut level);
    let solution = solver.solve(&level, guess);
    set.keep(objective, &level, &solution, solver);
    solution
}

impl<'a> Guesses<'a> {
    /// The guesses of the levels that scaling adds after level `index`.
    pub fn of_scaling(self, index: usize) -> [Guess<'a>; LEVELS] {
        std::array::from_fn(|i| self.level(index + 1 + i))
    }
}
