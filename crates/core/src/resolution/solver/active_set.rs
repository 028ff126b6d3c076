//! The search for the right working set: from set to set until the optimality conditions hold (section 6 of `docs/solver.md`).

use super::cascade::Cascade;
use super::conditions::{Conditions, Trial};
use super::factorization::Factorization;
use super::primal::PrimalPoint;
use super::problem_rows::ProblemRows;
use super::rungs::{Rung, Rungs};
use super::search::Search;
use crate::linalg::{Row, all_finite};
use crate::resolution::Side;
use crate::resolution::solution::{Certainty, Solution, Start, WorkingSet, refill};
use crate::tolerances::TOLERANCES;

/// Trials near a guess, where everything that is wrong changes at once, before a set is proposed.
const GUESSED_TRIALS: u32 = 3;

/// Corrections of everything that is wrong in the proposal of the cascade, before the last resort. One is needed where rounding
/// decides whether a bound that is met exactly is active.
const MAX_CORRECTIONS: u32 = 3;

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
    primal: PrimalPoint<N>,
    /// How often each way to a working set was needed so far.
    pub rungs: Rungs,
}

/// Where a working set comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    /// From the call before, corrected at most twice; or nothing is held.
    Guess,
    /// From the search.
    Search,
    /// From the cascade, corrected as many times.
    Cascade(u32),
    /// From steps of the primal method, with as many of [`TOLERANCES.other_roundings`] used up.
    Primal(usize),
}

impl Source {
    /// Returns what a working set counts as; `tried`: sets so far.
    fn rung(self, tried: u32) -> Rung {
        match self {
            Self::Guess if tried <= 1 => Rung::Start,
            Self::Guess => Rung::StartCorrected,
            Self::Search => Rung::Search,
            Self::Cascade(0) => Rung::Cascade,
            Self::Cascade(_) => Rung::CascadeCorrected,
            Self::Primal(0) => Rung::LastResort,
            Self::Primal(_) => Rung::OtherRounding,
        }
    }
}

impl<const N: usize> ActiveSetSolver<N> {
    /// Solves the problem from a working set on (section 6).
    ///
    /// Where rounding may have decided a rank, several working sets can look right. The answer then comes from the empty set,
    /// whatever the guess is, and from a larger tolerance for ranks if the conditions do not hold.
    pub fn solve(&mut self, problem: &ProblemRows<N>, start: Start, solution: &mut Solution) {
        self.cascade.reserve(problem.unknowns, problem.rows.len());
        self.solved.rank_tolerance = TOLERANCES.rank;
        // Pinned unknowns are held, so that the factorisation without limits does not fit.
        let is_factorized = start.is_factorized && !problem.has_pinned;
        debug_assert!(!is_factorized || self.solved.held.is_empty(), "another problem was factorised");
        if is_factorized && self.holds_nothing(problem, solution) {
            return;
        }
        let guess = start.guess.filter(|guess| !guess.is_empty());
        let mut met_uncertain_rank = self.solve_from(problem, guess, is_factorized, solution);
        let mut tried = solution.certainty.working_sets;
        if guess.is_some() && (met_uncertain_rank || !solution.certainty.is_optimal) {
            met_uncertain_rank = self.solve_from(problem, None, false, solution);
            self.count_again(Rung::WithoutGuess, solution);
            tried += solution.certainty.working_sets;
        }
        for tolerance in TOLERANCES.uncertain_rank {
            if solution.certainty.is_optimal || !met_uncertain_rank {
                break;
            }
            self.solved.rank_tolerance = tolerance;
            self.solve_from(problem, None, false, solution);
            self.count_again(Rung::LargerRankTolerance, solution);
            tried += solution.certainty.working_sets;
            solution.certainty.rank_uncertain = true;
        }
        solution.certainty.working_sets = tried;
    }

    /// Factorises the equations of a problem without limits, without active inequality rows.
    pub fn factorize(&mut self, problem: &ProblemRows<N>) {
        self.solved.rank_tolerance = TOLERANCES.rank;
        self.set.clear(problem.unknowns, problem.rows.len());
        self.solved.solve(problem, &self.set);
    }

    /// Returns whether the empty set, which is factorised, is the right one. The answer is then written.
    fn holds_nothing(&mut self, problem: &ProblemRows<N>, solution: &mut Solution) -> bool {
        let Self { set, solved, conditions, .. } = self;
        let trial = Trial { problem, set, solved };
        conditions.check_point(trial, TOLERANCES.rounding);
        if !conditions.are_met() {
            return false;
        }
        conditions.check_levels(trial);
        let is_right = conditions.are_met();
        if is_right {
            self.count(Source::Guess, 1);
            self.rungs[Rung::Start].answered += 1;
            self.write(problem, solution, 1);
            solution.is_last_resort = false;
        }
        is_right
    }

