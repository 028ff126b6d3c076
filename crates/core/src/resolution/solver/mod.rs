//! The hierarchical solver: lexicographic least squares within a box by an active-set method.
//!
//! It tries working sets until the optimality conditions hold. `docs/solver.md` explains the method; the sections named here
//! are those of that page. The answer is exact: no regularisation and no weights enter it.

mod conditions;
mod dependent_rows;
mod factorization;
mod primal;
mod problem_rows;
#[cfg(test)]
mod random_sets;
mod search;
mod sized;

pub use sized::{HierarchicalSolver, SizedSolver};

use conditions::{Conditions, Trial};
use factorization::{Factorization, ROUNDING, Span};
use primal::PrimalPoint;
use problem_rows::ProblemRows;
use search::Search;

use revprio_problem::Side;

use super::level::{Hierarchy, Solution, WorkingSet, refill};
use crate::linalg::{RANK_TOLERANCE, Row, SingularValues, all_finite};

/// Ratios of the weights of adjacent levels while the search looks for a working set.
const SPACINGS: [f64; 2] = [1e-6, 1e-4];

/// Relative sizes that count as rounding where working sets repeat: a smaller one where rows nearly depend on each other, so
/// that multipliers are small, and larger ones where several sets describe the same corner.
const OTHER_ROUNDINGS: [f64; 5] = [5e-15, 1e-12, 1e-11, 1e-10, 1e-9];

/// Singular values below this fraction of ‖A_k‖ count as zero where rounding may decide ranks and the smaller tolerance finds
/// no certain answer.
const UNCERTAIN_RANK_TOLERANCES: [f64; 2] = [1e-8, 1e-6];

/// Trials near a guess, where everything that is wrong changes at once, before the search starts from the empty set.
const GUESSED_TRIALS: u32 = 3;

/// Times that a proposal with wrong bounds is corrected, by releasing joints or by a search that goes on from it.
const MAX_COMPLETIONS: u32 = 8;

/// Bounds that are wrong in a proposal that the primal method corrects; with more, the search tries other weights.
const NEARLY_RIGHT: usize = 3;

/// The solver for problems of up to N unknowns; it keeps its memory from call to call.
#[derive(Debug, Default)]
pub struct ActiveSetSolver<const N: usize> {
    problem: ProblemRows<N>,
    /// Whether rows, levels or reference are not those of the last factorisation.
    has_new_rows: bool,
    set: WorkingSet,
    solved: Factorization<N>,
    conditions: Conditions<N>,
    search: Search<N>,
    primal: PrimalPoint<N>,
    /// Room for what is asked about the last factorisation: the inverse triangle and its Gram matrix, and singular values.
    inverse: Vec<Row<N>>,
    gram: Vec<Row<N>>,
    singular: SingularValues,
}

/// How the next working set is found.
#[derive(PartialEq)]
enum Phase {
    /// By the search, or by correcting all that is wrong.
    Guess,
    /// By steps of the primal method.
    Primal,
    /// By the least wrong index alone (Murty), which is finite.
    LeastIndex,
}

impl<const N: usize> ActiveSetSolver<N> {
    /// Solves the problem from the working set `guess` on, in at most `max_sets` sets per attempt (section 6).
    ///
    /// Where rounding may have decided a rank, several working sets can look right. The answer then comes from the empty set,
    /// whatever the guess is, and from a larger tolerance for ranks if the conditions do not hold.
    pub fn solve(&mut self, problem: &Hierarchy, guess: Option<&WorkingSet>, max_sets: u32, solution: &mut Solution) {
        self.has_new_rows |= !self.problem.load(problem);
        self.solve_loaded(guess, max_sets, solution);
    }

    fn solve_loaded(&mut self, guess: Option<&WorkingSet>, max_sets: u32, solution: &mut Solution) {
        // Without active bounds the factorisation of the same rows still holds. Pinned unknowns are held.
        let is_factorized = !self.has_new_rows
            && !self.problem.has_pinned
            && self.set.is_empty()
            && self.solved.held.is_empty()
            && self.solved.rank_tolerance == RANK_TOLERANCE;
        self.has_new_rows = false;
        self.solved.rank_tolerance = RANK_TOLERANCE;
        let mut met_uncertain_rank = self.solve_from(guess, is_factorized, max_sets, solution);
        let mut tried = solution.working_sets;
        let is_guessed = guess.is_some_and(|guess| !guess.is_empty());
        if is_guessed && (met_uncertain_rank || !solution.is_optimal) {
            met_uncertain_rank = self.solve_from(None, false, max_sets, solution);
            tried += solution.working_sets;
        }
        for tolerance in UNCERTAIN_RANK_TOLERANCES {
            if solution.is_optimal || !met_uncertain_rank || solution.working_sets >= max_sets {
                break;
            }
            self.solved.rank_tolerance = tolerance;
            self.solve_from(None, false, max_sets, solution);
            tried += solution.working_sets;
            solution.rank_uncertain = true;
        }
        solution.working_sets = tried;
    }

