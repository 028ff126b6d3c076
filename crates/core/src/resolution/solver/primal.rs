//! The primal active-set method: from a feasible point, one change of the working set at a time.

use super::conditions::Conditions;
use super::factorization::Factorization;
use super::problem_rows::ProblemRows;
use crate::linalg::Row;
use crate::resolution::Side;
use crate::resolution::solution::WorkingSet;

/// What blocks a step.
#[derive(Clone, Copy)]
enum Blocking {
    Unknown(usize),
    Row(usize),
}

/// A feasible point whose level values never get worse.
#[derive(Debug, Default)]
pub struct PrimalPoint<const N: usize> {
    pub(super) point: Option<Row<N>>,
    /// Whether the last step had length zero.
    is_stuck: bool,
    /// The sets since the last call of [`Self::forget_sets`], as hashes.
    visited: Vec<u64>,
}

/// How often a set may come back. A point that moves may meet one again; a circle has no end.
const MOST_RETURNS: usize = 2;

impl<const N: usize> PrimalPoint<N> {
    /// Forgets the point.
    pub fn clear(&mut self) {
        (self.point, self.is_stuck) = (None, false);
        self.visited.clear();
    }

    /// Notes the present set; returns whether sets repeat.
    pub fn repeats(&mut self, set: &WorkingSet) -> bool {
        let present = hash(set);
        let returns = self.visited.iter().filter(|visited| **visited == present).count();
        self.visited.push(present);
        returns > MOST_RETURNS
    }

    /// Begins to look for repetitions once more.
    pub fn forget_sets(&mut self) {
        self.visited.clear();
    }

    /// Changes the working set by one step of the method (section 6).
    pub fn step(
        &mut self,
        problem: &ProblemRows<N>,
        solved: &Factorization<N>,
        conditions: &Conditions<N>,
        set: &mut WorkingSet,
    ) {
        let Some(point) = self.point else {
            let start = solved.x.clamp(&problem.lower, &problem.upper);
            self.point = Some(start);
            if restrict_to(&start, problem, solved, set) {
                return;
            }
            return self.step(problem, solved, conditions, set);
        };
        if let Some((length, blocking)) = first_blocking(&point, problem, solved, conditions, set) {
            self.is_stuck = length == 0.0;
            let mut next = point;
            next.add_scaled(length, &solved.x.minus(&point));
            activate(blocking, &mut next, &point, problem, solved, conditions, set, self.is_stuck);
            self.point = Some(next.clamp(&problem.lower, &problem.upper));
        } else {
            self.point = Some(solved.x.clamp(&problem.lower, &problem.upper));
            release(conditions, set, self.is_stuck);
        }
    }
}