    /// Solves the problem with one tolerance for ranks; returns whether a working set on the way had an uncertain rank.
    /// `is_factorized`: the last factorisation is that of the empty set of this problem.
    fn solve_from(
        &mut self,
        problem: &ProblemRows<N>,
        guess: Option<&WorkingSet>,
        is_factorized: bool,
        solution: &mut Solution,
    ) -> bool {
        self.start_from(problem, guess);
        self.cascade_point = None;
        let most = most_sets(problem.unknowns, problem.rows.len());
        let (mut source, mut tried, mut met_uncertain_rank) = (Source::Guess, 0, false);
        loop {
            tried += 1;
            self.count(source, tried);
            if !(is_factorized && tried == 1 && self.set.is_empty()) {
                self.solved.solve(problem, &self.set);
            }
            met_uncertain_rank |= self.solved.rank_uncertain;
            let Self { set, solved, conditions, .. } = &mut *self;
            let trial = Trial { problem, set, solved };
            let rounding = match source {
                Source::Primal(used @ 1..) => {
                    TOLERANCES.other_roundings[(used - 1).min(TOLERANCES.other_roundings.len() - 1)]
                }
                _ => TOLERANCES.rounding,
            };
            conditions.check_point(trial, rounding);
            // Nothing is held and bounds are broken: multipliers are not needed to propose a set.
            let is_open = source == Source::Guess && set.is_empty() && !conditions.are_met();
            if !is_open {
                conditions.check_levels(trial);
                if self.conditions.are_met() || tried >= most {
                    break;
                }
            }
            source = self.next_set(problem, source, is_open, tried);
        }
        if self.conditions.are_met() {
            self.rungs[source.rung(tried)].answered += 1;
        }
        self.write(problem, solution, tried);
        solution.is_last_resort = matches!(source, Source::Primal(_));
        met_uncertain_rank
    }

    fn count(&mut self, source: Source, tried: u32) {
        self.rungs[source.rung(tried)].tried += 1;
    }

    fn count_again(&mut self, rung: Rung, solution: &Solution) {
        self.rungs[rung].tried += u64::from(solution.certainty.working_sets);
        self.rungs[rung].answered += u64::from(solution.certainty.is_optimal);
    }

    /// Replaces a wrong working set by the next one. `is_open`: nothing is held.
    fn next_set(&mut self, problem: &ProblemRows<N>, source: Source, is_open: bool, tried: u32) -> Source {
        match source {
            // Most guesses are wrong in one place or two.
            Source::Guess if !is_open && tried < GUESSED_TRIALS => {
                self.correct_all(problem);
                Source::Guess
            }
            // The price of the search grows with the square of the inequality rows.
            Source::Guess if problem.inequalities.len() <= problem.unknowns => {
                let Self { solved, set, search, .. } = self;
                if !is_open {
                    set.clear(problem.unknowns, problem.rows.len());
                    solved.solve(problem, set);
                }
                if search.propose(problem, solved, TOLERANCES.search_spacing, set) {
                    Source::Search
                } else {
                    self.start_cascade(problem)
                }
            }
            // Where rounding may decide a rank, the cascade may decide otherwise.
            Source::Search if self.solved.rank_uncertain => self.start_primal(problem),
            Source::Guess | Source::Search => self.start_cascade(problem),
            Source::Cascade(corrections) if corrections < MAX_CORRECTIONS => {
                self.correct_all(problem);
                Source::Cascade(corrections + 1)
            }
            Source::Cascade(_) => self.start_primal(problem),
            Source::Primal(used) => {
                // Where sets repeat, another size may count as rounding.
                let changes = used < TOLERANCES.other_roundings.len() && self.primal.repeats(&self.set);
                if changes {
                    self.primal.forget_sets();
                }
                self.step_primal(problem);
                Source::Primal(used + usize::from(changes))
            }
        }
    }

    fn start_cascade(&mut self, problem: &ProblemRows<N>) -> Source {
        self.cascade_point = Some(self.cascade.propose(problem, &mut self.set));
        Source::Cascade(0)
    }

    /// Begins the last resort: one change at a time.
    fn start_primal(&mut self, problem: &ProblemRows<N>) -> Source {
        self.primal.clear();
        self.step_primal(problem);
        Source::Primal(0)
    }

    fn step_primal(&mut self, problem: &ProblemRows<N>) {
        let Self { solved, conditions, set, primal, .. } = self;
        primal.step(problem, solved, conditions, set);
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

    /// Changes everything that is wrong.
    fn correct_all(&mut self, problem: &ProblemRows<N>) {
        let Self { set, solved, conditions, .. } = self;
        for &j in &conditions.wrong {
            set.unknowns[j] = corrected(set.unknowns[j], solved.x.0[j] > problem.upper.0[j]);
        }
        for &row in &conditions.wrong_rows {
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