    /// Factorises the rows of the problem without active bounds.
    fn solve_without_bounds(&mut self) {
        self.solved.rank_tolerance = RANK_TOLERANCE;
        self.start_from(None);
        self.solved.solve(&self.problem, &self.set);
        self.has_new_rows = false;
    }

    /// Evaluates the optimality conditions on the last working set; returns whether they hold, and the largest relative residual.
    fn certify(&mut self) -> (bool, f64) {
        let Self { problem, set, solved, conditions, .. } = self;
        conditions.evaluate(Trial { problem, set, solved }, ROUNDING);
        (conditions.are_met() && all_finite(&solved.x.0), conditions.residual)
    }

    /// Solves the problem with one tolerance for ranks; returns whether a working set on the way had an uncertain rank.
    /// `is_factorized`: the last factorisation is that of the empty set of this problem.
    fn solve_from(
        &mut self,
        guess: Option<&WorkingSet>,
        is_factorized: bool,
        max_sets: u32,
        solution: &mut Solution,
    ) -> bool {
        self.start_from(guess);
        let mut met_uncertain_rank = false;
        let constraints = self.problem.unknowns + self.problem.rows.len();
        let max_sets = u32::try_from(40 * constraints + 50).unwrap_or(u32::MAX).min(max_sets);
        let mut phase = Phase::Guess;
        let (mut tried, mut searches, mut completions) = (0, 0, 0);
        let (mut rounding, mut roundings) = (ROUNDING, OTHER_ROUNDINGS.into_iter());
        loop {
            tried += 1;
            if !(is_factorized && tried == 1 && self.set.is_empty()) {
                self.solved.solve(&self.problem, &self.set);
            }
            met_uncertain_rank |= self.solved.rank_uncertain;
            let Self { problem, set, solved, conditions, .. } = &mut *self;
            let trial = Trial { problem, set, solved };
            conditions.check_point(trial, rounding);
            // Nothing is active: the dual method proposes a set, and asks for broken bounds only.
            let may_propose = phase == Phase::Guess && searches < SPACINGS.len() && set.is_empty();
            if may_propose && !conditions.are_met() {
                searches = self.propose(searches);
                continue;
            }
            conditions.check_levels(trial);
            if self.conditions.are_met() || tried >= max_sets {
                break;
            }
            match phase {
                // The proposal has wrong bounds, because the weights let the lowest level give way, or because rounding stopped it.
                Phase::Guess
                    if searches > 0 && completions < MAX_COMPLETIONS && self.problem.inequalities.is_empty() =>
                {
                    completions += 1;
                    if !self.release_wrong() {
                        self.propose(0);
                    }
                }
                // A guess from the call before: most are wrong in one place or two.
                Phase::Guess if searches == 0 && tried < GUESSED_TRIALS => self.correct_all(),
                // The guess is of no use, or the weights of the first proposal were too far apart: the search starts again.
                Phase::Guess
                    if searches < SPACINGS.len() && !self.set.is_empty() && !self.is_nearly_right(searches) =>
                {
                    self.set.clear(self.problem.unknowns, self.problem.rows.len());
                }
                Phase::LeastIndex => self.correct_least(),
                _ => {
                    if phase == Phase::Guess {
                        phase = Phase::Primal;
                        self.primal.clear();
                    }
                    let Self { problem, solved, conditions, set, primal, .. } = self;
                    primal.step(problem, solved, conditions, set);
                    if self.primal.steps > 2 * constraints {
                        // Sets repeat where rounding decides what is wrong: another size may count as rounding.
                        match roundings.next() {
                            Some(other) => rounding = other,
                            None => phase = Phase::LeastIndex,
                        }
                        self.primal.steps = 0;
                    }
                }
            }
        }
        self.write(solution, tried);
        met_uncertain_rank
    }

