//! Exact solutions on a set of active limits, and the search for the right set.
#![allow(non_snake_case)]

use smallvec::SmallVec;

use super::level::Level;
use super::minimiser::{Conditions, Minimiser};
use crate::linalg::TaskVector;

/// Which bound of a joint; inequalities have an upper one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// q̇ ≥ lo.
    Lower,
    /// q̇ ≤ hi, a·q̇ ≤ b.
    Upper,
}

impl Side {
    /// Direction in which the bound is met.
    pub fn sign(self) -> f64 {
        match self {
            Self::Lower => -1.0,
            Self::Upper => 1.0,
        }
    }
}

/// The active limits of one level, in order: joints by index from 0, then inequalities, counted on; and the side.
pub type ActiveSet = SmallVec<[(usize, Side); 8]>;

/// Bounds count as kept up to this, relative to the speeds that the level deals with; the rest is clamped away.
const FEASIBILITY: f64 = 1e-13;

/// Residual of the optimality conditions, relative to the level's size, above which a set is not the right one.
///
/// Exact answers stay below 1e-14. Whatever is allowed here returns divided by the smallest singular value.
const OPTIMALITY: f64 = 1e-12;

/// Change of C z, relative to the level's size, that is rounding: a move that achieves no more is not made. In a corner it
/// would run into limits that depend on the active ones.
const ARRIVED: f64 = 1e-13;

/// Fraction of a move that, along a limit, is rounding and no approach.
const APPROACH: f64 = 1e-13;

/// A point with the optimality conditions evaluated.
pub struct Candidate {
    /// z, p.
    pub z: TaskVector,
    /// Signed multipliers, per row; positive at the upper bound.
    pub multipliers: TaskVector,
    /// By how much ‖C z − d‖ would fall, to first order and relative to its size, if only this limit were moved away,
    /// per row; ≥ 0.
    pub relief: TaskVector,
    /// The set that the point was computed on.
    pub active_set: ActiveSet,
    /// Relative residual of stationarity and multiplier signs; infinite where a bound is broken.
    pub kkt_residual: f64,
}

impl Candidate {
    /// Stays at z = 0: the solution of a level that nothing open can influence.
    pub fn stay(level: &Level) -> Self {
        Self {
            z: TaskVector::zeros(level.unknowns()),
            multipliers: TaskVector::zeros(level.G.nrows()),
            relief: TaskVector::zeros(level.G.nrows()),
            active_set: ActiveSet::new(),
            kkt_residual: 0.0,
        }
    }

    fn new(level: &Level, minimiser: &Minimiser, conditions: &Conditions) -> Self {
        let Minimiser { z, active, .. } = minimiser;
        let mut candidate = Self { z: z.clone(), active_set: SmallVec::from_slice(active), ..Self::stay(level) };
        for (place, &(row, _)) in active.iter().enumerate() {
            if conditions.relief[place] > OPTIMALITY {
                candidate.multipliers[row] = conditions.multipliers[place];
                candidate.relief[row] = conditions.relief[place];
            }
        }
        let residual = conditions.relief.iter().fold(conditions.stationarity, |worst, relief| worst.max(-relief));
        let feasible = broken(level, z).next().is_none();
        candidate.kkt_residual = if feasible { residual } else { f64::INFINITY };
        candidate
    }

    /// Whether the point solves the level.
    pub fn is_optimal(&self) -> bool {
        self.kkt_residual <= OPTIMALITY
    }
}

/// Bounds that a point breaks.
fn broken(level: &Level, z: &TaskVector) -> impl Iterator<Item = (usize, Side)> {
    let (values, rounding) = (&level.G * z, FEASIBILITY * (level.speed + z.norm()));
    (0..level.G.nrows()).filter(|&row| level.bounded[row]).filter_map(move |row| {
        let above = !(values[row] - level.upper[row] <= rounding);
        let below = !(level.lower[row] - values[row] <= rounding);
        (above || below).then_some((row, if above { Side::Upper } else { Side::Lower }))
    })
}

/// Solves the level on a guessed set, as near to z = 0 as it leaves open, and says whether the guess was right.
///
/// Limits of the guess that are no constraints of this level, or follow from the others, are left out.
pub fn polish(level: &Level, guess: &[(usize, Side)], minimiser: &mut Minimiser) -> Candidate {
    let known: ActiveSet = guess.iter().copied().filter(|&limit| level.has(limit)).collect();
    minimiser.try_set(level, &known);
    let conditions = minimiser.conditions(level);
    Candidate::new(level, minimiser, &conditions)
}

