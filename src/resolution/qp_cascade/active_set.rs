//! Exact solutions on a set of active limits, and the search for the right set.
#![allow(non_snake_case)]

use smallvec::SmallVec;

use super::level::Level;
use crate::linalg::{Decomposition, TaskMatrix, TaskVector};
use crate::resolution::certificate::relative;

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
    fn sign(self) -> f64 {
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

/// Effect of a limit on ‖C z − d‖, relative to the norm of C, below which its multiplier is taken with a pinch of salt.
///
/// A multiplier carries rounding of 1e-16; the relief that it promises is the multiplier divided by this effect.
const SENSITIVITY: f64 = 1e-3;

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

    fn new(level: &Level, minimiser: Minimiser, active: ActiveSet, conditions: &Conditions) -> Self {
        let n = level.G.nrows();
        let (mut multipliers, mut relief) = (TaskVector::zeros(n), TaskVector::zeros(n));
        for (place, &(row, _)) in active.iter().enumerate() {
            if conditions.relief[place] > OPTIMALITY {
                multipliers[row] = conditions.multipliers[place];
                relief[row] = conditions.relief[place];
            }
        }
        let residual = conditions.relief.iter().fold(conditions.stationarity, |worst, relief| worst.max(-relief));
        let feasible = level.constraints().all(|constraint| keeps(level, &minimiser.z, constraint));
        Self {
            kkt_residual: if feasible { residual } else { f64::INFINITY },
            active_set: active,
            multipliers,
            relief,
            z: minimiser.z,
        }
    }

    /// Whether the point solves the level.
    pub fn is_optimal(&self) -> bool {
        self.kkt_residual <= OPTIMALITY
    }
}

/// The optimality conditions at a minimiser, measured as what could still be gained of ‖C z − d‖.
///
/// With the residual r = C z − d, a basis Q of the range of C N (what the set leaves open) and M = (I − Q Qᵀ) C G_W⁺
/// (how r changes with each bound of the set), the conditions are Qᵀ r = 0 and multipliers m = −Mᵀ r that point
/// outwards. Moving bound i alone changes ‖r‖ by m_i / ‖M_i‖ per unit of change in r: its relief. The usual gradient
/// Cᵀ r in place of these shrinks with the square of a small singular value and would call wrong sets right.
struct Conditions {
    /// Signed multipliers, in the order of the set; positive: pressed upwards.
    multipliers: TaskVector,
    /// Relative relief, in the order of the set; negative where the multiplier points inwards.
    relief: TaskVector,
    /// ‖Qᵀ r‖_∞, relative.
    stationarity: f64,
}

impl Conditions {
    fn new(level: &Level, minimiser: &Minimiser, active: &ActiveSet) -> Self {
        let (size, Q) = (level.size(&minimiser.z), &minimiser.range);
        let residual = &(&level.C * &minimiser.z) - &level.d;
        let mut conditions = Self {
            multipliers: TaskVector::zeros(active.len()),
            relief: TaskVector::zeros(active.len()),
            stationarity: relative((Q * &residual).amax(), size),
        };
        for (place, &(_, side)) in active.iter().enumerate() {
            let per_bound = minimiser.limits.solve(&TaskVector::unit(active.len(), place));
            let mut M = &level.C * &per_bound;
            M -= &Q.transposed_times(&(Q * &M));
            let multiplier = -M.dot(&residual);
            let effect = M.norm().max(SENSITIVITY * level.scale * per_bound.norm());
            conditions.multipliers[place] = multiplier;
            let outwards = side.sign() * multiplier;
            conditions.relief[place] = relative(outwards.abs(), effect * size).copysign(outwards);
        }
        conditions
    }
}

fn keeps(level: &Level, z: &TaskVector, (row, side, bound): (usize, Side, f64)) -> bool {
    let excess = side.sign() * (level.value(row, z) - bound);
    excess <= FEASIBILITY * (level.speed + z.norm())
}

/// G_W, the set's rows of G.
fn active_rows(level: &Level, active: &ActiveSet) -> TaskMatrix {
    let mut rows = TaskMatrix::zeros(0, level.unknowns());
    active.iter().for_each(|&(row, _)| rows.push_row(&level.G[row]));
    rows
}

