//! The problem as a cascade of small quadratic programs with joint limits as inequalities.
//!
//! A level minimises ‖A q̇ − b‖² over what the levels before left open. What is left open is kept in reduced form,
//! q̇ = base + Z z with `base` feasible: solved rows are eliminated from Z and limits with a positive multiplier become
//! fixed joints, so that every level is: min ‖A Z z − r‖² s.t. lo ≤ base + Z z ≤ hi, feasible at z = 0. Passing solved
//! levels on as equality rows would leave a set without interior, on which an interior-point solver stalls.

mod active_set;
mod clarabel_level;
mod constraints;
mod feasible_set;
mod level;
mod minimiser;
mod objectives;
mod relaxation;
mod scaling;

pub use active_set::{ActiveSet, Side};
#[cfg(test)]
pub use clarabel_level::fault;

use smallvec::SmallVec;

use feasible_set::FeasibleSet;
use level::{Level, LevelSolution, LevelSolver};
use objectives::{Objective, Objectives};
use scaling::{ScaledTask, Scaling};

use super::closed_form::{ClosedForm, Descent, least_squares, reverse_priority};
use super::hierarchy::{Hierarchy, Rows, Stage};
use super::problem::{Problem, Scheme};
use super::resolve::Path;
use crate::linalg::{Decomposition, TaskVector};

/// What the cascade, or a closed form in its place, found.
pub struct Cascade {
    /// q̇, n, rad/s.
    pub joint_velocity: TaskVector,
    /// Multipliers of the limits, n joints, then the inequalities per unit length of their coefficients; positive at the
    /// upper, negative at the lower bound, 0 where inactive.
    pub multipliers: TaskVector,
    /// Active limits, one set per level with limits.
    pub active_sets: SmallVec<[ActiveSet; 4]>,
    /// s of each level with limits whose task is to be scaled, as far as one keeps its direction; empty for a closed form.
    pub scales: SmallVec<[Option<f64>; 4]>,
    /// The longest way that a level needed.
    pub path: Path,
    /// Iterations of Clarabel.
    pub iterations: u32,
    /// Levels that Clarabel failed to solve.
    pub failures: u32,
    /// Largest relative residual of the optimality conditions.
    pub kkt_residual: f64,
}

impl From<ClosedForm> for Cascade {
    fn from(closed: ClosedForm) -> Self {
        Self {
            multipliers: TaskVector::zeros(closed.joint_velocity.len()),
            joint_velocity: closed.joint_velocity,
            active_sets: SmallVec::new(),
            scales: SmallVec::new(),
            path: Path::ClosedForm,
            iterations: 0,
            failures: 0,
            kkt_residual: closed.kkt_residual,
        }
    }
}

/// Active sets to begin with before Clarabel is asked, one per level.
#[derive(Clone, Copy)]
pub struct Guesses<'a>(Option<&'a [ActiveSet]>);

impl<'a> Guesses<'a> {
    /// Ask Clarabel at every level.
    pub const NONE: Self = Self(None);

    /// Begin with these, and with none at levels beyond the last.
    pub fn of(sets: &'a [ActiveSet]) -> Self {
        Self(Some(sets))
    }

    /// The set to begin with at a level, none of whose limits are known to hold where there is no guess.
    fn level(self, index: usize) -> Guess<'a> {
        self.0.map(|sets| sets.get(index).map_or(&[][..], |set| set.as_slice()))
    }

    /// Whether stages without limits, whose active set is empty for certain, may take the closed form.
    fn allowed(self) -> bool {
        self.0.is_some()
    }
}

/// The active limits to begin with at one level; `None`: ask Clarabel.
type Guess<'a> = Option<&'a [(usize, Side)]>;

/// What the cascade works with, overwritten by each problem.
#[derive(Default)]
pub struct CascadeSolver {
    objectives: Objectives,
    descent: Descent,
    /// The rows of the stages below the highest one, and their decomposition.
    rows: Rows,
    decomposition: Decomposition,
    set: FeasibleSet,
    level: Level,
    solver: LevelSolver,
}

impl CascadeSolver {
    /// Solves the problem level by level.
    pub fn solve(&mut self, problem: &Problem, hierarchy: &Hierarchy, guesses: Guesses) -> Cascade {
        let zeta = problem.start();
        let stages = &hierarchy.stages;
        match problem.method.scheme() {
            Scheme::LowestFirst { .. } => return self.reverse_priority(problem, hierarchy, guesses),
            Scheme::HighestFirst => {
                self.objectives.become_strict(stages, problem.damping, &zeta, &mut self.descent);
            }
            Scheme::OneLevel { damped } => {
                let lambda = if damped { hierarchy.top().lambda } else { 0.0 };
                self.objectives.become_stack(hierarchy, lambda, &zeta);
            }
        }
        self.limit(problem);
        self.descend(guesses)
    }

