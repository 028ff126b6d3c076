//! Answers that keep some levels exactly and reach for the others as far as damping lets them.

use revprio_problem::Damping;

use super::engine::Engine;
use super::hierarchy::{Demand, Hierarchy};
use super::regularity::{HALF_WIDTH, WIDEST};
use super::solution::{Certainty, Solution, Start, WorkingSet, refill};

/// Weight of a level that has been reached for, relative to the level that is reached for next.
const KEPT: f64 = 60.0;

/// Weight of the highest task while it is reached for, relative to that of a lower task.
const FIRST: f64 = 2.0;

/// Work of all problems of one answer, in entries of rows, relative to the square of the number of joints: 12,800 rows of 32
/// joints. Fewer joints than [`FEW_JOINTS`] count as many.
const MAX_WORK: usize = 400;
const FEW_JOINTS: usize = 32;

/// The workspace of the answers X_k.
#[derive(Default)]
pub struct RelaxedLevels {
    /// x^f, the answer without limits and without inequality rows.
    pub free: Solution,
    problem: Hierarchy,
    /// Number of levels of hard inequalities above the tasks.
    hard: usize,
    /// The point that the next problem stays near to, at first x^s.
    near: Vec<f64>,
    /// τ: how much of the way from the middle of the box to x^f is in the box.
    scale: f64,
    guess: WorkingSet,
    /// Work of all problems so far, in entries of rows.
    work: usize,
    /// The bounds that are active in the last answer, with the rows of the exact problem.
    active: WorkingSet,
}

impl RelaxedLevels {
    /// Begins an answer.
    pub fn clear(&mut self) {
        self.work = 0;
    }

    /// Returns whether X_k and X_hard can both be computed without more work than an answer may take.
    pub fn has_time_for(&self, levels: &Hierarchy, kept: usize) -> bool {
        let chain = |first: usize| (first..levels.levels.len()).map(|level| work(levels, level)).sum::<usize>();
        self.work + chain(kept) + chain(self.hard) <= most_work(levels)
    }

    /// Computes x^f and τ.
    pub fn start(&mut self, levels: &Hierarchy, hard: usize, engine: &mut Engine, exact: &Solution) {
        self.hard = hard;
        self.active.copy_from(&exact.working_set);
        let problem = &mut self.problem;
        problem.clear(&levels.reference[..levels.unknowns]);
        for level in &levels.levels {
            for row in level.rows().filter(|&row| levels.rows[row].is_equation()) {
                problem.push_equation(levels.row(row).iter().copied(), levels.rows[row].lower);
            }
            problem.end_level();
        }
        engine.solve(problem, Start::default(), &mut self.free);
        self.scale = 1.0;
        for (&x, (lower, upper)) in self.free.x.iter().zip(levels.bounds()) {
            let middle = middle(lower, upper);
            let (width, distance) = (if x > middle { upper - middle } else { middle - lower }, (x - middle).abs());
            // A pinned joint has no way inside the box.
            if distance > width && width > 0.0 {
                self.scale = self.scale.min(width / distance);
            }
        }
    }