/// Solves the level from a guessed set on: by corrections where these arrive, which takes few sets, otherwise by
/// [`iterate`]; `None` where neither finds an answer whose optimality conditions hold.
pub fn search(level: &Level, guess: &[(usize, Side)], minimiser: &mut Minimiser) -> Option<Candidate> {
    #[cfg(test)]
    if super::clarabel_level::fault::strikes() {
        return None;
    }
    correct(level, guess, minimiser).or_else(|| Some(iterate(level, minimiser)).filter(Candidate::is_optimal))
}

/// Residual up to which a set that was guessed counts as the right one: stricter than [`OPTIMALITY`], for among many sets
/// some are wrong by little.
const CONFIRMED: f64 = 1e-13;

/// Sets that [`correct`] tries: most guesses are right or off by one limit, and some need a few more.
const MOST_CORRECTIONS: usize = 8;

/// Solves the level on a guessed set and, where it is not the right one, on the set that the answer suggests: without the
/// limits whose multipliers point inwards, with those that are broken (a primal-dual active-set method).
///
/// `None` where that does not arrive: it need not, but where it does, the optimality conditions say so.
fn correct(level: &Level, guess: &[(usize, Side)], minimiser: &mut Minimiser) -> Option<Candidate> {
    let mut active: ActiveSet = guess.iter().copied().filter(|&limit| level.has(limit)).collect();
    for _ in 0..MOST_CORRECTIONS {
        minimiser.try_set(level, &active);
        let conditions = minimiser.conditions(level);
        let candidate = Candidate::new(level, minimiser, &conditions);
        if candidate.kkt_residual <= CONFIRMED {
            return Some(candidate);
        }
        let right = |place: usize| conditions.relief[place] >= -CONFIRMED;
        let tried = &candidate.active_set;
        active = (0..tried.len()).filter(|&place| right(place)).map(|place| tried[place]).collect();
        active.extend(broken(level, &candidate.z).filter(|&(row, _)| tried.iter().all(|&(held, _)| held != row)));
        if active == *tried {
            return None;
        }
        active.sort_by_key(|&(row, _)| row);
    }
    None
}

/// A primal active-set method from z = 0: exact, finite, used where a guess fails.
///
/// Ties are broken by the smallest index (Bland), so that degenerate corners do not cycle.
pub fn iterate(level: &Level, minimiser: &mut Minimiser) -> Candidate {
    #[cfg(test)]
    if super::clarabel_level::fault::strikes_search() {
        return polish(level, &[], minimiser);
    }
    let mut z = TaskVector::zeros(level.unknowns());
    let mut active = ActiveSet::new();
    let mut best: Option<Candidate> = None;
    // Far more than the 2n changes that problems of this size take; only rounding could ask for more.
    for _ in 0..20 * (level.G.nrows() + 1) {
        minimiser.find(level, &z, &active);
        let target = &mut minimiser.z;
        if (&level.C * &(&*target - &z)).norm() <= ARRIVED * level.size(&z) {
            target.clone_from(&z);
        } else if let Some((step, limit)) = blocking(level, &z, target, &active) {
            z.add_scaled(step, &(&*target - &z));
            active.push(limit);
            active.sort_by_key(|&(row, _)| row);
            continue;
        }
        z.clone_from(target);
        let conditions = minimiser.conditions(level);
        let candidate = Candidate::new(level, minimiser, &conditions);
        if best.as_ref().is_none_or(|best| candidate.kkt_residual < best.kkt_residual) {
            best = Some(candidate);
        }
        match conditions.relief.iter().position(|&relief| relief < -OPTIMALITY) {
            Some(wrong) => drop(active.remove(wrong)),
            None => break,
        }
    }
    best.unwrap_or_else(|| polish(level, &active, minimiser))
}

/// The first limit met on the way from `z` to `target`, and how far along.
fn blocking(level: &Level, z: &TaskVector, target: &TaskVector, active: &ActiveSet) -> Option<(f64, (usize, Side))> {
    let way = target - z;
    let (position, direction) = (&level.G * z, &level.G * &way);
    let mut first: Option<(f64, (usize, Side))> = None;
    for (row, side, bound) in level.constraints() {
        let approach = side.sign() * direction[row];
        // A limit that the move does not approach, or that the set holds already, cannot block.
        if approach <= APPROACH * way.norm() || active.iter().any(|&(held, _)| held == row) {
            continue;
        }
        let step = (side.sign() * (bound - position[row])).max(0.0) / approach;
        if step < first.map_or(1.0, |(nearest, _)| nearest) {
            first = Some((step, (row, side)));
        }
    }
    first
}
