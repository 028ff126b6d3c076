//! The hierarchical solver: lexicographic least squares within a box by an active-set method.
//!
//! It tries working sets until the optimality conditions hold. `docs/solver.md` explains the method; the sections named here
//! are those of that page. The answer is exact: no regularisation and no weights enter it.

mod cascade;
mod conditions;
mod dependent_rows;
mod factorization;
mod primal;
mod problem_rows;
#[cfg(test)]
mod random_sets;
mod rungs;
mod search;
mod sized;

pub use rungs::{Rung, RungCount, Rungs};
pub use sized::{HierarchicalSolver, SizedSolver};

use cascade::Cascade;
use conditions::{Conditions, Trial};
use factorization::{Factorization, Span};
use primal::PrimalPoint;
use problem_rows::ProblemRows;
use search::Search;

use revprio_problem::Side;

use super::level::{Hierarchy, Solution, Start, WorkingSet, refill};
use crate::linalg::{Row, SingularValues, all_finite};
use crate::tolerances::TOLERANCES;

/// Trials near a guess, where everything that is wrong changes at once, before a set is proposed.
const GUESSED_TRIALS: u32 = 3;

/// Corrections of everything that is wrong in the proposal of the cascade, before the last resort. One is needed where rounding
/// decides whether a bound that is met exactly is active.
const MAX_CORRECTIONS: u32 = 3;