    /// Computes X_k, k = `kept`: the first k levels exactly, then one problem for each level below. It stays near the answer of
    /// the problem before, and nearer in what the levels between have achieved. Levels that would take too much work are not reached
    /// for, and the answer is then not certain.
    pub fn solve(
        &mut self,
        levels: &Hierarchy,
        kept: usize,
        damping: Damping,
        engine: &mut Engine,
        found: &mut Solution,
    ) {
        let near = |(x, (lower, upper)): (&f64, (f64, f64))| {
            let middle = middle(lower, upper);
            (middle + self.scale * (x - middle)).max(lower).min(upper)
        };
        refill(&mut self.near, self.free.x.iter().zip(levels.bounds()).map(near));
        let mut certainty = Certainty::default();
        for level in kept..levels.levels.len() {
            self.work += work(levels, level);
            if self.work > most_work(levels) && level > kept {
                certainty.is_optimal = false;
                break;
            }
            self.write(levels, kept, level, 1.0 + 1.0 / damping.max_factor());
            // The first rows are those of the exact problem, some of them with other bounds.
            let end = levels.levels[level].end;
            self.guess.clear(levels.unknowns, self.problem.rows.len());
            self.guess.unknowns.copy_from_slice(&self.active.unknowns);
            self.guess.rows[..end].copy_from_slice(&self.active.rows[..end]);
            let reached_from = levels.levels[kept].start;
            let reached = self.problem.inequalities.iter().filter(|&&row| row >= reached_from).count();
            // Among many rows that are reached for, most guesses are wrong.
            let guess = (reached <= levels.unknowns).then_some(&self.guess);
            engine.solve(&self.problem, Start { guess, is_factorized: false }, found);
            self.active.unknowns.copy_from_slice(&found.working_set.unknowns);
            self.active.rows[..end].copy_from_slice(&found.working_set.rows[..end]);
            certainty.add(&found.certainty);
            self.near.clone_from(&found.x);
        }
        refill(&mut found.row_values, (0..levels.rows.len()).map(|row| levels.value(row, &self.near)));
        found.certainty = certainty;
    }

    /// Writes the problem that reaches for one level: the first `kept` levels, then a level of rows that reach for it, rows
    /// that keep what the levels between have achieved, and the distance from the point before.
    fn write(&mut self, levels: &Hierarchy, kept: usize, reached: usize, weight: f64) {
        let Self { free, problem, near, hard, scale, .. } = self;
        problem.clear(near);
        problem.lower.copy_from_slice(&levels.lower);
        problem.upper.copy_from_slice(&levels.upper);
        for level in 0..=reached {
            let rows = levels.levels[level].rows();
            if level < kept {
                push_rows(problem, levels, rows, 1.0, None);
                problem.end_level();
            } else if level < reached {
                push_rows(problem, levels, rows, KEPT * weight, Some((near, 1.0)));
            } else {
                let factor = if level == *hard { FIRST } else { 1.0 };
                push_rows(problem, levels, rows, factor * weight, Some((&free.x, *scale)));
            }
        }
        problem.push_near(1.0, near);
        problem.end_level();
    }
}

/// Returns the work of the problem that reaches for a level.
fn work(levels: &Hierarchy, level: usize) -> usize {
    levels.unknowns * (2 * levels.unknowns + levels.levels[level].end)
}

fn most_work(levels: &Hierarchy) -> usize {
    MAX_WORK * levels.unknowns.max(FEW_JOINTS).pow(2)
}

/// Adds rows of the levels with a weight. With a point and a part τ, equations aim at b + τ (a·point − b), and bounds that the
/// point violates are moved by the part τ of the violation.
fn push_rows(
    problem: &mut Hierarchy,
    levels: &Hierarchy,
    rows: std::ops::Range<usize>,
    weight: f64,
    aim: Option<(&[f64], f64)>,
) {
    for row in rows {
        let Demand { mut lower, mut upper, .. } = levels.rows[row];
        if let Some((point, part)) = aim {
            let value = levels.value(row, point);
            if levels.rows[row].is_equation() {
                lower += part * (value - lower);
                upper = lower;
            } else {
                lower += part * (value - lower).min(0.0);
                upper += part * (value - upper).max(0.0);
            }
        }
        let demand = Demand::between(weight * lower, weight * upper, None);
        problem.push_row(levels.row(row).iter().map(|a| weight * a), demand);
    }
}

/// Returns the middle between two bounds. Bounds farther apart mean none: the speed next to zero that is [`WIDEST`] inside, and
/// with one bound or none, the one that is [`HALF_WIDTH`] inside.
fn middle(lower: f64, upper: f64) -> f64 {
    let half_width = 0.5 * (upper - lower);
    if half_width <= WIDEST {
        return 0.5 * (lower + upper);
    }
    let inside = if half_width.is_finite() { WIDEST } else { HALF_WIDTH };
    0.0_f64.max(lower + inside).min(upper - inside)
}
