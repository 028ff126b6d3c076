//! The problem as a cascade of small quadratic programs with joint limits as inequalities.
//!
//! A level minimises ‖A q̇ − b‖² over what the levels before left open. What is left open is kept in reduced form,
//! q̇ = base + Z z with `base` feasible: solved rows are eliminated from Z and limits with a positive multiplier become
//! fixed joints, so that every level is: min ‖A Z z − r‖² s.t. lo ≤ base + Z z ≤ hi, feasible at z = 0. Passing solved
//! levels on as equality rows would leave a set without interior, on which an interior-point solver stalls.

mod active_set;
mod clarabel_level;
mod feasible_set;
mod level;
mod objectives;

pub use active_set::{ActiveSet, Side};

use feasible_set::FeasibleSet;
use level::LevelSolution;
use objectives::{Objective, stack_objectives, stage_objectives, strict_objectives};

use super::closed_form::{self, ClosedForm};
use super::hierarchy::Hierarchy;
use super::problem::{Method, Problem};
use super::resolve::Path;
use crate::limits::VelocityBox;
use crate::linalg::{SvdError, Vector};

/// What the cascade, or a closed form in its place, found.
pub struct Cascade {
    /// q̇, n, rad/s.
    pub joint_velocity: Vector,
    /// Multipliers of the limits, n; positive at the upper, negative at the lower bound, 0 where inactive.
    pub multipliers: Vector,
    /// Active limits, one set per level with limits.
    pub active_sets: Vec<ActiveSet>,
    /// The longest way that a level needed.
    pub path: Path,
    /// Iterations of Clarabel.
    pub iterations: u32,
    /// Largest relative residual of the optimality conditions.
    pub kkt_residual: f64,
}

impl From<ClosedForm> for Cascade {
    fn from(closed: ClosedForm) -> Self {
        Self {
            multipliers: Vector::zeros(closed.joint_velocity.len()),
            joint_velocity: closed.joint_velocity,
            active_sets: Vec::new(),
            path: Path::ClosedForm,
            iterations: 0,
            kkt_residual: closed.kkt_residual,
        }
    }
}

/// Active sets to try before Clarabel, one per level.
#[derive(Clone, Copy)]
pub struct Guesses<'a>(Option<&'a [ActiveSet]>);

impl<'a> Guesses<'a> {
    /// Ask Clarabel at every level.
    pub const NONE: Self = Self(None);

    /// Try these first; levels beyond the last go to Clarabel.
    pub fn of(sets: &'a [ActiveSet]) -> Self {
        Self(Some(sets))
    }

    fn level(self, index: usize) -> Option<&'a ActiveSet> {
        self.0.and_then(|sets| sets.get(index))
    }

    /// Whether stages without limits, whose active set is empty for certain, may take the closed form.
    fn allowed(self) -> bool {
        self.0.is_some()
    }
}

/// Solves the problem level by level.
pub fn solve(problem: &Problem, hierarchy: &Hierarchy, guesses: Guesses) -> Result<Cascade, SvdError> {
    let zeta = problem.start();
    let within_limits = |levels: Vec<Objective>| descend(&levels, &problem.limits, guesses);
    match problem.method {
        Method::ReversePriority | Method::SingularityRobust => reverse_priority(problem, hierarchy, guesses),
        Method::StrictReversePriority | Method::TaskPriority => {
            strict_objectives(problem, &zeta).and_then(within_limits)
        }
        Method::Pseudoinverse => within_limits(stack_objectives(problem, 0.0, &zeta)),
        Method::DampedLeastSquares => within_limits(stack_objectives(problem, hierarchy.top().lambda, &zeta)),
    }
}

/// Stages k = l … 2 without limits, then stage 1 with them.
fn reverse_priority(problem: &Problem, hierarchy: &Hierarchy, guesses: Guesses) -> Result<Cascade, SvdError> {
    let (top, lower) = (hierarchy.top(), &hierarchy.stages[1..]);
    let mut before = Cascade::from(ClosedForm { joint_velocity: problem.start(), kkt_residual: 0.0 });
    if guesses.allowed() {
        before = Cascade::from(closed_form::reverse_priority(lower, &before.joint_velocity)?);
    } else {
        let unbounded = VelocityBox::unbounded(problem.tasks.joint_count());
        for stage in lower.iter().rev() {
            let start = &before.joint_velocity;
            let answer = descend(&stage_objectives(stage, start), &unbounded, guesses)?;
            before = answer.after(&before);
        }
    }
    let start = &before.joint_velocity;
    let answer = descend(&stage_objectives(top, start), &problem.limits, guesses)?;
    Ok(answer.after(&before))
}

impl Cascade {
    /// Adds up what the stages before needed.
    fn after(self, before: &Self) -> Self {
        Self {
            iterations: self.iterations + before.iterations,
            kkt_residual: self.kkt_residual.max(before.kkt_residual),
            ..self
        }
    }
}

/// Goes down the levels of one stage.
fn descend(objectives: &[Objective], limits: &VelocityBox, guesses: Guesses) -> Result<Cascade, SvdError> {
    let mut set = FeasibleSet::new(limits);
    let mut cascade = Cascade::from(ClosedForm { joint_velocity: set.base().clone(), kkt_residual: 0.0 });
    // Levels that leave nothing to decide need no solver; those that do say which way they took.
    cascade.path = if guesses.allowed() { Path::ActiveSet } else { Path::Qp };
    let mut achieved = Vec::with_capacity(objectives.len());
    let mut speed = set.base().norm();
    for (index, objective) in objectives.iter().enumerate() {
        let solution = level::solve(&set.reduce(objective), guesses.level(index))?;
        set.keep(objective, &solution)?;
        if index == 0 {
            cascade.multipliers = set.multipliers_of_pinned(objective);
        }
        cascade.add(&solution);
        cascade.active_sets.push(solution.active_set);
        achieved.push(objective.kept_value(set.base()));
        speed = speed.max(set.base().norm());
    }
    let drift = objectives.iter().zip(&achieved).map(|(objective, value)| objective.drift(value, set.base(), speed));
    cascade.kkt_residual = drift.fold(cascade.kkt_residual, f64::max);
    cascade.joint_velocity = set.base().clone();
    Ok(cascade)
}

impl Cascade {
    fn add(&mut self, solution: &LevelSolution) {
        if solution.path == Path::Qp {
            self.path = Path::Qp;
        }
        self.iterations += solution.iterations;
        self.kkt_residual = self.kkt_residual.max(solution.kkt_residual);
        // The highest level that a limit holds back is the reason for it.
        self.multipliers.zip_apply(&solution.multipliers, |known, new| {
            if *known == 0.0 {
                *known = new;
            }
        });
    }
}
