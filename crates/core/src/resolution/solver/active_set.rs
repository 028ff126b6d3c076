//! The search for the right working set: from set to set until the optimality conditions hold (section 6 of `docs/solver.md`).

use super::cascade::Cascade;
use super::conditions::{Conditions, Trial};
use super::factorization::Factorization;
use super::problem_rows::ProblemRows;
use super::rungs::{Rung, Rungs};
use super::search::Search;
use crate::linalg::{Row, all_finite};
use crate::resolution::Side;
use crate::resolution::solution::{Certainty, Solution, Start, WorkingSet, refill};
use crate::tolerances::TOLERANCES;

/// Trials near a guess, where everything that is wrong changes at once, before a set is proposed.
const GUESSED_TRIALS: u32 = 3;

/// Sets of the last resort after which the cascade proposes one, if it has not yet.
const CORRECTIONS_BEFORE_CASCADE: u32 = 40;

/// How often all sizes that may count as rounding are tried in the last resort.
const TURNS: usize = 2;

/// Working sets after which an attempt gives up: the most of them, and the fewest where each is expensive.
const MAX_SETS: u32 = 400;
const LEAST_SETS: u32 = 10;

/// Work after which it gives up, in entries of the rows of all its sets: ten sets of 512 rows and 32 unknowns.
const MAX_WORK: usize = 200_000;

/// Returns the number of working sets after which an attempt gives up.
fn most_sets(unknowns: usize, rows: usize) -> u32 {
    let work = (unknowns * (unknowns + rows)).max(1);
    u32::try_from(MAX_WORK / work).map_or(MAX_SETS, |sets| sets.clamp(LEAST_SETS, MAX_SETS))
}

/// The solver for problems of up to N unknowns; it keeps its memory from call to call.
#[derive(Debug, Default)]
pub struct ActiveSetSolver<const N: usize> {
    set: WorkingSet,
    /// The last factorisation.
    pub solved: Factorization<N>,
    /// The conditions on it.
    pub conditions: Conditions<N>,
    search: Search<N>,
    cascade: Cascade<N>,
    /// Where the cascade ended in this attempt.
    cascade_point: Option<Row<N>>,
    /// Sets of the last resort in this attempt, the fewest wrong bounds of one of them, one of them to notice that they repeat, and
    /// how often they did.
    corrections: u32,
    fewest_wrong: usize,
    mark: WorkingSet,
    repetitions: usize,
    /// The inverse of the triangle, to bound its singular values.
    pub inverse: Vec<Row<N>>,
    /// How often each way to a working set was needed so far.
    pub rungs: Rungs,
}

impl<const N: usize> ActiveSetSolver<N> {
    /// Solves the problem from a working set on (section 6).
    ///
    /// Where rounding may have decided a rank, several working sets can look right. The answer then comes from the empty set,
    /// whatever the guess is. If it is not certified, other tolerances for ranks are tried, and the best answer counts.
    pub fn solve_rows(&mut self, problem: &ProblemRows<N>, start: Start, solution: &mut Solution) {
        if self.rungs[Rung::Start].tried > 0 {
            // A solver of one problem alone seldom needs this memory.
            self.cascade.reserve(problem.unknowns, problem.rows.len());
        }
        self.solved.rank_tolerance = TOLERANCES.rank;
        solution.is_last_resort = false;
        let guess = start.guess.filter(|guess| !guess.is_empty());
        let (rung, mut met_uncertain_rank) = self.attempt(problem, guess, start.is_factorized, solution);
        let mut tried = solution.certainty.working_sets;
        // All other ways begin with the empty set.
        if guess.is_some() && met_uncertain_rank && matches!(rung, Rung::Start | Rung::StartCorrected) {
            (_, met_uncertain_rank) = self.attempt(problem, None, false, solution);
            self.count_again(Rung::WithoutGuess, solution);
            tried += solution.certainty.working_sets;
        }
        let mut best = (TOLERANCES.rank, solution.certainty);
        for tolerance in TOLERANCES.uncertain_rank {
            if best.1.is_certified() || !met_uncertain_rank {
                break;
            }
            self.try_again(problem, tolerance, solution);
            tried += solution.certainty.working_sets;
            if solution.certainty.is_better_than(&best.1) {
                best = (tolerance, solution.certainty);
            }
        }
        if self.solved.rank_tolerance > best.0 {
            self.try_again(problem, best.0, solution);
            tried += solution.certainty.working_sets;
        }
        solution.certainty.working_sets = tried;
    }

