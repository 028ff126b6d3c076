//! A working set level by level, in bounded time: primal active-set steps within each level.
//!
//! From a point inside the box, each level minimises its squared slack by Newton steps with an exact line search, over the
//! directions that higher levels leave free and against the bounds that it meets on the way. Then what its optimum needs is
//! fixed: equations, broken rows, and bounds with a multiplier. A step costs a few products with the rows, no new
//! factorisation. Second derivatives are normal equations, so a step is not exact. But gradients are computed from the rows, so
//! that steps converge to the optimum. The result is a proposal: the conditions on that set decide.

mod directions;
mod step;

use super::problem_rows::ProblemRows;
use crate::linalg::Row;
use crate::resolution::Side;
use crate::resolution::solution::{WorkingSet, refill};
use crate::tolerances::TOLERANCES;

/// Steps over all levels, for each unknown and each row: the most, and the fewest where each is expensive. Random problems take
/// at most one.
const MOST_STEPS: usize = 10;
const LEAST_STEPS: usize = 1;

/// Entries of the rows from which on [`LEAST_STEPS`] are taken.
const EXPENSIVE: usize = 20_000;

/// Returns the number of steps after which the point stays where it is.
fn most_steps(unknowns: usize, rows: usize) -> usize {
    let work = (unknowns * (unknowns + rows)).max(1);
    (EXPENSIVE / work).clamp(LEAST_STEPS, MOST_STEPS) * (unknowns + rows + 10)
}

/// A bound that the path met: it holds its unknown or row, until its multiplier points inwards.
#[derive(Debug, Clone, Copy)]
struct Held<const N: usize> {
    constraint: usize,
    side: Side,
    /// Its gradient: a unit row for an unknown.
    normal: Row<N>,
    /// The part of the normal that neither fixed directions nor bounds held before have, of length one.
    direction: Row<N>,
    /// The normal over the directions of this bound and of those before.
    coordinates: Row<N>,
}

/// What a row does in the present level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// It belongs to a lower level.
    Later,
    /// An equation of this level.
    Equation,
    /// An inequality of this level; `Some`: it is broken there.
    Slack(Option<Side>),
    /// It is kept for a higher level.
    Kept,
    /// Its value cannot change any more; `Some`: a broken inequality.
    Fixed(Option<Side>),
}

/// An unknown or a row.
#[derive(Debug, Clone, Copy)]
struct Constraint {
    /// a·x.
    value: f64,
    /// The change of the value along a step.
    slope: f64,
    role: Role,
    /// The bounds, as far as higher levels keep them.
    lower: f64,
    upper: f64,
}

impl Constraint {
    /// Returns the bound that the value breaks.
    fn broken(&self) -> Option<Side> {
        if self.value > self.upper {
            Some(Side::Upper)
        } else if self.value < self.lower {
            Some(Side::Lower)
        } else {
            None
        }
    }

    /// Returns by how much the value of a row of this level is above (positive) or below its bound.
    fn slack(&self) -> f64 {
        match self.role {
            Role::Equation | Role::Slack(Some(Side::Lower)) => self.value - self.lower,
            Role::Slack(Some(Side::Upper)) => self.value - self.upper,
            _ => 0.0,
        }
    }

    /// Returns whether the value is followed.
    fn is_moving(&self) -> bool {
        !matches!(self.role, Role::Later | Role::Fixed(_))
    }
}

/// A change of curvature along a step.
type Kink = (f64, f64);

/// The point on its way through the levels.
#[derive(Debug, Default)]
pub struct Cascade<const N: usize> {
    x: Row<N>,
    /// The unknowns, then the rows.
    constraints: Vec<Constraint>,
    /// Orthonormal directions that higher levels fix.
    fixed: Vec<Row<N>>,
    held: Vec<Held<N>>,
    /// Room for bounds that are held again.
    later: Vec<Held<N>>,
    /// Orthonormal directions that are free.
    free: Vec<Row<N>>,
    /// Second derivatives of the level over the free directions, and room for their factor.
    curvature: Vec<Row<N>>,
    factor: Vec<Row<N>>,
    gradient: Row<N>,
    candidates: Vec<Row<N>>,
    kinks: Vec<Kink>,
    /// Steps of length zero since the last one that was not.
    idle: usize,
    /// Steps before the point stays where it is.
    steps_left: usize,
}

impl<const N: usize> Cascade<N> {
    /// Allocates what a problem of this size needs.
    pub fn reserve(&mut self, unknowns: usize, rows: usize) {
        let constraints = unknowns + rows;
        if self.constraints.capacity() >= constraints {
            return;
        }
        self.constraints.reserve(constraints);
        self.candidates.reserve(rows);
        self.kinks.reserve(2 * rows);
        for list in [&mut self.fixed, &mut self.free, &mut self.curvature, &mut self.factor] {
            list.reserve(N + 1);
        }
        self.held.reserve(N + 1);
        self.later.reserve(N + 1);
    }