    /// Stages k = l … 2 without limits, then stage 1 with them.
    fn reverse_priority(&mut self, problem: &Problem, hierarchy: &Hierarchy, guesses: Guesses) -> Cascade {
        let (top, lower) = (hierarchy.top(), &hierarchy.stages[1..]);
        let mut before = Cascade::from(ClosedForm { joint_velocity: problem.start(), kkt_residual: 0.0 });
        if guesses.allowed() && !lower.is_empty() {
            before = Cascade::from(self.below(lower, hierarchy.is_compatible, before.joint_velocity));
        } else {
            for stage in lower.iter().rev() {
                self.objectives.become_stage(stage, &before.joint_velocity);
                self.set.constraints.become_none(before.joint_velocity.len());
                before = self.descend(guesses).after(&before);
            }
        }
        self.objectives.become_stage(top, &before.joint_velocity);
        self.limit(problem);
        self.descend(guesses).after(&before)
    }

    /// The stages below the highest one in closed form.
    fn below(&mut self, lower: &[Stage], is_compatible: bool, zeta: TaskVector) -> ClosedForm {
        if !is_compatible {
            return reverse_priority(lower, zeta);
        }
        let Self { rows, decomposition, .. } = self;
        rows.stack(lower);
        decomposition.decompose(&rows.J, 0, rows.norm);
        least_squares(rows, decomposition, &zeta, 0.0)
    }

    fn limit(&mut self, problem: &Problem) {
        self.set.constraints.become_those_of(&problem.limits, &problem.inequalities);
    }

    /// Goes down the levels of one stage, within the constraints of the set.
    fn descend(&mut self, guesses: Guesses) -> Cascade {
        let Self { objectives, set, level, solver, .. } = self;
        set.open_all();
        let mut cascade = Cascade::from(ClosedForm { joint_velocity: set.base().clone(), kkt_residual: 0.0 });
        cascade.multipliers = TaskVector::zeros(set.constraints.count());
        // Levels that leave nothing to decide need no solver; those that do say which way they took.
        cascade.path = if guesses.allowed() { Path::ActiveSet } else { Path::Qp };
        let mut achieved: SmallVec<[TaskVector; 4]> = SmallVec::new();
        let mut speed = set.base().norm();
        for (index, objective) in objectives.iter().enumerate() {
            let before = objective.scaled.then(|| set.clone());
            let place = cascade.active_sets.len();
            set.reduce(objective, level);
            let solution = solver.solve(level, guesses.level(place));
            set.keep(objective, level, &solution, solver);
            let pinned = (index == 0).then(|| set.multipliers_of_pinned(objective));
            cascade.scales.push(None);
            match before {
                None => cascade.add(solution, pinned),
                Some(before) => {
                    let task = ScaledTask::new(objective, &objectives[..index]);
                    let scaling = task.solve(&before, set, guesses.of_scaling(place), solver);
                    cascade.add_scaled(solution, pinned, scaling);
                }
            }
            if index + 1 < objectives.len() {
                achieved.push(objective.kept_value(set.base()));
            }
            speed = speed.max(set.base().norm());
        }
        let drift = |(objective, value): (&Objective, &TaskVector)| objective.drift(value, set.base(), speed);
        cascade.kkt_residual = objectives.iter().zip(&achieved).map(drift).fold(cascade.kkt_residual, f64::max);
        cascade.joint_velocity = set.base().clone();
        cascade
    }
}

impl Cascade {
    /// Adds up what the stages before needed.
    fn after(self, before: &Self) -> Self {
        Self {
            iterations: self.iterations + before.iterations,
            failures: self.failures + before.failures,
            kkt_residual: self.kkt_residual.max(before.kkt_residual),
            ..self
        }
    }
}

impl Cascade {
    /// Adds a level; `pinned`: multipliers of joints whose bounds coincide, known at the first level.
    fn add(&mut self, solution: LevelSolution, pinned: Option<TaskVector>) {
        self.multipliers = pinned.unwrap_or_else(|| std::mem::take(&mut self.multipliers));
        self.explain_by(&solution.multipliers);
        self.count(&solution);
        self.active_sets.push(solution.active_set);
    }

    /// Adds the level of a task that is to be scaled, and the levels that scaling took.
    fn add_scaled(&mut self, usual: LevelSolution, pinned: Option<TaskVector>, scaling: Scaling) {
        if scaling.is_cut() {
            self.count(&usual);
            self.active_sets.push(usual.active_set);
        } else {
            self.add(usual, pinned);
        }
        let mut sets = [ActiveSet::new(), ActiveSet::new()];
        for (set, level) in sets.iter_mut().zip(scaling.levels) {
            self.count(&level);
            if scaling.factor.is_some() {
                self.explain_by(&level.multipliers);
            }
            set.extend(level.active_set.iter().copied().filter(|&(row, _)| row < self.multipliers.len()));
        }
        self.active_sets.extend(sets);
        self.scales.pop();
        self.scales.push(scaling.factor);
    }

    fn count(&mut self, solution: &LevelSolution) {
        if solution.path == Path::Qp {
            self.path = Path::Qp;
        }
        self.iterations += solution.iterations;
        self.failures += u32::from(solution.failed);
        self.kkt_residual = self.kkt_residual.max(solution.kkt_residual);
    }

    /// The highest level that a limit holds back is the reason for it.
    fn explain_by(&mut self, multipliers: &TaskVector) {
        for (known, &new) in self.multipliers.iter_mut().zip(multipliers.iter()) {
            if *known == 0.0 {
                *known = new;
            }
        }
    }
}