    /// Solves the problem from the empty set with another tolerance for ranks.
    fn try_again(&mut self, problem: &ProblemRows<N>, tolerance: f64, solution: &mut Solution) {
        self.solved.rank_tolerance = tolerance;
        self.attempt(problem, None, false, solution);
        self.count_again(Rung::LargerRankTolerance, solution);
        solution.certainty.rank_uncertain = true;
    }

    /// Factorises the equations of a problem without limits, without active inequality rows.
    pub fn factorize_rows(&mut self, problem: &ProblemRows<N>) {
        self.solved.rank_tolerance = TOLERANCES.rank;
        self.set.clear(problem.unknowns, problem.rows.len());
        self.solved.solve(problem, &self.set);
    }

    /// Solves the problem with one tolerance for ranks; returns where the working set comes from, and whether one on the way had an
    /// uncertain rank.
    ///
    /// `is_factorized`: the last factorisation is that of the empty set of this problem, without pinned unknowns. That set is
    /// then the first candidate, and the guess the next one.
    fn attempt(
        &mut self,
        problem: &ProblemRows<N>,
        mut guess: Option<&WorkingSet>,
        is_factorized: bool,
        solution: &mut Solution,
    ) -> (Rung, bool) {
        // Pinned unknowns are held, so that the factorisation without limits does not fit.
        let mut is_factorized = is_factorized && !problem.has_pinned;
        debug_assert!(!is_factorized || self.solved.held.is_empty(), "another problem was factorised");
        self.start_from(problem, guess.filter(|_| !is_factorized));
        self.cascade_point = None;
        (self.corrections, self.fewest_wrong, self.repetitions) = (0, usize::MAX, 0);
        let most = most_sets(problem.unknowns, problem.rows.len());
        let (mut rung, mut tried, mut met_uncertain_rank) = (Rung::Start, 0, false);
        loop {
            tried += 1;
            self.rungs[rung].tried += 1;
            if !is_factorized {
                self.solved.solve(problem, &self.set);
            }
            met_uncertain_rank |= self.solved.rank_uncertain;
            let rounding = TOLERANCES.roundings[self.repetitions % TOLERANCES.roundings.len()];
            let Self { set, solved, conditions, .. } = &mut *self;
            let trial = Trial { problem, set, solved };
            conditions.check_point(trial, rounding);
            // Nothing is held and bounds are broken: multipliers are not needed to propose a set.
            let is_open = rung == Rung::Start && set.is_empty() && !conditions.are_met();
            if !is_open {
                conditions.check_levels(trial);
            }
            if self.conditions.are_met() || tried >= most || self.repetitions == TURNS * TOLERANCES.roundings.len() {
                break;
            }
            if let Some(guess) = guess.take_if(|_| is_factorized) {
                self.start_from(problem, Some(guess));
                (tried, met_uncertain_rank) = (0, false);
            } else {
                rung = self.next_set(problem, rung, is_open, tried);
            }
            is_factorized = false;
        }
        self.rungs[rung].answered += u64::from(self.conditions.are_met());
        self.write(problem, solution, tried);
        solution.is_last_resort |= rung == Rung::LastResort;
        (rung, met_uncertain_rank)
    }

    fn count_again(&mut self, rung: Rung, solution: &Solution) {
        self.rungs[rung].tried += u64::from(solution.certainty.working_sets);
        self.rungs[rung].answered += u64::from(solution.certainty.is_optimal);
    }

    /// Replaces a wrong working set by the next one; returns where it comes from. `is_open`: nothing is held.
    fn next_set(&mut self, problem: &ProblemRows<N>, rung: Rung, is_open: bool, tried: u32) -> Rung {
        match rung {
            // Most guesses are wrong in one place or two.
            Rung::Start | Rung::StartCorrected if !is_open && tried < GUESSED_TRIALS => {
                self.correct(problem, usize::MAX);
                Rung::StartCorrected
            }
            // The price of the search grows with the square of the inequality rows.
            Rung::Start | Rung::StartCorrected if problem.inequalities.len() <= problem.unknowns => {
                let Self { solved, set, search, .. } = self;
                if !is_open {
                    set.clear(problem.unknowns, problem.rows.len());
                    solved.solve(problem, set);
                }
                if search.propose(problem, solved, TOLERANCES.search_spacing, set) {
                    Rung::Search
                } else {
                    self.propose_by_cascade(problem)
                }
            }
            // Where rounding may decide a rank, the cascade may decide otherwise. It is asked after some corrections.
            Rung::Search if self.solved.rank_uncertain => self.correct_in_turn(problem),
            Rung::Start | Rung::StartCorrected | Rung::Search => self.propose_by_cascade(problem),
            Rung::LastResort if self.cascade_point.is_none() && self.corrections == CORRECTIONS_BEFORE_CASCADE => {
                self.propose_by_cascade(problem)
            }
            _ => self.correct_in_turn(problem),
        }
    }