    /// Proposes a working set; returns the point at which it ends, inside the box.
    pub fn propose(&mut self, problem: &ProblemRows<N>, set: &mut WorkingSet) -> Row<N> {
        self.start(problem);
        for level in 0..=problem.levels.len() {
            self.start_level(problem, level);
            let size = self.size(problem, level);
            // Where nothing is left to decide, rows of lower levels are broken or not.
            if !(self.free.is_empty() && self.held.is_empty()) {
                self.minimize(problem, level, size);
            }
            self.finish_level(problem, level, size);
        }
        self.write(problem, set);
        self.x
    }

    fn start(&mut self, problem: &ProblemRows<N>) {
        let n = problem.unknowns;
        self.x = problem.reference.clamp(&problem.lower, &problem.upper);
        let x = self.x;
        let unknowns = (0..n).map(|j| {
            let role = if problem.is_pinned(j) { Role::Fixed(None) } else { Role::Kept };
            Constraint { value: x.0[j], slope: 0.0, role, lower: problem.lower.0[j], upper: problem.upper.0[j] }
        });
        let rows = problem.rows.iter().zip(problem.coefficients).map(|(row, coefficients)| {
            let value = x.dot(coefficients);
            Constraint { value, slope: 0.0, role: Role::Later, lower: row.lower, upper: row.upper }
        });
        refill(&mut self.constraints, unknowns.chain(rows));
        refill(&mut self.fixed, (0..n).filter(|&j| problem.is_pinned(j)).map(unit));
        refill(&mut self.free, (0..n).filter(|&j| !problem.is_pinned(j)).map(unit));
        self.held.clear();
        self.idle = 0;
        self.steps_left = most_steps(n, problem.rows.len());
    }

    /// Gives the rows of the level their roles, and sets its curvature.
    fn start_level(&mut self, problem: &ProblemRows<N>, level: usize) {
        let n = problem.unknowns;
        refill(&mut self.curvature, std::iter::repeat_n(Row::ZERO, self.free.len()));
        let Some(size) = problem.levels.get(level) else {
            for (i, row) in self.curvature.iter_mut().enumerate() {
                row.0[i] = 1.0;
            }
            return;
        };
        let is_first = level == 0 && self.free.len() == n;
        for i in size.start..size.end {
            let row = &mut self.constraints[n + i];
            row.value = self.x.dot(&problem.coefficients[i]);
            row.role = if problem.rows[i].is_equation() { Role::Equation } else { Role::Slack(row.broken()) };
            if is_active(row.role) && !is_first {
                self.add_curvature(&problem.coefficients[i], 1.0);
            } else if is_active(row.role) {
                // Free directions are the unknowns themselves.
                let coefficients = &problem.coefficients[i];
                for (entries, entry) in self.curvature.iter_mut().zip(coefficients) {
                    entries.add_scaled(*entry, coefficients);
                }
            }
        }
    }

    /// Returns the size of a residual of the level.
    fn size(&self, problem: &ProblemRows<N>, level: usize) -> f64 {
        let Some(size) = problem.levels.get(level) else { return self.x.norm() + problem.reference.norm() };
        let rows = &self.constraints[problem.unknowns..][size.rows()];
        // A bound that is far away says nothing about the residual.
        let wanted = rows.iter().map(|row| row.value.max(row.lower).min(row.upper).abs());
        wanted.fold(0.0, f64::max) + size.norm * self.x.norm()
    }

    /// Moves to the optimum of the level.
    fn minimize(&mut self, problem: &ProblemRows<N>, level: usize, size: f64) {
        let norm = problem.levels.get(level).map_or(1.0, |level| level.norm);
        let zero = TOLERANCES.cascade_zero * norm * size;
        let mut is_settled = false;
        let mut last = f64::INFINITY;
        while self.steps_left > 0 {
            self.steps_left -= 1;
            self.set_gradient(problem, level);
            let slope =
                self.free.iter().map(|direction| direction.dot(&self.gradient)).fold(0.0, |a, b| f64::max(a, b.abs()));
            if slope <= 0.01 * zero || (is_settled && slope >= 0.1 * last) {
                if !self.release(zero) {
                    return;
                }
                self.extend_curvature(problem, level);
                (is_settled, last) = (false, f64::INFINITY);
                continue;
            }
            last = slope;
            let step = self.newton_step();
            let is_full = self.advance(problem, level, &step);
            if !is_full {
                last = f64::INFINITY;
            }
            is_settled = is_full;
        }
    }

    /// Sets the gradient of ½ Σ s², or of ½ ‖x − ζ‖².
    fn set_gradient(&mut self, problem: &ProblemRows<N>, level: usize) {
        let Some(size) = problem.levels.get(level) else {
            self.gradient = self.x.minus(&problem.reference);
            return;
        };
        self.gradient = Row::ZERO;
        for i in size.start..size.end {
            let slack = self.constraints[problem.unknowns + i].slack();
            if slack != 0.0 {
                self.gradient.add_scaled(slack, &problem.coefficients[i]);
            }
        }
    }