/// Returns a number that differs for different sets (FNV-1a).
fn hash(set: &WorkingSet) -> u64 {
    let sides = set.unknowns.iter().chain(&set.rows);
    sides.fold(0xcbf2_9ce4_8422_2325, |hash, side| {
        let side = match side {
            None => 0,
            Some(Side::Lower) => 1,
            Some(Side::Upper) => 2,
        };
        (hash ^ side).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Holds what is at its bound at the start and active or pushed outwards, and the rows broken there; returns whether the
/// set changed.
fn restrict_to<const N: usize>(
    start: &Row<N>,
    problem: &ProblemRows<N>,
    solved: &Factorization<N>,
    set: &mut WorkingSet,
) -> bool {
    let mut changed = false;
    for j in (0..problem.unknowns).filter(|&j| !problem.is_pinned(j)) {
        let (z, x) = (start.0[j], solved.x.0[j]);
        let (at_lower, at_upper) = (z <= problem.lower.0[j], z >= problem.upper.0[j]);
        let side = match set.unknowns[j] {
            Some(Side::Upper) if at_upper => Some(Side::Upper),
            Some(Side::Lower) if at_lower => Some(Side::Lower),
            None if at_upper && x > z => Some(Side::Upper),
            None if at_lower && x < z => Some(Side::Lower),
            _ => None,
        };
        changed |= side != set.unknowns[j];
        set.unknowns[j] = side;
    }
    for &row in problem.inequalities {
        let value = start.dot(&problem.coefficients[row]);
        let side = if value > problem.rows[row].upper {
            Some(Side::Upper)
        } else if value < problem.rows[row].lower {
            Some(Side::Lower)
        } else {
            None
        };
        changed |= side != set.rows[row];
        set.rows[row] = side;
    }
    changed
}

/// Returns the first bound that is met on the way from `point` to the least-squares point, and how far along (0 to 1).
fn first_blocking<const N: usize>(
    point: &Row<N>,
    problem: &ProblemRows<N>,
    solved: &Factorization<N>,
    conditions: &Conditions<N>,
    set: &WorkingSet,
) -> Option<(f64, Blocking)> {
    let mut first = None;
    let mut nearest = 1.0;
    for &j in conditions.wrong.iter().filter(|&&j| set.unknowns[j].is_none()) {
        let (z, x) = (point.0[j], solved.x.0[j]);
        let bound = if x > problem.upper.0[j] { problem.upper.0[j] } else { problem.lower.0[j] };
        let length = ((bound - z) / (x - z)).max(0.0);
        if length < nearest {
            (nearest, first) = (length, Some(Blocking::Unknown(j)));
        }
    }
    for &row in &conditions.wrong_rows {
        let (z, x) = (point.dot(&problem.coefficients[row]), conditions.values[row]);
        let bound = match set.rows[row] {
            None if x > problem.rows[row].upper => problem.rows[row].upper,
            None => problem.rows[row].lower,
            // A broken row that is kept at the least-squares point: it meets its bound on the way.
            Some(side) if side.sign() * (x - problem.target(set, row)) < 0.0 => problem.target(set, row),
            Some(_) => continue,
        };
        if (x - z) * (bound - x) > 0.0 {
            continue;
        }
        let length = if x == z { 0.0 } else { ((bound - z) / (x - z)).max(0.0) };
        if length < nearest {
            (nearest, first) = (length, Some(Blocking::Row(row)));
        }
    }
    first.map(|blocking| (nearest, blocking))
}

/// Activates a blocking bound, or releases a broken row that is now kept. Without a step, all unknowns that block at once
/// are held.
#[expect(clippy::too_many_arguments, reason = "one step of the method needs its whole state")]
fn activate<const N: usize>(
    blocking: Blocking,
    next: &mut Row<N>,
    point: &Row<N>,
    problem: &ProblemRows<N>,
    solved: &Factorization<N>,
    conditions: &Conditions<N>,
    set: &mut WorkingSet,
    is_stuck: bool,
) {
    if is_stuck {
        for &j in &conditions.wrong {
            let (x, z) = (solved.x.0[j], point.0[j]);
            if set.unknowns[j].is_some() {
                continue;
            }
            if x > problem.upper.0[j] && z >= problem.upper.0[j] {
                set.unknowns[j] = Some(Side::Upper);
            } else if x < problem.lower.0[j] && z <= problem.lower.0[j] {
                set.unknowns[j] = Some(Side::Lower);
            }
        }
    }
    match blocking {
        Blocking::Unknown(j) if solved.x.0[j] > point.0[j] => {
            set.unknowns[j] = Some(Side::Upper);
            next.0[j] = problem.upper.0[j];
        }
        Blocking::Unknown(j) => {
            set.unknowns[j] = Some(Side::Lower);
            next.0[j] = problem.lower.0[j];
        }
        Blocking::Row(row) => {
            let value = conditions.values[row];
            set.rows[row] = match set.rows[row] {
                None if value > problem.rows[row].upper => Some(Side::Upper),
                None => Some(Side::Lower),
                Some(_) => None,
            };
        }
    }
}

/// Releases the bounds whose multipliers point inwards: all of them, or after a step of length zero only the first one.
/// Conditions list them from the highest level on.
fn release<const N: usize>(conditions: &Conditions<N>, set: &mut WorkingSet, only_first: bool) {
    let mut released = false;
    for &j in &conditions.wrong {
        if set.unknowns[j].is_some() && !(only_first && released) {
            set.unknowns[j] = None;
            released = true;
        }
    }
    for &row in &conditions.wrong_rows {
        if set.rows[row].is_some() && !(only_first && released) {
            set.rows[row] = None;
            released = true;
        }
    }
}