    /// Takes over the bounds of a guess that this problem has.
    fn start_from(&mut self, guess: Option<&WorkingSet>) {
        let Self { problem, set, .. } = self;
        set.clear(problem.unknowns, problem.rows.len());
        let Some(guess) = guess else { return };
        let exists = |side: Side, lower: f64, upper: f64| match side {
            Side::Lower => lower.is_finite(),
            Side::Upper => upper.is_finite(),
        };
        for (j, side) in guess.unknowns.iter().enumerate().take(problem.unknowns) {
            let known = |side: &Side| !problem.is_pinned(j) && exists(*side, problem.lower.0[j], problem.upper.0[j]);
            set.unknowns[j] = side.filter(known);
        }
        for &row in problem.inequalities.iter().filter(|&&row| row < guess.rows.len()) {
            let known = |side: &Side| exists(*side, problem.rows[row].lower, problem.rows[row].upper);
            set.rows[row] = guess.rows[row].filter(known);
        }
    }

    /// Searches for a set with one spacing, or with the next one where rounding stops the first; returns how many were used.
    fn propose(&mut self, used: usize) -> usize {
        let Self { problem, solved, set, search, .. } = self;
        if search.propose(problem, solved, SPACINGS[used], set) || used + 1 == SPACINGS.len() {
            return used + 1;
        }
        search.propose(problem, solved, SPACINGS[used + 1], set);
        used + 2
    }

    /// Releases the unknowns whose multipliers point inwards; returns whether there is one.
    fn release_wrong(&mut self) -> bool {
        let held = |set: &WorkingSet, j: usize| set.unknowns[j].is_some();
        let found = self.conditions.wrong.iter().any(|&j| held(&self.set, j));
        for &j in self.conditions.wrong.iter().filter(|_| found) {
            self.set.unknowns[j] = None;
        }
        found
    }

    /// Returns whether the set is a proposal that a few steps of the primal method correct.
    fn is_nearly_right(&self, searches: usize) -> bool {
        searches > 0 && self.conditions.wrong.len() + self.conditions.wrong_rows.len() <= NEARLY_RIGHT
    }

    /// Changes everything that is wrong.
    fn correct_all(&mut self) {
        for at in 0..self.conditions.wrong.len() {
            self.correct_unknown(self.conditions.wrong[at]);
        }
        for at in 0..self.conditions.wrong_rows.len() {
            self.correct_row(self.conditions.wrong_rows[at]);
        }
    }

    /// Changes the wrong bound with the least index.
    fn correct_least(&mut self) {
        match (self.conditions.wrong.iter().min(), self.conditions.wrong_rows.iter().min()) {
            (Some(&unknown), _) => self.correct_unknown(unknown),
            (None, Some(&row)) => self.correct_row(row),
            (None, None) => {}
        }
    }

    fn correct_unknown(&mut self, j: usize) {
        let is_above = self.solved.x.0[j] > self.problem.upper.0[j];
        self.set.unknowns[j] = corrected(self.set.unknowns[j], is_above);
    }

    fn correct_row(&mut self, row: usize) {
        let is_above = self.conditions.values[row] > self.problem.rows[row].upper;
        self.set.rows[row] = corrected(self.set.rows[row], is_above);
    }

    /// Writes the answer; the box holds to the last bit.
    fn write(&mut self, solution: &mut Solution, tried: u32) {
        let Self { problem, set, solved, conditions, .. } = self;
        let x = solved.x.clamp(&problem.lower, &problem.upper);
        let n = problem.unknowns;
        refill(&mut solution.x, x.0[..n].iter().copied());
        solution.row_values.clone_from(&conditions.values);
        solution.working_set.unknowns.clone_from(&set.unknowns);
        solution.working_set.rows.clone_from(&set.rows);
        refill(&mut solution.multipliers, conditions.multipliers.0[..n].iter().copied());
        solution.row_multipliers.clone_from(&conditions.row_multipliers);
        solution.is_optimal = conditions.are_met() && all_finite(&x.0);
        solution.kkt_residual = conditions.residual;
        solution.working_sets = tried;
        refill(&mut solution.level_ranks, self.solved.spans.iter().map(Span::rank));
        solution.rank_uncertain = self.solved.rank_uncertain;
    }
}

/// Returns the opposite: inactive for an active bound, the broken bound for an inactive one.
fn corrected(side: Option<Side>, is_above: bool) -> Option<Side> {
    match side {
        Some(_) => None,
        None if is_above => Some(Side::Upper),
        None => Some(Side::Lower),
    }
}
