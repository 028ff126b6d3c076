//! A working set of a hierarchical problem, and a solution.

use revprio_problem::Side;

use crate::tolerances::TOLERANCES;

/// The active bounds: those of unknowns, and those of inequality rows. Equations are always active and not listed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WorkingSet {
    /// Active bound of each unknown, n.
    pub unknowns: Vec<Option<Side>>,
    /// Active bound of each row.
    pub rows: Vec<Option<Side>>,
}

impl WorkingSet {
    /// Removes all active bounds and resizes.
    pub fn clear(&mut self, unknowns: usize, rows: usize) {
        refill(&mut self.unknowns, std::iter::repeat_n(None, unknowns));
        refill(&mut self.rows, std::iter::repeat_n(None, rows));
    }

    /// Copies another set without giving up the memory of this one.
    pub fn copy_from(&mut self, other: &Self) {
        self.unknowns.clone_from(&other.unknowns);
        self.rows.clone_from(&other.rows);
    }

    /// Returns whether no bound is active.
    pub fn is_empty(&self) -> bool {
        self.unknowns.iter().all(Option::is_none) && self.rows.iter().all(Option::is_none)
    }
}

/// Where the search for a working set begins.
#[derive(Debug, Clone, Copy, Default)]
pub struct Start<'a> {
    /// A guess; without one, the search begins without active bounds.
    pub guess: Option<&'a WorkingSet>,
    /// Whether the problem is the one that was factorised last, without its limits. The search then begins without active
    /// bounds if that is already the answer.
    pub is_factorized: bool,
}

/// How sure a solution is, and how it was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certainty {
    /// Whether the optimality conditions hold.
    pub is_optimal: bool,
    /// Whether rounding may have decided a rank.
    pub rank_uncertain: bool,
    /// Largest relative residual of the optimality conditions.
    pub kkt_residual: f64,
    /// Working sets that were tried.
    pub working_sets: u32,
}

impl Default for Certainty {
    fn default() -> Self {
        Self { is_optimal: true, rank_uncertain: false, kkt_residual: 0.0, working_sets: 0 }
    }
}

impl Certainty {
    /// Returns whether the optimality conditions hold up to a residual that is certified.
    pub fn is_certified(&self) -> bool {
        self.is_optimal && self.kkt_residual <= TOLERANCES.certified
    }

    /// Returns whether another solution is less sure.
    pub fn is_better_than(&self, other: &Self) -> bool {
        (self.is_optimal, other.kkt_residual) > (other.is_optimal, self.kkt_residual)
    }

    /// Adds that of another solution on the way to the same answer.
    pub fn add(&mut self, other: &Self) {
        self.is_optimal &= other.is_optimal;
        self.rank_uncertain |= other.rank_uncertain;
        self.kkt_residual = self.kkt_residual.max(other.kkt_residual);
        self.working_sets += other.working_sets;
    }
}

/// The solution of a [`Hierarchy`](super::hierarchy::Hierarchy) with its optimality conditions evaluated.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Solution {
    /// x, n, inside the box.
    pub x: Vec<f64>,
    /// a·x of each row.
    pub row_values: Vec<f64>,
    /// The working set that x was computed on.
    pub working_set: WorkingSet,
    /// Multiplier of each unknown's active bound at the first level where it is not zero; positive at upper bounds, negative
    /// at lower bounds if the bound holds x back.
    pub multipliers: Vec<f64>,
    /// The same for each active inequality row.
    pub row_multipliers: Vec<f64>,
    pub certainty: Certainty,
    /// Whether the last resort found the working set.
    pub is_last_resort: bool,
}

impl Solution {
    /// Copies another solution without giving up the memory of this one.
    pub fn copy_from(&mut self, other: &Self) {
        self.x.clone_from(&other.x);
        self.row_values.clone_from(&other.row_values);
        self.working_set.copy_from(&other.working_set);
        self.multipliers.clone_from(&other.multipliers);
        self.row_multipliers.clone_from(&other.row_multipliers);
        (self.certainty, self.is_last_resort) = (other.certainty, other.is_last_resort);
    }

    /// Returns whether a bound holds x back.
    pub fn is_held_back(&self) -> bool {
        self.multipliers.iter().chain(&self.row_multipliers).any(|multiplier| *multiplier != 0.0)
    }
}

/// Overwrites a list without giving up its memory.
pub fn refill<T>(list: &mut Vec<T>, entries: impl IntoIterator<Item = T>) {
    list.clear();
    list.extend(entries);
}