    /// Moves along the step to the least slack or the first bound; returns whether it was the whole step and no row changed its
    /// role.
    fn advance(&mut self, problem: &ProblemRows<N>, level: usize, step: &Row<N>) -> bool {
        let n = problem.unknowns;
        let (unknowns, rows) = self.constraints.split_at_mut(n);
        unknowns.iter_mut().zip(&step.0).for_each(|(unknown, slope)| unknown.slope = *slope);
        for (row, coefficients) in rows.iter_mut().zip(problem.coefficients).filter(|(row, _)| row.is_moving()) {
            row.slope = step.dot(coefficients);
        }
        let (most, blocking) = self.first_bound(problem, step);
        let length = self.least_slack(problem, level, step, most);
        let is_blocked = blocking.is_some() && length >= most;
        self.idle = if length > 0.0 { 0 } else { self.idle + 1 };
        self.x.add_scaled(length, step);
        self.x = self.x.clamp(&problem.lower, &problem.upper);
        let mut changed = false;
        self.constraints.iter_mut().zip(&self.x.0[..n]).for_each(|(unknown, x)| unknown.value = *x);
        for at in n..self.constraints.len() {
            let row = &mut self.constraints[at];
            if !row.is_moving() {
                continue;
            }
            row.value += length * row.slope;
            if let Role::Slack(before) = row.role {
                let after = row.broken();
                changed |= after != before;
                row.role = Role::Slack(after);
                if after.is_some() != before.is_some() {
                    self.add_curvature(&problem.coefficients[at - n], if after.is_some() { 1.0 } else { -1.0 });
                }
            }
        }
        if let (true, Some((constraint, side))) = (is_blocked, blocking) {
            self.hold(problem, constraint, side);
        }
        !(is_blocked || changed) && length >= 1.0
    }

    /// Fixes what the optimum of the level needs; the rest of its rows is kept from now on.
    fn finish_level(&mut self, problem: &ProblemRows<N>, level: usize, size: f64) {
        let n = problem.unknowns;
        let Some(own) = problem.levels.get(level) else { return };
        let rounding = TOLERANCES.cascade_zero * size;
        let multipliers = self.multipliers();
        self.candidates.clear();
        let mut needed = Row::<N>::ZERO;
        for (at, held) in self.held.iter().enumerate() {
            needed.0[at] = f64::from(u8::from(
                multipliers.0[at].abs() * held.normal.norm() > TOLERANCES.cascade_zero * own.norm * size,
            ));
        }
        for (row, coefficients) in self.constraints[n..][own.rows()].iter_mut().zip(&problem.coefficients[own.rows()]) {
            row.role = match row.role {
                Role::Equation => Role::Fixed(None),
                Role::Slack(side @ Some(_)) if row.slack().abs() > rounding => Role::Fixed(side),
                _ => {
                    row.lower = row.lower.min(row.value);
                    row.upper = row.upper.max(row.value);
                    Role::Kept
                }
            };
            if matches!(row.role, Role::Fixed(_)) {
                self.candidates.push(Row(*coefficients));
            }
        }
        self.fix_candidates(own.norm);
        // Bounds with a multiplier stay for good; the others are held on.
        let mut held = std::mem::take(&mut self.later);
        refill(&mut held, self.held.drain(..));
        let with_need = || held.iter().zip(&needed.0);
        with_need().filter(|(_, needed)| **needed > 0.0).for_each(|(bound, _)| self.fix_bound(bound));
        with_need().filter(|(_, needed)| **needed == 0.0).for_each(|(bound, _)| self.hold_again(bound));
        self.later = held;
    }

    /// Writes the set: what is fixed or held at a bound.
    fn write(&self, problem: &ProblemRows<N>, set: &mut WorkingSet) {
        let n = problem.unknowns;
        set.clear(n, problem.rows.len());
        for (at, constraint) in self.constraints.iter().enumerate() {
            if let Role::Fixed(side) | Role::Slack(side) = constraint.role {
                *place(set, n, at) = side;
            }
        }
        for held in &self.held {
            *place(set, n, held.constraint) = Some(held.side);
        }
    }
}

fn place(set: &mut WorkingSet, n: usize, constraint: usize) -> &mut Option<Side> {
    match constraint.checked_sub(n) {
        None => &mut set.unknowns[constraint],
        Some(row) => &mut set.rows[row],
    }
}

fn is_active(role: Role) -> bool {
    matches!(role, Role::Equation | Role::Slack(Some(_)))
}

/// Returns a row with 1 at the place j.
fn unit<const N: usize>(j: usize) -> Row<N> {
    let mut row = Row::ZERO;
    row.0[j] = 1.0;
    row
}