fn active_bounds(level: &Level, active: &ActiveSet) -> TaskVector {
    TaskVector::from_fn(active.len(), |i| level.bound(active[i].0, active[i].1))
}

/// The minimiser of ‖C z − d‖² with the limits of a set as equalities.
struct Minimiser {
    /// z, p; the one nearest to where the search began, if there are many.
    z: TaskVector,
    /// Decomposition of G_W.
    limits: Decomposition,
    /// Orthonormal basis of the range of C N, with N the null space of G_W, as rows.
    range: TaskMatrix,
}

impl Minimiser {
    fn new(level: &Level, near: &TaskVector, active: &ActiveSet) -> Self {
        let G_W = active_rows(level, active);
        let limits = Decomposition::with_scale(&G_W, 1.0);
        let mut z = near + &limits.solve(&(&active_bounds(level, active) - &(&G_W * near)));
        let mut C = level.C.clone();
        limits.rows_to_frame(&mut C);
        let mut open = Decomposition::default();
        open.decompose(&C, limits.rank(), level.scale);
        let mut way = open.solve(&(&level.d - &(&level.C * &z)));
        limits.from_frame(&mut way);
        z += &way;
        Self { z, limits, range: open.range() }
    }
}

/// The limits of a guess that are constraints of this level, without those that follow from the others.
fn independent(level: &Level, guess: &ActiveSet) -> ActiveSet {
    let known = |guess: (usize, Side)| level.constraints().any(|(row, side, _)| (row, side) == guess);
    let mut active: ActiveSet = guess.iter().copied().filter(|&limit| known(limit)).collect();
    let rank = |active: &ActiveSet| Decomposition::with_scale(&active_rows(level, active), 1.0).rank();
    if rank(&active) < active.len() {
        for limit in std::mem::take(&mut active) {
            active.push(limit);
            if rank(&active) < active.len() {
                active.pop();
            }
        }
    }
    active
}

/// Solves the level on a guessed set, as near to z = 0 as it leaves open, and says whether the guess was right.
///
/// Limits of the guess that are no constraints of this level, or follow from the others, are left out.
pub fn polish(level: &Level, guess: &ActiveSet) -> Candidate {
    let active = independent(level, guess);
    let minimiser = Minimiser::new(level, &TaskVector::zeros(level.unknowns()), &active);
    let conditions = Conditions::new(level, &minimiser, &active);
    Candidate::new(level, minimiser, active, &conditions)
}

/// A primal active-set method from z = 0: exact, finite, used where a guess fails.
///
/// Ties are broken by the smallest index (Bland), so that degenerate corners do not cycle.
pub fn iterate(level: &Level) -> Candidate {
    #[cfg(test)]
    if super::clarabel_level::fault::strikes_search() {
        return polish(level, &ActiveSet::new());
    }
    let mut z = TaskVector::zeros(level.unknowns());
    let mut active = ActiveSet::new();
    let mut best: Option<Candidate> = None;
    // Far more than the 2n changes that problems of this size take; only rounding could ask for more.
    for _ in 0..20 * (level.G.nrows() + 1) {
        let mut target = Minimiser::new(level, &z, &active);
        if (&level.C * &(&target.z - &z)).norm() <= ARRIVED * level.size(&z) {
            target.z = z.clone();
        } else if let Some((step, limit)) = blocking(level, &z, &target.z, &active) {
            z.add_scaled(step, &(&target.z - &z));
            active.push(limit);
            active.sort_by_key(|&(row, _)| row);
            continue;
        }
        z = target.z.clone();
        let conditions = Conditions::new(level, &target, &active);
        let candidate = Candidate::new(level, target, active.clone(), &conditions);
        if best.as_ref().is_none_or(|best| candidate.kkt_residual < best.kkt_residual) {
            best = Some(candidate);
        }
        match conditions.relief.iter().position(|&relief| relief < -OPTIMALITY) {
            Some(wrong) => drop(active.remove(wrong)),
            None => break,
        }
    }
    best.unwrap_or_else(|| polish(level, &active))
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