/// Working sets after which the solver gives up.
const MAX_SETS: u32 = 400;

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
    cascade: Cascade<N>,
    primal: PrimalPoint<N>,
    rungs: Rungs,
    /// Room for what is asked about the last factorisation: the inverse triangle and its Gram matrix, and singular values.
    inverse: Vec<Row<N>>,
    gram: Vec<Row<N>>,
    singular: SingularValues,
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
    pub fn solve(&mut self, problem: &Hierarchy, start: Start, solution: &mut Solution) {
        if let Start::Factorized(_) = start {
            self.problem.set_box(&problem.lower, &problem.upper);
            debug_assert!(self.problem.has_rows_of(problem), "another problem was factorised");
        } else {
            self.load(problem);
        }
        self.cascade.reserve(problem.unknowns, problem.row_count());
        // Without active bounds the factorisation of the same rows still holds. Pinned unknowns are held.
        let is_factorized = !self.has_new_rows
            && !self.problem.has_pinned
            && self.set.is_empty()
            && self.solved.held.is_empty()
            && self.solved.rank_tolerance == TOLERANCES.rank;
        self.has_new_rows = false;
        self.solved.rank_tolerance = TOLERANCES.rank;
        let guess = match start {
            Start::Empty => None,
            Start::Factorized(_) if is_factorized && self.holds_nothing(solution) => return,
            Start::Guess(guess) | Start::Factorized(guess) => Some(guess).filter(|guess| !guess.is_empty()),
        };
        let mut met_uncertain_rank = self.solve_from(guess, is_factorized, solution);
        let mut tried = solution.working_sets;
        if guess.is_some() && (met_uncertain_rank || !solution.is_optimal) {
            met_uncertain_rank = self.solve_from(None, false, solution);
            self.count_again(Rung::WithoutGuess, solution);
            tried += solution.working_sets;
        }
        for tolerance in TOLERANCES.uncertain_rank {
            if solution.is_optimal || !met_uncertain_rank {
                break;
            }
            self.solved.rank_tolerance = tolerance;
            self.solve_from(None, false, solution);
            self.count_again(Rung::LargerRankTolerance, solution);
            tried += solution.working_sets;
            solution.rank_uncertain = true;
        }
        solution.working_sets = tried;
    }

    /// Factorises the equations of a problem, without its limits and without active inequality rows.
    pub fn factorize(&mut self, problem: &Hierarchy) {
        self.load(problem);
        self.problem.open_box();
        self.solved.rank_tolerance = TOLERANCES.rank;
        self.set.clear(problem.unknowns, problem.row_count());
        self.solved.solve(&self.problem, &self.set);
        self.has_new_rows = false;
    }

    fn load(&mut self, problem: &Hierarchy) {
        self.has_new_rows |= !self.problem.load(problem);
    }

    /// Returns whether the empty set, which is factorised, is the right one. The answer is then written.
    fn holds_nothing(&mut self, solution: &mut Solution) -> bool {
        let Self { problem, set, solved, conditions, .. } = self;
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
            self.write(solution, 1);
            solution.is_last_resort = false;
        }
        is_right
    }

    /// Solves the problem with one tolerance for ranks; returns whether a working set on the way had an uncertain rank.
    /// `is_factorized`: the last factorisation is that of the empty set of this problem.
    fn solve_from(&mut self, guess: Option<&WorkingSet>, is_factorized: bool, solution: &mut Solution) -> bool {
        self.start_from(guess);
        let (mut source, mut tried, mut met_uncertain_rank) = (Source::Guess, 0, false);
        loop {
            tried += 1;
            self.count(source, tried);
            if !(is_factorized && tried == 1 && self.set.is_empty()) {
                self.solved.solve(&self.problem, &self.set);
            }
            met_uncertain_rank |= self.solved.rank_uncertain;
            let Self { problem, set, solved, conditions, .. } = &mut *self;
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
                if self.conditions.are_met() || tried >= MAX_SETS {
                    break;
                }
            }
            source = self.next_set(source, is_open, tried);
        }
        if self.conditions.are_met() {
            self.rungs[source.rung(tried)].answered += 1;
        }
        self.write(solution, tried);
        solution.is_last_resort = matches!(source, Source::Primal(_));
        met_uncertain_rank
    }

    fn count(&mut self, source: Source, tried: u32) {
        self.rungs[source.rung(tried)].tried += 1;
    }

    fn count_again(&mut self, rung: Rung, solution: &Solution) {
        self.rungs[rung].tried += u64::from(solution.working_sets);
        self.rungs[rung].answered += u64::from(solution.is_optimal);
    }

    /// Replaces a wrong working set by the next one. `is_open`: nothing is held.
    fn next_set(&mut self, source: Source, is_open: bool, tried: u32) -> Source {
        match source {
            // Most guesses are wrong in one place or two.
            Source::Guess if !is_open && tried < GUESSED_TRIALS => {
                self.correct_all();
                Source::Guess
            }
            Source::Guess if self.is_searched() => {
                if !is_open {
                    self.set.clear(self.problem.unknowns, self.problem.rows.len());
                    self.solved.solve(&self.problem, &self.set);
                }
                let Self { problem, solved, set, search, .. } = self;
                if search.propose(problem, solved, TOLERANCES.search_spacing, set) {
                    Source::Search
                } else {
                    self.cascade()
                }
            }
            // Where rounding may decide a rank, the cascade may decide otherwise.
            Source::Search if self.solved.rank_uncertain => self.start_primal(),
            Source::Guess | Source::Search => self.cascade(),
            Source::Cascade(corrections) if corrections < MAX_CORRECTIONS => {
                self.correct_all();
                Source::Cascade(corrections + 1)
            }
            Source::Cascade(_) => self.start_primal(),
            // Sets repeat: another size may count as rounding.
            Source::Primal(used)
                if self.primal.steps > self.most_primal_steps() && used < TOLERANCES.other_roundings.len() =>
            {
                self.primal.steps = 0;
                self.step_primal();
                Source::Primal(used + 1)
            }
            Source::Primal(used) => {
                self.step_primal();
                Source::Primal(used)
            }
        }
    }

    fn cascade(&mut self) -> Source {
        self.cascade.propose(&self.problem, &mut self.set);
        Source::Cascade(0)
    }

    /// Begins the last resort: one change at a time.
    fn start_primal(&mut self) -> Source {
        self.primal.clear();
        self.step_primal();
        Source::Primal(0)
    }

    fn step_primal(&mut self) {
        let Self { problem, solved, conditions, set, primal, .. } = self;
        primal.step(problem, solved, conditions, set);
    }

    fn most_primal_steps(&self) -> usize {
        2 * (self.problem.unknowns + self.problem.rows.len())
    }

    /// Returns whether the search is worth its price: it grows with the square of the inequality rows.
    fn is_searched(&self) -> bool {
        self.problem.inequalities.len() <= self.problem.unknowns
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

    /// Changes everything that is wrong.
    fn correct_all(&mut self) {
        for at in 0..self.conditions.wrong.len() {
            self.correct_unknown(self.conditions.wrong[at]);
        }
        for at in 0..self.conditions.wrong_rows.len() {
            self.correct_row(self.conditions.wrong_rows[at]);
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
        if x == solved.x {
            solution.row_values.clone_from(&conditions.values);
        } else {
            refill(&mut solution.row_values, problem.rows.iter().map(|row| row.coefficients.dot(&x)));
        }
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