    fn propose_by_cascade(&mut self, problem: &ProblemRows<N>) -> Rung {
        self.cascade_point = Some(self.cascade.propose(problem, &mut self.set));
        Rung::Cascade
    }

    /// Takes over the bounds of a guess that this problem has.
    fn start_from(&mut self, problem: &ProblemRows<N>, guess: Option<&WorkingSet>) {
        let set = &mut self.set;
        set.clear(problem.unknowns, problem.rows.len());
        let Some(guess) = guess else { return };
        for (j, side) in guess.unknowns.iter().enumerate().take(problem.unknowns) {
            let exists = |side: &Side| {
                let bound = if *side == Side::Lower { problem.lower.0[j] } else { problem.upper.0[j] };
                !problem.is_pinned(j) && bound.is_finite()
            };
            set.unknowns[j] = side.filter(exists);
        }
        for &row in problem.inequalities.iter().filter(|&&row| row < guess.rows.len()) {
            set.rows[row] = guess.rows[row].filter(|&side| problem.rows[row].bound(side).is_finite());
        }
    }

    /// The last resort: changes all wrong bounds if they are fewer than ever, and otherwise one alone, that of the highest level.
    ///
    /// Once sets repeat, it is the one with the least index, unknowns before rows (Murty's rule, which ends), and another size counts
    /// as rounding. One set is kept for comparison, and replaced after twice as many (Brent).
    fn correct_in_turn(&mut self, problem: &ProblemRows<N>) -> Rung {
        self.repetitions += usize::from(self.corrections > 0 && self.set == self.mark);
        self.corrections += 1;
        if self.corrections.is_power_of_two() {
            self.mark.copy_from(&self.set);
        }
        let wrong = self.conditions.wrong.len() + self.conditions.wrong_rows.len();
        if wrong < self.fewest_wrong {
            self.fewest_wrong = wrong;
            self.correct(problem, usize::MAX);
        } else {
            if self.repetitions > 0 {
                self.conditions.wrong.sort_unstable();
                self.conditions.wrong_rows.sort_unstable();
            }
            self.correct(problem, 1);
        }
        Rung::LastResort
    }

    /// Changes everything that is wrong, or the first `most` bounds.
    fn correct(&mut self, problem: &ProblemRows<N>, most: usize) {
        let Self { set, solved, conditions, .. } = self;
        for &j in conditions.wrong.iter().take(most) {
            set.unknowns[j] = corrected(set.unknowns[j], solved.x.0[j] > problem.upper.0[j]);
        }
        for &row in conditions.wrong_rows.iter().take(most.saturating_sub(conditions.wrong.len())) {
            set.rows[row] = corrected(set.rows[row], conditions.values[row] > problem.rows[row].upper);
        }
    }

    /// Writes the answer; the box holds to the last bit. Without a right working set, it is the point at which the cascade has
    /// ended: no level has lost what it reached for the sake of a lower one.
    fn write(&self, problem: &ProblemRows<N>, solution: &mut Solution, tried: u32) {
        let Self { set, solved, conditions, .. } = self;
        let x = self.cascade_point.filter(|_| !conditions.are_met()).unwrap_or(solved.x);
        let x = x.clamp(&problem.lower, &problem.upper);
        let n = problem.unknowns;
        refill(&mut solution.x, x.0[..n].iter().copied());
        if x == solved.x {
            solution.row_values.clone_from(&conditions.values);
        } else {
            refill(&mut solution.row_values, problem.coefficients.iter().map(|row| x.dot(row)));
        }
        solution.working_set.copy_from(set);
        refill(&mut solution.multipliers, conditions.multipliers.0[..n].iter().copied());
        solution.row_multipliers.clone_from(&conditions.row_multipliers);
        if self.cascade_point.is_some() && !conditions.are_met() {
            // They belong to another point.
            solution.multipliers.fill(0.0);
            solution.row_multipliers.fill(0.0);
        }
        solution.certainty = Certainty {
            is_optimal: conditions.are_met() && all_finite(&x.0),
            rank_uncertain: solved.rank_uncertain,
            kkt_residual: conditions.residual,
            working_sets: tried,
        };
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

#[cfg(test)]
mod tests;
